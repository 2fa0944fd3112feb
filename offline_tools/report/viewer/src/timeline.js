import { fixed, html } from './markup.js';

// The replay's controls: play and pause, how fast, and a track of the flight's states with its events to scrub along.

const kSpeeds = [0.25, 0.5, 1, 2, 4, 8];
const kStep = 1;  // [s] of an arrow key
const kLongStep = 5;  // [s] with shift
const kLeastShare = 0.05;  // of the track: a state is named on it where it lasts longer

const percent = (share) => `${(100 * share).toFixed(3)}%`;

function span_markup(style, { name, t, end }, duration) {
  const share = (end - t) / duration;
  return html`<span class="${style} state-${name}" style="left:${percent(t / duration)};width:${percent(share)}" title="${name}, ${fixed(t, 1)} to ${fixed(end, 1)} s">${
    share > kLeastShare && name}</span>`;
}

/// `states` and `phases` are spans { name, t, end } [s]; `events` are { t, kind, what }.
export function timeline_markup({ duration, states, phases, events }) {
  const mark = (event, i) => html`<button type="button" tabindex="-1" aria-hidden="true" class="event ${event.kind}" data-event="${i}"
    style="left:${percent(event.t / duration)}" title="${fixed(event.t, 2)} s: ${event.what}"></button>`;
  return html`<section class="timeline" aria-label="Replay">
    <div class="transport">
      <button type="button" class="play" aria-label="Play" title="Play or pause (space)"></button>
      <label class="pace"><select aria-label="Speed of the replay">${kSpeeds.map((speed) =>
        html`<option value="${speed}" ${speed === 1 ? 'selected' : ''}>${speed}×</option>`)}</select></label>
      <span class="clock"><b></b> of ${fixed(duration, 1)} s</span>
      <span class="pill state"></span>
      <span class="now"></span>
      <button type="button" class="jump" data-jump="-1" aria-label="Event before" title="Event before">‹</button>
      <button type="button" class="jump" data-jump="1" aria-label="Next event" title="Next event">›</button>
    </div>
    <div class="track">
      <div class="events">${events.map(mark)}</div>
      <div class="states">${states.map((state) => span_markup('state', state, duration))}</div>
      <div class="phases">${phases.map((phase) => span_markup('phase', phase, duration))}</div>
      <input type="range" min="0" max="${duration}" step="any" value="0" aria-label="Time of the flight [s]">
    </div>
  </section>`;
}

/// Time to jump to from t: the next event after it, or with `direction` -1 the last one before it; null without any.
export function neighbour_event(events, t, direction) {
  const beyond = events.map((event) => event.t).filter((time) => (time - t) * direction > 1e-3);
  if (beyond.length === 0) return null;
  return direction > 0 ? Math.min(...beyond) : Math.max(...beyond);
}

/// Keeps the time of the replay. `on_time(t)` comes with every change of it.
export class Player {
  constructor(host, { duration, events, on_time }) {
    Object.assign(this, { host, duration, events, on_time, time: 0, pace: 1 });
    this.range = host.querySelector('.track input');
    this.button = host.querySelector('.play');
    this.clock = host.querySelector('.clock b');
    this.button.addEventListener('click', () => this.toggle());
    this.range.addEventListener('input', () => this.seek(Number(this.range.value)));
    host.querySelector('select').addEventListener('change', (event) => (this.pace = Number(event.target.value)));
    host.querySelectorAll('[data-jump]').forEach((button) => {
      button.addEventListener('click', () => this.seek(neighbour_event(events, this.time, Number(button.dataset.jump)) ?? this.time));
    });
    host.querySelectorAll('[data-event]').forEach((mark) => {
      mark.addEventListener('click', () => this.seek(events[mark.dataset.event].t));
    });
    document.addEventListener('keydown', (event) => this.#press(event));
  }

  seek(t) {
    this.time = Math.min(Math.max(t, 0), this.duration);
    this.range.value = this.time;
    this.clock.textContent = fixed(this.time, 1);
    this.on_time(this.time);
  }

  /// What a screen reader says of the present moment.
  describe(text) {
    this.range.setAttribute('aria-valuetext', text);
  }

  toggle() {
    if (this.playing) return this.#pause();
    if (this.time >= this.duration) this.seek(0);
    this.#show_playing(true);
    let before = performance.now();
    const advance = (now) => {
      if (!this.playing) return;
      const step = Math.max(now - before, 0) / 1000;
      before = Math.max(now, before);
      this.seek(this.time + this.pace * step);
      if (this.time >= this.duration) this.#pause();
      else requestAnimationFrame(advance);
    };
    requestAnimationFrame(advance);
  }

  #pause() {
    this.#show_playing(false);
  }

  #show_playing(playing) {
    this.playing = playing;
    this.button.classList.toggle('playing', playing);
    this.button.setAttribute('aria-label', playing ? 'Pause' : 'Play');
  }

  /// Keys of the page as a whole, but where a control has its own use of them.
  #press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || is_own_key(event, this.range)) return;
    const step = event.shiftKey ? kLongStep : kStep;
    const action = { ' ': () => this.toggle(), ArrowLeft: () => this.seek(this.time - step), ArrowRight: () => this.seek(this.time + step),
                     Home: () => this.seek(0), End: () => this.seek(this.duration) }[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }
}

/// True where the control in focus takes the key: a button or a box the space, a list or another slider the rest.
function is_own_key({ key, target }, range) {
  if (target === range || !target.closest?.('button, input, select, summary, a')) return false;
  const pressed = target.matches('button, summary, a, input[type=checkbox]');
  return pressed ? key === ' ' : true;
}
