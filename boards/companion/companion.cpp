#include "companion/companion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace swiftlet::companion {
namespace {

// MAV_CMD that a ground station may send us.
constexpr std::uint16_t kCommandLand = 21;
constexpr std::uint16_t kCommandPauseContinue = 193;
constexpr std::uint16_t kCommandMissionStart = 300;

// Parameters of PX4.
constexpr std::string_view kHoverThrust = "MPC_THR_HOVER";
constexpr std::string_view kOffboardLossTime = "COM_OF_LOSS_T";  // [s]

constexpr Real kSameGoal = Real(0.01);       // [m] [rad] a ground station that repeats its goal
constexpr TimeUs kStream = 3 * kSecondUs;    // within which it says nothing new by that
constexpr TimeUs kAttitudeAgeMax = 100'000;  // behind the position, before it counts as missing
constexpr float kMostOfLimit = 100;          // [m/s] [m/s^2] that a parameter may ask for
static_assert(Real(static_cast<float>(kLeastLimit)) >= kLeastLimit && Real(kMostOfLimit) <= kLargestLimit);

TimeUs us(std::chrono::microseconds time) { return time.count(); }

bool same(const mavlink::Goal& a, const mavlink::Goal& b) {
  const bool same_yaw = a.yaw && b.yaw ? std::fabs(wrap_angle(*a.yaw - *b.yaw)) < kSameGoal : a.yaw == b.yaw;
  return same_yaw && (a.position - b.position).norm() < kSameGoal;
}

}  // namespace

// ---- Construction

std::array<mavlink::Parameter, Companion::kParameterCount> Companion::make_parameters(const Settings& settings) {
  const auto limit = [](std::string_view name, Real value) {
    return mavlink::Parameter{name, static_cast<float>(value), static_cast<float>(kLeastLimit), kMostOfLimit, true};
  };
  return {limit("SWF_VMAX", settings.limits.v_max), limit("SWF_AMAX", settings.limits.a_max),
          mavlink::Parameter{"SWF_MAP_RADIUS", 0, 0, 0, false}, mavlink::Parameter{"SWF_REQ_RADIUS", 0, 0, 0, false}};
}

mavlink::LinkConfig Companion::link_config(const Settings& settings, std::span<mavlink::Parameter> parameters) {
  mavlink::LinkConfig config;
  config.system_id = settings.system_id;
  config.parameters = parameters;
  config.signing = settings.signing;
  config.autopilot_signs = settings.autopilot_signs;
  return config;
}

SupervisorSettings Companion::supervisor_settings(const Settings& settings) {
  SupervisorSettings with_tube = settings.supervisor;
  with_tube.tracking_tube = tube_of(settings.margins.tubes, settings.form);
  return with_tube;
}

Companion::Companion(const Settings& settings, const BoxGraphView& map, const Memory& memory, const Devices& devices)
    : settings_(settings),
      parameters_(make_parameters(settings)),
      log_(devices.log),
      uart_(devices.autopilot, devices.log),
      link_(uart_, link_config(settings, parameters_)),
      journal_(link_),
      supervisor_(supervisor_settings(settings)),
      store_(memory.trajectories),
      replanner_(settings_, map, memory, devices.planner),
      mission_(settings_, link_, journal_),
      steering_(settings_) {
  check_map(map);
}

void Companion::check_map(const BoxGraphView& map) {
  const MarginReport report = mission_.margins(map);
  parameters_[kMapRadius].value = static_cast<float>(map.header().radius);
  parameters_[kRequiredRadius].value = static_cast<float>(report.required);
  if (report.verdict == MarginVerdict::kCovered) return;
  Line line("no flight in this map: its radius is ");
  line << static_cast<Real>(map.header().radius) << " m, the margins need " << report.required << " m";
  journal_.warn(line);
}

// ---- The operator

bool Companion::tell(const Word& word) {
  if (log_ != nullptr) log_->note_word(word);
  const bool usable = word.a.allFinite() && word.b.allFinite() && (!word.yaw || std::fabs(*word.yaw) <= kLargestInput);
  if (word.kind == Word::Kind::kLimits) {
    FlightLimits limits = settings_.limits;
    limits.v_max = word.a.x();
    limits.a_max = word.a.y();
    if (!is_usable(limits)) return false;
  }
  return usable && words_.try_push_back(word);
}

bool Companion::add_goal(const Vector3& position, std::optional<Real> yaw) {
  return tell({.kind = Word::Kind::kAddGoal, .a = position, .yaw = yaw});
}
bool Companion::set_goal(const Vector3& position, std::optional<Real> yaw) {
  return tell({.kind = Word::Kind::kSetGoal, .a = position, .yaw = yaw});
}
bool Companion::engage(bool on) { return tell({.kind = on ? Word::Kind::kEngage : Word::Kind::kRelease}); }
bool Companion::stop() { return tell({.kind = Word::Kind::kStop}); }
bool Companion::land() { return tell({.kind = Word::Kind::kLand}); }
bool Companion::block(std::uint32_t id, const Box& obstacle) {
  return tell({.kind = Word::Kind::kBlock, .id = id, .a = obstacle.lo, .b = obstacle.hi});
}
bool Companion::unblock(std::uint32_t id) { return tell({.kind = Word::Kind::kUnblock, .id = id}); }
bool Companion::set_limits(Real v_max, Real a_max) {
  return tell({.kind = Word::Kind::kLimits, .a = {v_max, a_max, 0}});
}

bool Companion::replace_map(const BoxGraphView& map, std::string_view file) {
  if (log_ != nullptr) log_->note_map(map.header().crc32, file);
  if (mission_.margins(map).verdict != MarginVerdict::kCovered) {
    journal_.warn("the new map is refused: its radius does not cover the margins");
    return false;
  }
  check_map(map);
  if (replanner_.replace_map(map) != Status::kOk) journal_.warn("not every blocked box fits into the new map");
  mission_.plan_anew();
  return true;
}

void Companion::obey() {
  while (const std::optional<Word> word = words_.pop_front()) carry_out(*word);
}

void Companion::carry_out(const Word& word) {
  switch (word.kind) {
    case Word::Kind::kAddGoal:
      mission_.add_goal(word.a, word.yaw, replanner_.map());
      return;
    case Word::Kind::kSetGoal:
      mission_.set_goal(word.a, word.yaw, replanner_.map());
      return;
    case Word::Kind::kEngage:
      return mission_.engage();
    case Word::Kind::kRelease:
      return mission_.release();
    case Word::Kind::kStop:
      return mission_.stop();
    case Word::Kind::kLand:
      mission_.land();
      return;
    case Word::Kind::kBlock:
      return block_box(word);
    case Word::Kind::kUnblock:
      if (!replanner_.unblock(word.id)) journal_.warn(Line("nothing is blocked under the number ") << word.id);
      return;
    case Word::Kind::kLimits:
      return change_limits(word.a.x(), word.a.y());
  }
}

/// What cannot be kept out of must not be flown by.
void Companion::block_box(const Word& word) {
  const Status status = replanner_.block(word.id, {word.a, word.b});
  if (status == Status::kOk) return;
  Line line("box ");
  line << word.id << " cannot be blocked: " << describe(status);
  if (status == Status::kBufferTooSmall) {
    line << "; stopping";
    mission_.stop();
  }
  journal_.warn(line);
}

void Companion::change_limits(Real v_max, Real a_max) {
  replanner_.set_limits(v_max, a_max);
  parameters_[kSpeed].value = static_cast<float>(v_max);
  parameters_[kAcceleration].value = static_cast<float>(a_max);
  mission_.plan_anew();
}

// ---- A step

void Companion::step(std::chrono::microseconds now) {
  if (log_ != nullptr) log_->begin_step(us(now));
  if (const TimeUs jump = supervisor_.clock_jump(us(now)); jump != 0) shift_clock(Microseconds(jump));
  receive(now);
  obey();
  mission_.observe(now_);
  read_estimate();
  const Decision decision = decide();
  follow(decision);
  steer(decision);
  plan(decision);
  report(decision);
  log_step();
}

/// Timers go on as if nothing had happened; the supervisor sees to stamps, the reference follows its decision.
void Companion::shift_clock(Microseconds jump) {
  link_.shift_clock(jump);
  mission_.shift_clock(us(jump));
  replanner_.shift_clock(us(jump));
  plan_wanted_since_ += us(jump);
  stream_until_ += us(jump);
}

void Companion::receive(Microseconds now) {
  now_ = us(now);
  journal_.set_time(now_);
  link_.step(now);
  take_goal();
  take_commands();
  take_texts();
  take_parameters();
  ask_for_parameters();
  take_answers();
}

/// A goal that comes over the link replaces all others, as a target does. It is no news while it is waiting or flown
/// to, nor in a stream of the like; one that was refused is tried again now and then.
void Companion::take_goal() {
  const std::optional<mavlink::Goal> goal = link_.take_goal();
  if (!goal) return;
  const bool repeated = link_goal_ && same(*link_goal_, *goal);
  if (repeated && (mission_.has_goal(link_goal_id_) || now_ < stream_until_)) {
    if (link_goal_id_ != 0) stream_until_ = now_ + kStream;
    return;
  }
  stream_until_ = now_ + kStream;
  link_goal_ = goal;
  link_goal_id_ = 0;
  if (goal->local && !mission_.aligned())
    return journal_.warn("goal in the autopilot's frame refused: the frames are not tied");
  link_goal_id_ = mission_.set_goal(goal->position, goal->yaw, replanner_.map());
}

void Companion::take_commands() {
  while (const std::optional<mavlink::ReceivedCommand> command = link_.take_command()) {
    link_.answer(*command, carry_out(*command));
  }
}

mavlink::CommandResult Companion::carry_out(const mavlink::ReceivedCommand& command) {
  const auto result_of = [](bool done) {
    return done ? mavlink::CommandResult::kAccepted : mavlink::CommandResult::kTemporarilyRejected;
  };
  if (command.command == kCommandLand) return result_of(mission_.land());
  if (command.command == kCommandMissionStart) return result_of(engage_at_once());
  if (command.command != kCommandPauseContinue || command.param[0] != 0) return mavlink::CommandResult::kUnsupported;
  mission_.stop();
  return mavlink::CommandResult::kAccepted;
}

/// Over the link nobody waits for what is missing: what cannot start now is refused.
bool Companion::engage_at_once() {
  const bool hindered = telemetry_.state == FlightState::kIdle && telemetry_.reason >= Reason::kLinkLost;
  if (hindered || !mission_.can_start(replanner_)) {
    journal_.warn(Line("refused to start: ")
                  << (hindered ? describe(telemetry_.reason) : "nothing is free above the start"));
    return false;
  }
  mission_.engage();
  return true;
}

void Companion::take_texts() {
  while (const std::optional<mavlink::Text> text = link_.take_text()) {
    const std::string_view words(text->text.data(), text->text.size());
    journal_.heard(text->severity, Line("heard: ")
                                       << std::string_view(words.data(), std::min(words.size(), words.find('\0'))));
  }
}

void Companion::take_parameters() {
  if (link_.parameter_changes() == parameter_changes_) return;
  parameter_changes_ = link_.parameter_changes();
  change_limits(Real(parameters_[kSpeed].value), Real(parameters_[kAcceleration].value));
}

/// On the ground, when the autopilot has come or come back. Who knows no such parameter does not answer, and nobody
/// waits.
void Companion::ask_for_parameters() {
  const mavlink::AutopilotState& autopilot = link_.autopilot();
  if (!autopilot.heard || autopilot.armed || asked_boot_ == autopilot.restarts) return;
  asked_boot_ = autopilot.restarts;
  if (settings_.asks_hover_thrust) (void)link_.request_parameter(kHoverThrust);
  (void)link_.request_parameter(kOffboardLossTime);
}

void Companion::take_answers() {
  while (const std::optional<mavlink::ParameterAnswer> answer = link_.take_parameter()) {
    if (!answer->value) continue;
    const bool is_hover_thrust = mavlink::text_of(answer->name) == kHoverThrust;
    is_hover_thrust ? take_hover_thrust(*answer->value) : check_loss_time(*answer->value);
  }
}

void Companion::take_hover_thrust(float share) {
  if (!steering_.begin_with_hover_thrust(Real(share))) return;
  journal_.info(Line("hover thrust ") << steering_.hover_thrust() << " of the autopilot");
}

/// Until set-points are given up, the autopilot must wait for the next one.
void Companion::check_loss_time(float seconds) {
  const Real apart = to_seconds(settings_.supervisor.setpoint_age_yield);
  if (seconds >= static_cast<float>(apart)) return;
  journal_.warn(Line() << kOffboardLossTime << " is " << Real(seconds) << " s: too short for set-points that may be "
                       << apart << " s apart");
}

// ---- The estimate

/// One state from the autopilot's position and attitude, which come apart: at the position's time.
void Companion::read_estimate() {
  const mavlink::VehicleState vehicle = link_.vehicle();
  new_estimate_ = vehicle.position_count != estimates_;
  const bool refused = vehicle.refused_count != refused_estimates_;
  estimates_ = vehicle.position_count;
  refused_estimates_ = vehicle.refused_count;
  if (refused || new_estimate_) estimate_refused_ = refused;
  has_estimate_ = vehicle.has_position && vehicle.has_attitude;
  const TimeUs position_at = us(vehicle.position_sampled_at);
  const TimeUs attitude_at = us(vehicle.attitude_sampled_at);
  estimate_.time = position_at - attitude_at > kAttitudeAgeMax ? attitude_at : position_at;
  estimate_.position = vehicle.position;
  estimate_.velocity = vehicle.velocity;
  estimate_.body_rates = vehicle.body_rates;
  // The turn between the two instants, at most a few hundredths of a second.
  const TimeUs gap = std::clamp(position_at - attitude_at, -kAttitudeAgeMax, kAttitudeAgeMax);
  const Vector3 half = vehicle.body_rates * (to_seconds(gap) / 2);
  estimate_.attitude = (vehicle.attitude * Quaternion(1, half.x(), half.y(), half.z())).normalized();
}

TimeUs Companion::last_message() const {
  const mavlink::AutopilotState& autopilot = link_.autopilot();
  const mavlink::VehicleState& vehicle = link_.local_vehicle();
  return us(
      std::max({autopilot.heard_at, autopilot.mode_at, vehicle.position_received_at, vehicle.attitude_received_at}));
}

TimeUs Companion::link_delay() const {
  if (!link_.time_sync().synchronised()) return 0;
  return us(std::chrono::duration_cast<Microseconds>(link_.time_sync().round_trip())) / 2;
}

// ---- Decision

Decision Companion::decide() {
  SupervisorInputs inputs;
  inputs.now = now_;
  inputs.last_message = last_message();
  inputs.has_odometry = has_estimate_;
  inputs.odometry = estimate_;
  if (estimate_refused_) {  // what came last was refused: the supervisor shall know
    inputs.odometry.time = now_;
    inputs.odometry.position.setConstant(std::numeric_limits<Real>::quiet_NaN());
  }
  inputs.reference_position =
      store_.has_reference() ? store_.sample(estimate_.time).position : Vector3(estimate_.position);
  inputs.reference_at_rest = store_.at_rest(now_) || !store_.has_reference();
  inputs.last_setpoint = last_setpoint_;
  inputs.autopilot_boots = link_.autopilot().restarts;
  inputs.deadline_misses = replanner_.late_in_row();
  inputs.map_id = replanner_.map_crc();
  const bool on_plan = store_.has_reference() && !store_.segments(now_).empty();
  inputs.plan_map_id = on_plan ? replanner_.committed().map_crc : inputs.map_id;
  inputs.path_blocked = replanner_.path_blocked(store_, now_);
  inputs.margins_covered = mission_.margins(replanner_.map()).verdict == MarginVerdict::kCovered;
  inputs.storage_full = log_ != nullptr && log_->full();
  mission_.fill(inputs);
  return supervisor_.step(inputs);
}

void Companion::follow(const Decision& decision) {
  if (decision.clock_shift != 0) store_.shift_clock(decision.clock_shift);
  if (decision.position_shift.squaredNorm() > 0) store_.shift_position(decision.position_shift);
  if (decision.hold_here) store_.hold(estimate_.position, now_);
  if (decision.brake) store_.brake(now_);
  const bool leads_elsewhere = decision.brake || decision.hold_here || decision.position_shift.squaredNorm() > 0;
  if (leads_elsewhere) mission_.plan_anew();
  mission_.advance({now_, decision, replanner_, has_estimate_, estimate_}, store_);
}

// ---- Steering

void Companion::steer(const Decision& decision) {
  telemetry_.sent = false;
  if (decision.hold_here || decision.setpoints == Setpoints::kNone || decision.clock_shift != 0) {
    steering_.rest(mavlink::yaw_of(estimate_.attitude), now_);
  }
  if (decision.setpoints == Setpoints::kNone || !store_.has_reference()) return;
  const bool position_only = decision.setpoints == Setpoints::kPosition || mission_.position_only();
  SteeringInputs inputs;
  inputs.now = now_;
  inputs.link_delay = link_delay();
  inputs.form = position_only ? SetpointForm::kPosition : settings_.form;
  inputs.trusted = decision.setpoints != Setpoints::kPosition;
  inputs.estimate = estimate_;
  inputs.new_estimate = new_estimate_;
  inputs.yaw = mission_.yaw(store_.at_rest(now_));
  telemetry_.form = inputs.form;
  telemetry_.command = steering_.step(inputs, store_);
  telemetry_.sent = !mission_.autopilot_climbs() && steering_.send(link_);
  if (telemetry_.sent || mission_.autopilot_climbs()) last_setpoint_ = now_;
}

// ---- Plans

/// After the set-point has left: a plan that is quick is committed in the step that asked for it, and delays nothing.
void Companion::plan(const Decision& decision) {
  const Goal* goal = mission_.goal();
  const bool wanted = decision.replan && goal != nullptr;
  if (wanted && !wants_plan_) plan_wanted_since_ = now_;
  wants_plan_ = wanted;
  if (replanner_.under_way()) end_plan();
  goal = mission_.goal();
  if (!wants_plan_ || goal == nullptr || replanner_.under_way()) return;
  if (replanner_.begin(*goal, plan_wanted_since_, mission_.reach(replanner_.map()), store_, now_)) end_plan();
}

void Companion::end_plan() {
  const Goal* goal = mission_.goal();
  const bool wanted = goal != nullptr && goal->id == replanner_.goal_under_way();
  const std::optional<PlanEnd> end = replanner_.poll(wanted, store_, now_);
  if (!end) return;
  if (log_ != nullptr) log_->note_plan_done();
  mission_.plan_ended(*end);
  if (end->committed) wants_plan_ = false;
}

// ---- What is told

void Companion::note_events() {
  for (; noted_events_ != supervisor_.event_count(); ++noted_events_) {
    const FlightEvent& event = supervisor_.event(noted_events_);
    log_notes();
    journal_.info(Line(describe(event.to)) << ": " << describe(event.reason));
    if (log_ == nullptr) continue;
    log_->write(event);
    ++logged_notes_;  // the event says more
  }
}

void Companion::log_notes() {
  if (log_ == nullptr) return;
  const std::uint32_t count = journal_.count();
  if (count - logged_notes_ > kNotes) logged_notes_ = count - kNotes;
  for (; logged_notes_ != count; ++logged_notes_) log_->write(journal_.note(logged_notes_));
}

void Companion::log_step() {
  log_notes();
  if (log_ != nullptr) log_->end_step(telemetry_);
}

void Companion::report(const Decision& decision) {
  note_events();
  const bool in_flight = decision.setpoints != Setpoints::kNone && decision.state != FlightState::kReady;
  link_.set_state(in_flight ? mavlink::SystemState::kActive : mavlink::SystemState::kStandby);
  Telemetry& t = telemetry_;
  t.time = now_;
  t.state = decision.state;
  t.reason = decision.reason;
  t.phase = mission_.phase();
  t.has_estimate = has_estimate_;
  t.estimate = estimate_;
  t.has_reference = store_.has_reference();
  if (t.has_reference) {
    t.reference = {store_.sample(now_), steering_.yaw().yaw, steering_.yaw().rate};
    t.tracking_error = (estimate_.position - store_.sample(estimate_.time).position).norm();
  }
  t.setpoints = decision.setpoints;
  t.thrust = steering_.thrust();
  t.hover_thrust = steering_.hover_thrust();
  t.link_delay = link_delay();
  t.plan = replanner_.committed();
  t.goals_reached = mission_.goals_reached();
  t.goals_waiting = mission_.goals_waiting();
  t.plans_discarded = replanner_.discarded();
  t.deadline_misses = replanner_.late();
  t.aligned = mission_.aligned();
  t.armed = link_.autopilot().armed;
  t.mode = link_.autopilot().mode;
  t.autopilot = link_.autopilot().kind;
  t.battery_mv = link_.autopilot().battery_mv;
  t.link = link_.counters();
  t.codec = link_.codec_counters();
  t.signing_time = link_.signing_time();
}

}  // namespace swiftlet::companion
