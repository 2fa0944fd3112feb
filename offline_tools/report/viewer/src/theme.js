// Light or dark: as the system says until the button, or `#theme=dark` in the address, says otherwise.

const kDark = window.matchMedia('(prefers-color-scheme: dark)');
const listeners = [];

function apply(theme) {
  document.documentElement.dataset.theme = theme;
  for (const listener of listeners) listener();
}

export function start_theme() {
  const asked = /theme=(light|dark)/.exec(location.hash)?.[1];
  apply(asked ?? (kDark.matches ? 'dark' : 'light'));
  if (!asked) kDark.addEventListener('change', () => apply(kDark.matches ? 'dark' : 'light'));
}

/// Connects the button of the page's header.
export function connect_theme(host) {
  host.querySelector('.theme').addEventListener('click', toggle_theme);
}

function toggle_theme() {
  apply(document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark');
}

export function on_theme(listener) {
  listeners.push(listener);
}
