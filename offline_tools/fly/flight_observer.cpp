#include "fly/flight_observer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace swiftlet::tools {
namespace {

using companion::Phase;
using companion::Telemetry;

constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();
constexpr double kAtRest = 1e-3;               // [m/s] of a reference
constexpr double kLineBytes = 921'600 / 10.0;  // [1/s] with start and stop bit
constexpr Microseconds kPeriod{10'000};        // of the companion's steps

constexpr double kLatestAnswer = 2;  // [s] after the end of a fault; what comes later has another cause

bool is_fault(Reason reason) { return reason >= Reason::kLinkLost; }

bool in_control(FlightState state) {
  return state == FlightState::kFlying || state == FlightState::kBraking || state == FlightState::kHolding;
}

double seconds(Microseconds time) { return std::chrono::duration<double>(time).count(); }

double quantile(const std::vector<Microseconds>& sorted, double share) {
  if (sorted.empty()) return kAbsent;
  return seconds(sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))]);
}

SetpointReport describe_setpoints(const SetpointWatch& watch) {
  SetpointReport report;
  report.count = watch.count();
  report.stale = watch.stale();
  std::vector<Microseconds> intervals = watch.intervals();
  std::sort(intervals.begin(), intervals.end());
  report.interval_p50 = quantile(intervals, 0.5);
  report.interval_p99 = quantile(intervals, 0.99);
  report.interval_max = quantile(intervals, 1);
  std::vector<Microseconds> jitter = intervals;
  for (Microseconds& interval : jitter) interval = interval > kPeriod ? interval - kPeriod : kPeriod - interval;
  std::sort(jitter.begin(), jitter.end());
  report.jitter_p99 = quantile(jitter, 0.99);
  return report;
}

}  // namespace

FlightObserver::FlightObserver(const FlightRequest& request, FlightPlanner& planner)
    : request_(request), planner_(planner) {
  FlightRecord& record = report_.record;
  record.goals = request.goals;
  record.phases.push_back({0, describe(phase_)});
  record.vehicle_radius = static_cast<double>(request.companion.margins.vehicle_radius);
  record.tracking_tube = static_cast<double>(tube_of(request.companion.margins.tubes, request.companion.form));
  record.speed_limit = static_cast<double>(request.companion.limits.v_max);
  record.speed_limit_per_axis = request.companion.limits.norm == LimitNorm::kAxis;
  record.line_rate = kLineBytes;
}

void FlightObserver::note_fault(const FlightFault& fault, double t) {
  t_ = t;
  note(EventKind::kFault, std::string("fault: ") + describe(fault));
  const double lasts = std::visit([](const auto& either) { return either.duration; }, fault);
  answer_until_ = t + kLatestAnswer + (std::isfinite(lasts) ? lasts : 0);
  report_.answers.push_back({describe(fault), t, {}, {}, {}});
}

void FlightObserver::see(double t, const companion::Companion& companion, const RigidState& truth,
                         const SetpointWatch& watch) {
  t_ = t;
  const Telemetry& telemetry = companion.telemetry();
  see_events(companion);
  see_phase(telemetry);
  see_plan(telemetry);
  see_tracking(telemetry, truth);
  see_setpoint(telemetry, watch);
  settle_faults(telemetry);
  if (begun_ && !ended_) {
    if (bytes_in_ == 0) bytes_in_ = watch.received_bytes();
    if (bytes_out_ == 0) bytes_out_ = watch.sent_bytes();
    const double span = std::max(t_ - report_.begin, seconds(kPeriod)) * kLineBytes;
    report_.load_in = static_cast<double>(watch.received_bytes() - bytes_in_) / span;
    report_.load_out = static_cast<double>(watch.sent_bytes() - bytes_out_) / span;
    report_.end = t_;
  }
  keep_sample(telemetry, truth, watch);
}

void FlightObserver::see_clearance(double least) {
  report_.clearance = least;
  const bool touches = least <= report_.record.vehicle_radius;
  if (touches && !report_.touched_at) report_.touched_at = t_;
}

void FlightObserver::see_events(const companion::Companion& companion) {
  for (; events_seen_ < companion.event_count(); ++events_seen_) {
    if (events_seen_ + Supervisor::kEvents < companion.event_count()) continue;  // overwritten within one step: never
    const FlightEvent& event = companion.event(events_seen_);
    const std::string reason = describe(event.reason);
    transition_ = std::string(describe(event.to)) + ": " + reason;
    note(is_fault(event.reason) ? EventKind::kReaction : EventKind::kNote,
         event.from == event.to ? transition_ : std::string(describe(event.from)) + " -> " + transition_);
    if (!is_fault(event.reason)) continue;
    fault_ = event.reason;
    answer_fault(event);
  }
  for (; notes_seen_ < companion.note_count(); ++notes_seen_) {
    if (notes_seen_ + companion::Companion::kNotes < companion.note_count()) continue;
    const companion::Note& said = companion.note(notes_seen_);
    const std::string text(said.view());
    const bool of_goal = text.starts_with("goal ");
    if (of_goal && said.severity <= mavlink::Severity::kWarning) lost_goal_ = text;
    const bool arrives = of_goal && text.ends_with(" reached");
    if (text != transition_) note(arrives ? EventKind::kArrival : EventKind::kNote, text);
  }
}

void FlightObserver::answer_fault(const FlightEvent& event) {
  if (report_.answers.empty() || report_.answers.back().after || t_ > answer_until_) return;
  FaultAnswer& answer = report_.answers.back();
  answer.after = t_ - answer.at;
  answer.what =
      (event.from == event.to ? std::string("noted") : std::string(describe(event.to))) + ": " + describe(event.reason);
}

void FlightObserver::settle_faults(const Telemetry& telemetry) {
  const bool rests = telemetry.has_reference && telemetry.reference.sample.velocity.norm() < kAtRest;
  const bool settled = in_control(telemetry.state) ? rests : true;
  for (FaultAnswer& answer : report_.answers) {
    if (answer.after && !answer.settled && settled) answer.settled = t_ - answer.at;
  }
}

void FlightObserver::enter(Phase phase) {
  report_.record.phases.push_back({t_, describe(phase)});
  note(EventKind::kNote, std::string("phase: ") + describe(phase));
}

void FlightObserver::see_phase(const Telemetry& telemetry) {
  if (telemetry.state != state_ || telemetry.phase != phase_) changed_at_ = t_;
  if (telemetry.phase != phase_) enter(telemetry.phase);
  state_ = telemetry.state;
  phase_ = telemetry.phase;
  if (phase_ < Phase::kLanding && state_ != FlightState::kLanded) flown_state_ = state_;
  const bool flies = phase_ == Phase::kMission && in_control(state_);
  if (flies && !begun_) {
    begun_ = true;
    report_.begin = t_;
  }
  if (begun_ && !flies) ended_ = true;
  measures_ = flies;
  for (; report_.goals_reached < telemetry.goals_reached; ++report_.goals_reached) {
    report_.arrivals.push_back(t_);
    changed_at_ = t_;
  }
}

void FlightObserver::see_plan(const Telemetry& telemetry) {
  if (telemetry.plan.id == plan_) return;
  plan_ = telemetry.plan.id;
  changed_at_ = t_;
  if (planner_.plans().empty()) return;
  FlownPlan& plan = planner_.plans().back();
  plan.id = plan_;
  plan.at = t_;
  plan.latency = static_cast<double>(to_seconds(telemetry.plan.latency));
  const double begins = t_ + static_cast<double>(to_seconds(telemetry.plan.start - telemetry.time));
  report_.record.plans.push_back({t_, begins, plan.boxes, plan.segments});
}

void FlightObserver::see_tracking(const Telemetry& telemetry, const RigidState& truth) {
  if (!measures_) return;
  report_.speed_max = std::max(report_.speed_max, truth.velocity.norm());
  if (!telemetry.has_reference) return;
  const Sample& reference = telemetry.reference.sample;
  const double error = (reference.position - truth.position).norm();
  report_.tracking_max = std::max(report_.tracking_max, error);
  sum_of_squares_ += error * error;
  ++tracked_;
  const double belief = telemetry.has_estimate ? (telemetry.estimate.position - truth.position).norm() : 0;
  report_.estimate_max = std::max(report_.estimate_max, belief);
  estimate_squares_ += belief * belief;
  report_.reference_speed = report_.reference_speed.cwiseMax(reference.velocity.cwiseAbs());
  report_.reference_acceleration = report_.reference_acceleration.cwiseMax(reference.acceleration.cwiseAbs());
  report_.reference_speed_norm = std::max(report_.reference_speed_norm, reference.velocity.norm());
  report_.reference_acceleration_norm = std::max(report_.reference_acceleration_norm, reference.acceleration.norm());
}

void FlightObserver::see_setpoint(const Telemetry& telemetry, const SetpointWatch& watch) {
  // Of the reference when the command takes effect; slower motion may vanish in the message's 32-bit numbers.
  const bool moves = telemetry.command.velocity.norm() > 10 * kAtRest;
  const bool bounded = telemetry.command.saturated;  // at its bounds a fresh command may well have the old numbers
  if (watch.sent() && watch.repeated() && moves && !bounded) ++report_.setpoints.repeated;
}

void FlightObserver::keep_sample(const Telemetry& telemetry, const RigidState& truth, const SetpointWatch& watch) {
  RecordedSample& sample = report_.record.samples.emplace_back();
  sample.t = t_;
  sample.state = telemetry.state;
  sample.has_reference = telemetry.has_reference;
  sample.reference = telemetry.reference.sample.position;
  sample.reference_velocity = telemetry.reference.sample.velocity;
  sample.has_estimate = telemetry.has_estimate;
  sample.estimate = telemetry.estimate.position;
  sample.position = truth.position;
  sample.velocity = truth.velocity;
  sample.attitude = truth.attitude;
  sample.setpoints = watch.count();
  sample.bytes_in = watch.received_bytes();
  sample.bytes_out = watch.sent_bytes();
}

double FlightObserver::patience() const {
  if (state_ == FlightState::kYielded && phase_ != Phase::kLanding) return 10;
  switch (phase_) {
    case Phase::kGround:
    case Phase::kTakeoff:
      return 40;
    case Phase::kLanding:
      return 120;  // PX4 crawls below the height that it was armed at
    case Phase::kMission:
      return state_ == FlightState::kHolding ? 10 : request_.longest;
    case Phase::kDone:
      return 0.5;
  }
  return request_.longest;
}

bool FlightObserver::finished() const { return t_ - changed_at_ >= patience() || t_ >= request_.longest; }

FlightReport FlightObserver::report(const companion::Companion& companion, const SetpointWatch& watch) {
  const Telemetry& telemetry = companion.telemetry();
  const std::uint32_t repeated = report_.setpoints.repeated;
  report_.setpoints = describe_setpoints(watch);
  report_.setpoints.repeated = repeated;
  report_.state = flown_state_;
  report_.landed = phase_ == Phase::kDone || state_ == FlightState::kLanded;
  if (!begun_) report_.clearance = kAbsent;
  const auto mean = [this](double squares) {
    return tracked_ > 0 ? std::sqrt(squares / static_cast<double>(tracked_)) : kAbsent;
  };
  report_.tracking_rms = mean(sum_of_squares_);
  report_.estimate_rms = mean(estimate_squares_);
  if (tracked_ == 0) report_.tracking_max = report_.estimate_max = kAbsent;
  const double end = report_.goals_reached >= request_.goals.size() ? report_.arrivals.back() : report_.end;
  report_.duration = begun_ ? end - report_.begin : 0;
  report_.simulated = t_;
  report_.link = telemetry.link;
  report_.codec = telemetry.codec;
  name_outcome(telemetry);
  return std::move(report_);
}

void FlightObserver::name_outcome(const Telemetry& telemetry) {
  const auto set = [&](const std::string& status, const std::string& reason) {
    report_.status = status;
    report_.reason = reason;
  };
  if (report_.goals_reached >= request_.goals.size()) return set("arrived", "");
  if (is_fault(fault_)) return set(to_word(fault_), describe(fault_));
  if (is_fault(telemetry.reason)) return set(to_word(telemetry.reason), describe(telemetry.reason));
  if (!planner_.plans().empty()) {
    const Status status = planner_.plans().back().plan.status;
    if (status != Status::kOk && status != Status::kFallback) return set(describe(status), describe(status));
  }
  if (t_ >= request_.longest) return set("timeout", "the flight took too long");
  if (!begun_) return set("no_take_off", std::string("it never took off: ") + describe(telemetry.reason));
  set("stopped", "it stopped: " + (lost_goal_.empty() ? describe(telemetry.reason) : lost_goal_));
}

const char* to_word(Reason reason) {
  switch (reason) {
    case Reason::kLinkLost:
      return "link_lost";
    case Reason::kOdometryStale:
      return "odometry_stale";
    case Reason::kOdometryInvalid:
      return "odometry_invalid";
    case Reason::kPositionJump:
      return "position_jump";
    case Reason::kAutopilotRestart:
      return "autopilot_restart";
    case Reason::kPilotTookOver:
      return "pilot_took_over";
    case Reason::kSetpointStarved:
      return "setpoint_starved";
    case Reason::kClockJump:
      return "clock_jump";
    case Reason::kMapReplaced:
      return "map_replaced";
    case Reason::kStorageFull:
      return "storage_full";
    case Reason::kTrackingError:
      return "tracking_error";
    case Reason::kDeadlineMisses:
      return "deadline_misses";
    case Reason::kPathBlocked:
      return "path_blocked";
    case Reason::kMarginsTooSmall:
      return "margins_too_small";
    default:
      return "stopped";
  }
}

}  // namespace swiftlet::tools
