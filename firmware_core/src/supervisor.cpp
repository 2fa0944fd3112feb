#include "swiftlet/supervisor.hpp"

#include <cmath>

namespace swiftlet {
namespace {

// [m/s] by which velocity may be off between two odometry samples before the difference counts as a jump.
constexpr Real kVelocityDoubt = 1;

}  // namespace

const char* describe(FlightState state) {
  switch (state) {
    case FlightState::kIdle:
      return "idle";
    case FlightState::kReady:
      return "ready";
    case FlightState::kFlying:
      return "flying";
    case FlightState::kBraking:
      return "braking";
    case FlightState::kHolding:
      return "holding";
    case FlightState::kYielded:
      return "yielded";
    case FlightState::kLanded:
      return "landed";
  }
  return "unknown state";
}

const char* describe(Reason reason) {
  switch (reason) {
    case Reason::kNone:
      return "none";
    case Reason::kEngaged:
      return "engaged by the operator";
    case Reason::kReleased:
      return "released by the operator";
    case Reason::kControlGained:
      return "armed and in our mode";
    case Reason::kPlanStarted:
      return "a plan has started";
    case Reason::kArrived:
      return "the plan has ended";
    case Reason::kStopped:
      return "the brake has ended";
    case Reason::kStopRequested:
      return "stop requested";
    case Reason::kLandingRequested:
      return "landing requested";
    case Reason::kDisarmed:
      return "disarmed";
    case Reason::kLinkLost:
      return "link lost";
    case Reason::kOdometryStale:
      return "odometry too old";
    case Reason::kOdometryInvalid:
      return "odometry with impossible numbers";
    case Reason::kPositionJump:
      return "the estimated position jumped";
    case Reason::kAutopilotRestart:
      return "the autopilot restarted";
    case Reason::kPilotTookOver:
      return "the mode was changed";
    case Reason::kSetpointStarved:
      return "set-points were held up";
    case Reason::kClockJump:
      return "the clock jumped";
    case Reason::kMapReplaced:
      return "the map was replaced";
    case Reason::kStorageFull:
      return "no room left to log";
    case Reason::kTrackingError:
      return "too far from the reference";
    case Reason::kDeadlineMisses:
      return "deadlines missed";
    case Reason::kPathBlocked:
      return "the path is blocked";
    case Reason::kMarginsTooSmall:
      return "the map's radius does not cover the margins";
  }
  return "unknown reason";
}

bool Supervisor::in_control() const {
  return state_ == FlightState::kFlying || state_ == FlightState::kBraking || state_ == FlightState::kHolding;
}

/// Age of an instant; one from before a jump of the clock is brought to the present clock first.
TimeUs Supervisor::age(TimeUs stamp, TimeUs now) const {
  const bool of_old_clock = clock_shift_ > 0 ? stamp < clock_jumped_at_ : clock_shift_ < 0 && stamp > now;
  return now - (of_old_clock ? stamp + clock_shift_ : stamp);
}

/// A gap between steps that is negative, or too long for a stall, is a jump of the clock.
TimeUs Supervisor::clock_jump(TimeUs now) const {
  const TimeUs gap = stepped_ ? now - last_step_ : 0;
  return gap < 0 || gap > settings_.clock_gap_max ? gap : 0;
}

void Supervisor::note_clock(TimeUs now, Decision& decision) {
  const TimeUs jump = clock_jump(now);
  step_gap_ = stepped_ ? now - last_step_ : 0;
  stepped_ = true;
  last_step_ = now;
  if (jump == 0) return;
  decision.clock_shift = jump;
  clock_shift_ = jump;
  clock_jumped_at_ = now;
  odometry_.time += jump;
  blocked_since_ += jump;
}

/// Takes a new odometry sample over if it can be trusted, and compares it with what the last one foretold.
void Supervisor::note_odometry(const SupervisorInputs& inputs, Decision& decision) {
  if (!inputs.has_odometry) return;
  const TimeUs sample_age = age(inputs.odometry.time, inputs.now);
  odometry_invalid_ = !is_usable(inputs.odometry) || sample_age < -settings_.odometry_age_max;
  if (odometry_invalid_) return;
  tracking_error_ = (inputs.odometry.position - inputs.reference_position).norm();
  const TimeUs time = inputs.now - sample_age;
  if (has_odometry_ && time <= odometry_.time) return;
  if (has_odometry_ && in_control()) {
    const Real dt = to_seconds(time - odometry_.time);
    const Vector3 jump = inputs.odometry.position - odometry_.position - odometry_.velocity * dt;
    if (jump.norm() > settings_.position_jump + kVelocityDoubt * dt) {
      decision.position_shift = jump;
      latched_ = Reason::kPositionJump;
    }
  }
  has_odometry_ = true;
  odometry_ = inputs.odometry;
  odometry_.time = time;
}

/// A full storage ends the log, not the flight.
void Supervisor::note_storage(const SupervisorInputs& inputs) {
  if (inputs.storage_full && !storage_was_full_) note({inputs.now, state_, state_, Reason::kStorageFull});
  storage_was_full_ = inputs.storage_full;
}

void Supervisor::note_operator(const SupervisorInputs& inputs) {
  engaged_anew_ = inputs.engage && !was_engaged_;
  was_engaged_ = inputs.engage;
  if (engaged_anew_) {
    latched_ = Reason::kNone;
    had_mode_ = was_armed_ = false;
  }
  if (!inputs.path_blocked) blocked_since_ = inputs.now;
}

Reason Supervisor::odometry_fault(TimeUs now) const {
  const bool fresh = has_odometry_ && now - odometry_.time <= settings_.odometry_age_max;
  if (fresh) return Reason::kNone;
  return odometry_invalid_ ? Reason::kOdometryInvalid : Reason::kOdometryStale;
}

/// What forbids to start.
Reason Supervisor::start_fault(const SupervisorInputs& inputs) const {
  if (age(inputs.last_message, inputs.now) > settings_.link_age_max) return Reason::kLinkLost;
  if (const Reason fault = odometry_fault(inputs.now); fault != Reason::kNone) return fault;
  if (odometry_invalid_) return Reason::kOdometryInvalid;
  if (inputs.storage_full && settings_.storage_needed) return Reason::kStorageFull;
  if (!inputs.margins_covered) return Reason::kMarginsTooSmall;
  return Reason::kNone;
}

/// What was granted before control began and is gone: who took it shall have it.
Reason Supervisor::taken_back(const SupervisorInputs& inputs) const {
  if (!had_mode_ && !was_armed_) return Reason::kNone;
  if (inputs.autopilot_boots != boots_) return Reason::kAutopilotRestart;
  if (had_mode_ && !inputs.in_our_mode) return Reason::kPilotTookOver;
  return was_armed_ && !inputs.armed ? Reason::kDisarmed : Reason::kNone;
}

/// What ends our control at once.
Reason Supervisor::yield_fault(const SupervisorInputs& inputs) const {
  if (inputs.autopilot_boots != boots_) return Reason::kAutopilotRestart;
  if (!inputs.in_our_mode) {
    if (!inputs.landing) return Reason::kPilotTookOver;
    return inputs.engage ? Reason::kLandingRequested : Reason::kReleased;
  }
  if (age(inputs.last_message, inputs.now) > settings_.link_age_max) return Reason::kLinkLost;
  if (age(inputs.last_setpoint, inputs.now) > settings_.setpoint_age_yield) return Reason::kSetpointStarved;
  return Reason::kNone;
}

/// What makes the reference unfit to be followed further, or a new one unfit to be begun.
Reason Supervisor::tracking_fault(const SupervisorInputs& inputs, const Decision& decision) const {
  if (decision.clock_shift != 0) return Reason::kClockJump;
  if (latched_ != Reason::kNone) return latched_;
  // Before the odometry: a stall of ours makes that look old as well.
  const TimeUs silence = age(inputs.last_setpoint, inputs.now);
  if (silence > settings_.setpoint_age_max || step_gap_ > settings_.setpoint_age_max) return Reason::kSetpointStarved;
  if (const Reason fault = odometry_fault(inputs.now); fault != Reason::kNone) return fault;
  if (inputs.airborne && !(tracking_error_ <= settings_.tracking_tube)) return Reason::kTrackingError;
  return inputs.stop ? Reason::kStopRequested : Reason::kNone;
}

/// What ends a plan under way.
Reason Supervisor::brake_fault(const SupervisorInputs& inputs, const Decision& decision) const {
  if (const Reason fault = tracking_fault(inputs, decision); fault != Reason::kNone) return fault;
  if (inputs.map_id != inputs.plan_map_id) return Reason::kMapReplaced;
  if (inputs.deadline_misses >= settings_.deadline_misses_max) return Reason::kDeadlineMisses;
  if (inputs.now - blocked_since_ > settings_.blocked_patience) return Reason::kPathBlocked;
  return Reason::kNone;
}

void Supervisor::note(const FlightEvent& event) { events_[event_count_++ % kEvents] = event; }

void Supervisor::enter(FlightState state, Reason reason, TimeUs now) {
  note({now, state_, state, reason});
  state_ = state;
  reason_ = reason;
}

/// Idle and ready: on the way to control.
void Supervisor::prepare(const SupervisorInputs& inputs, Reason fault) {
  const bool ready = state_ == FlightState::kReady;
  if (!ready) reason_ = fault;
  if (!inputs.engage) {
    if (ready) enter(FlightState::kIdle, Reason::kReleased, inputs.now);
  } else if (const Reason taken = taken_back(inputs); taken != Reason::kNone) {
    enter(FlightState::kYielded, taken, inputs.now);
  } else if (fault != Reason::kNone) {
    if (ready) enter(FlightState::kIdle, fault, inputs.now);
  } else if (!ready) {
    enter(FlightState::kReady, Reason::kEngaged, inputs.now);
  } else if (inputs.armed && inputs.in_our_mode && !inputs.standing) {
    enter(FlightState::kHolding, Reason::kControlGained, inputs.now);
  } else {
    had_mode_ = had_mode_ || inputs.in_our_mode;
    was_armed_ = was_armed_ || inputs.armed;
  }
}

void Supervisor::step_out_of_control(const SupervisorInputs& inputs) {
  const Reason fault = start_fault(inputs);
  switch (state_) {
    case FlightState::kYielded:
      if (!inputs.armed) {
        enter(FlightState::kLanded, Reason::kDisarmed, inputs.now);
      } else if (engaged_anew_ && fault == Reason::kNone) {
        enter(FlightState::kReady, Reason::kEngaged, inputs.now);
      }
      break;
    case FlightState::kLanded:
      if (!inputs.engage) enter(FlightState::kIdle, Reason::kReleased, inputs.now);
      break;
    default:
      prepare(inputs, fault);
  }
  boots_ = inputs.autopilot_boots;
}

void Supervisor::step_in_control(const SupervisorInputs& inputs, Decision& decision) {
  if (const Reason fault = yield_fault(inputs); fault != Reason::kNone) {
    return enter(FlightState::kYielded, fault, inputs.now);
  }
  if (!inputs.armed) return enter(FlightState::kLanded, Reason::kDisarmed, inputs.now);
  switch (state_) {
    case FlightState::kFlying:
      if (const Reason fault = brake_fault(inputs, decision); fault != Reason::kNone) {
        decision.brake = true;
        enter(FlightState::kBraking, fault, inputs.now);
      } else if (inputs.reference_at_rest) {
        enter(FlightState::kHolding, Reason::kArrived, inputs.now);
      }
      break;
    case FlightState::kBraking:
      if (inputs.reference_at_rest) enter(FlightState::kHolding, Reason::kStopped, inputs.now);
      break;
    default:  // holding
      if (!inputs.reference_at_rest) enter(FlightState::kFlying, Reason::kPlanStarted, inputs.now);
  }
}

/// What follows from the state.
void Supervisor::fill(const SupervisorInputs& inputs, Decision& decision) const {
  decision.state = state_;
  decision.reason = reason_;
  if (state_ == FlightState::kReady) {
    decision.setpoints = Setpoints::kPosition;
    decision.hold_here = true;
    decision.may_ask_for_control = true;
  }
  if (!in_control()) return;
  const bool measured = !odometry_invalid_ && odometry_fault(inputs.now) == Reason::kNone;
  decision.setpoints = measured ? Setpoints::kAnyForm : Setpoints::kPosition;
  decision.may_plan = state_ != FlightState::kBraking && tracking_fault(inputs, decision) == Reason::kNone;
  decision.replan = decision.may_plan && (inputs.goal_pending || inputs.path_blocked);
}

Decision Supervisor::step(const SupervisorInputs& inputs) {
  Decision decision;
  note_clock(inputs.now, decision);
  note_odometry(inputs, decision);
  note_operator(inputs);
  note_storage(inputs);
  if (in_control()) {
    step_in_control(inputs, decision);
  } else {
    step_out_of_control(inputs);
  }
  fill(inputs, decision);
  return decision;
}

}  // namespace swiftlet
