#include "sim/autopilot.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet::tools {
namespace {

constexpr double kStep = 0.001;               // [s]
constexpr std::uint32_t kAttitudeTicks = 4;   // 250 Hz
constexpr std::uint32_t kPositionTicks = 10;  // 100 Hz
constexpr double kBootTime = 1;               // [s] until the estimate is good enough to arm
constexpr double kPrearmPeriod = 0.1;         // [s] of the health report that arming looks at
constexpr double kStreamTime = 0.04;          // [s] of set-points before OFFBOARD can run
constexpr double kPrearmStreamTime = 0.1;     // [s] and before the health report knows
constexpr double kLossDelay = 0.04;           // [s] seen beyond COM_OF_LOSS_T
// [s] PX4's position loop was seen 0.16 to 0.22 s late; its gains and filters explain half of that.
constexpr double kTargetDelay = 0.08;
constexpr double kTakeoffSpeed = 1.5;  // [m/s] MPC_TKO_SPEED
constexpr double kInAirDelay = 0.5;    // [s] after the ramp's start, well before lift-off
constexpr double kContactTime = 1;     // [s] of contact until the vehicle counts as landed
constexpr double kIdleShare = 0.5;     // of hover thrust: less on the ground means that it shall stay there
// The last metre is flown so slowly that AUTO.LAND from 1.5 m touches down after 6 to 8 s.
constexpr double kLandSpeed = 0.7;    // [m/s] MPC_LAND_SPEED
constexpr double kCrawlSpeed = 0.2;   // [m/s]
constexpr double kCrawlHeight = 1.1;  // [m]

}  // namespace

const char* describe(FlightMode mode) {
  switch (mode) {
    case FlightMode::kManual:
      return "MANUAL";
    case FlightMode::kPosctl:
      return "POSCTL";
    case FlightMode::kOffboard:
      return "OFFBOARD";
    case FlightMode::kLand:
      return "AUTO.LAND";
    case FlightMode::kLoiter:
      return "AUTO.LOITER";
  }
  return "";
}

Autopilot::Autopilot(const VehicleModel& model, double hover_thrust)
    : control_(model, {}),
      parameters_{{{"COM_OF_LOSS_T", 1, false},
                   {"COM_OBL_RC_ACT", 0, true},
                   {"COM_DISARM_LAND", 2, false},
                   {"COM_DISARM_PRFLT", 10, false},
                   {"COM_SPOOLUP_TIME", 1, false},
                   {"MPC_TKO_RAMP_T", 3, false},
                   {"MPC_THR_HOVER", hover_thrust, false},
                   {"MPC_XY_P", control_.gains().xy_p, false},
                   {"MPC_XY_VEL_P_ACC", control_.gains().xy_vel_p, false},
                   {"MPC_XY_VEL_I_ACC", control_.gains().xy_vel_i, false},
                   {"MAV_SYS_ID", 1, true}}} {
  set_parameter(ParameterIndex::kHoverThrust, hover_thrust);
}

void Autopilot::set_parameter(ParameterIndex index, double value) {
  parameters_[static_cast<std::size_t>(index)].value = value;
  control_.gains().hover_thrust = parameter(ParameterIndex::kHoverThrust);
  control_.gains().thrust_min = std::min(0.12, kIdleShare * control_.gains().hover_thrust);
  control_.gains().xy_p = parameter(ParameterIndex::kXyP);
  control_.gains().xy_vel_p = parameter(ParameterIndex::kXyVelocityP);
  control_.gains().xy_vel_i = parameter(ParameterIndex::kXyVelocityI);
}

void Autopilot::set_target(const PositionSetpoint& target, double now) {
  delayed_targets_.push_back({now, target});
  if (!position_target_) position_target_ = target;
  attitude_target_.reset();
  note_target(now);
}

void Autopilot::set_target(const AttitudeSetpoint& target, double now) {
  attitude_target_ = target;
  position_target_.reset();
  delayed_targets_.clear();
  note_target(now);
}

void Autopilot::note_target(double now) {
  if (now - last_target_at_ > parameter(ParameterIndex::kOffboardLossTime) + kLossDelay) stream_since_ = now;
  last_target_at_ = now;
}

bool Autopilot::has_stream(double now, double since) const {
  return now - last_target_at_ <= parameter(ParameterIndex::kOffboardLossTime) + kLossDelay &&
         now - stream_since_ >= since;
}

bool Autopilot::can_run(FlightMode mode, double now) const {
  if (mode == FlightMode::kOffboard) return has_stream(now, kStreamTime);
  if (mode == FlightMode::kManual || mode == FlightMode::kPosctl) return pilot_;
  return true;
}

Verdict Autopilot::set_mode(FlightMode mode, double now) {
  if (armed_ && !can_run(mode, now)) {
    say(2, std::string("Switching to mode ") + describe(mode) + " is currently not possible");
    return Verdict::kTemporarilyRejected;
  }
  if (mode == FlightMode::kLand && intended_ != FlightMode::kLand) before_landing_ = intended_;
  intended_ = mode;
  failsafe_ = false;
  enter(mode);
  prearm_at_ = -1;  // the report is about the mode
  return Verdict::kAccepted;
}

void Autopilot::take_over(FlightMode mode) {
  pilot_ = true;
  intended_ = mode;
  failsafe_ = false;
  enter(mode);
}

Verdict Autopilot::arm(bool forced, double now) {
  if (armed_) return Verdict::kAccepted;
  if (!forced && !(prearm_ok_ && can_run(intended_, now))) {
    say(2, "Arming denied: Resolve system health failures first");
    return Verdict::kTemporarilyRejected;
  }
  armed_ = true;
  armed_at_ = now;
  takeoff_ = Takeoff::kSpoolUp;
  hold_.reset();
  control_.reset();
  say(6, "Armed by external command");
  return Verdict::kAccepted;
}

Verdict Autopilot::disarm(bool forced) {
  if (!armed_) return Verdict::kAccepted;
  if (in_air_ && !forced) {
    say(2, "Disarming denied: not landed");
    return Verdict::kTemporarilyRejected;
  }
  set_disarmed("Disarmed by external command");
  return Verdict::kAccepted;
}

void Autopilot::set_disarmed(const char* why) {
  armed_ = false;
  in_air_ = false;
  takeoff_ = Takeoff::kDisarmed;
  failsafe_ = false;
  if (intended_ == FlightMode::kLand) intended_ = before_landing_;
  enter(intended_);
  say(6, why);
}

VehicleStatus Autopilot::system_status() const {
  if (failsafe_) return VehicleStatus::kFailsafe;
  if (armed_) return VehicleStatus::kArmed;
  return prearm_ok_ ? VehicleStatus::kReady : VehicleStatus::kNotReady;
}

void Autopilot::enter(FlightMode mode) {
  if (mode != mode_) hold_.reset();
  mode_ = mode;
}

/// Losing the stream changes the mode but not the intention, so that OFFBOARD comes back with the stream.
void Autopilot::enter_failsafe() {
  failsafe_ = true;
  const auto action = static_cast<int>(parameter(ParameterIndex::kOffboardLossAction));
  enter(action == 4 ? FlightMode::kLand : action == 5 ? FlightMode::kLoiter : FlightMode::kPosctl);
  say(2, std::string("Failsafe activated: no offboard signal, switching to ") + describe(mode_));
}

void Autopilot::update_mode(double now) {
  if (now - prearm_at_ >= kPrearmPeriod || prearm_at_ < 0) {
    const bool can = intended_ == FlightMode::kOffboard ? has_stream(now, kPrearmStreamTime) : can_run(intended_, now);
    prearm_ok_ = now >= kBootTime && can && intended_ != FlightMode::kLand;
    prearm_at_ = now;
  }
  if (!armed_ || intended_ != FlightMode::kOffboard) return;
  const bool stream = has_stream(now, kStreamTime);
  if (!stream && !failsafe_) enter_failsafe();
  if (stream && failsafe_) {
    failsafe_ = false;
    enter(FlightMode::kOffboard);
  }
}

/// A position mode without a pilot cannot run: the vehicle comes down.
bool Autopilot::is_landing() const { return mode_ == FlightMode::kLand || (mode_ == FlightMode::kPosctl && !pilot_); }

bool Autopilot::wants_up(const Estimate& estimate) const {
  if (mode_ == FlightMode::kPosctl) return stick_velocity_.z() > 0;
  if (mode_ != FlightMode::kOffboard) return false;
  if (attitude_target_) return attitude_target_->thrust > kIdleShare * control_.gains().hover_thrust;
  if (!position_target_) return false;
  constexpr double kAbove = 0.05;  // [m]
  return position_target_->position.z() > estimate.position.z() + kAbove || position_target_->velocity.z() > 0 ||
         position_target_->acceleration.z() > 0;
}

void Autopilot::update_takeoff(const Estimate& estimate, double now) {
  if (takeoff_ == Takeoff::kSpoolUp) {
    hold_ground_ = estimate.position.z();
    if (now - armed_at_ >= parameter(ParameterIndex::kSpoolUpTime)) takeoff_ = Takeoff::kReady;
  }
  if (takeoff_ == Takeoff::kReady && wants_up(estimate)) {
    takeoff_ = Takeoff::kRamp;
    ramp_since_ = now;
    control_.reset();
  }
  if (takeoff_ == Takeoff::kRamp && !wants_up(estimate) && !in_air_) takeoff_ = Takeoff::kReady;
  const bool lifts = takeoff_ == Takeoff::kRamp || takeoff_ == Takeoff::kFlight;
  if (lifts && !in_air_ && now - ramp_since_ >= kInAirDelay) {
    in_air_ = true;
    say(6, "Takeoff detected");
  }
  const bool ramp_over = attitude_target_ || now - ramp_since_ >= parameter(ParameterIndex::kTakeoffRampTime);
  if (takeoff_ == Takeoff::kRamp && ramp_over) takeoff_ = Takeoff::kFlight;
}

/// Down on its legs and meant to be: the motors idle, and after a second of that it has landed.
void Autopilot::update_landing(bool contact, double now) {
  const bool low = is_landing() || descends_ || attitude_.thrust < kIdleShare * control_.gains().hover_thrust;
  const bool may_land = takeoff_ == Takeoff::kFlight || is_landing();
  const bool settles = in_air_ && contact && low && may_land;
  if (settles && !settles_) settled_at_ = now;
  settles_ = settles;
  if (settles && now - settled_at_ >= kContactTime) {
    in_air_ = settles_ = false;
    takeoff_ = Takeoff::kReady;
    landed_at_ = now;
    say(6, "Landing detected");
  }
}

void Autopilot::disarm_when_idle(double now) {
  if (!armed_ || in_air_) return;
  const bool flown = landed_at_ > armed_at_;
  const double wait = parameter(flown ? ParameterIndex::kLandDisarmTime : ParameterIndex::kIdleDisarmTime);
  if (now - std::max(landed_at_, armed_at_) < wait) return;
  set_disarmed(flown ? "Disarmed by landing" : "Disarmed by auto preflight disarming");
}

/// The ramp of the thrust, as PX4 makes it: a bound of the climb that starts where the velocity loop asks for no
/// thrust.
double Autopilot::climb_limit(double now) const {
  if (takeoff_ != Takeoff::kRamp) return std::numeric_limits<double>::infinity();
  const double start = -kGravity / control_.gains().z_vel_p;
  const double share = (now - ramp_since_) / std::max(parameter(ParameterIndex::kTakeoffRampTime), kStep);
  return start + std::min(share, 1.0) * (kTakeoffSpeed - start);
}

double Autopilot::landing_speed(const Estimate& estimate) const {
  return estimate.position.z() - hold_ground_ > kCrawlHeight ? kLandSpeed : kCrawlSpeed;
}

/// Where a mode that needs no companion wants the vehicle: where it can stop, moved by sticks or down to the ground.
PositionSetpoint Autopilot::hold_target(const Estimate& estimate) {
  constexpr double kStopTime = 0.5;  // [s]
  if (!hold_) {
    hold_.emplace();
    hold_->position = estimate.position + kStopTime * estimate.velocity;
    hold_->yaw = yaw_of(estimate.attitude);
  }
  PositionSetpoint target = *hold_;
  if (is_landing()) {
    target.position.z() = kNotGiven;
    target.velocity = {kNotGiven, kNotGiven, -landing_speed(estimate)};
  } else if (mode_ == FlightMode::kPosctl) {
    hold_->position += stick_velocity_ * kStep * kPositionTicks;
    target.velocity = stick_velocity_;
  }
  return target;
}

void Autopilot::update_targets(const Estimate& estimate, double now) {
  const bool offboard = mode_ == FlightMode::kOffboard;
  descends_ = false;
  if (offboard && attitude_target_) {
    attitude_ = *attitude_target_;
  } else if (mode_ == FlightMode::kManual) {  // sticks centred: level, hovering
    attitude_ = {true, Quaternion(Eigen::AngleAxis<double>(yaw_of(estimate.attitude), Vector3::UnitZ())),
                 Vector3::Zero(), control_.gains().hover_thrust};
  } else {
    const PositionSetpoint target = offboard && position_target_ ? *position_target_ : hold_target(estimate);
    attitude_ = control_.follow(estimate, target, climb_limit(now), kStep * kPositionTicks);
    descends_ = control_.wanted_climb() < -0.1;
  }
}

MotorCommands Autopilot::step(const Estimate& estimate, bool contact, double now) {
  while (!delayed_targets_.empty() && now - delayed_targets_.front().at >= kTargetDelay) {
    position_target_ = delayed_targets_.front().target;
    delayed_targets_.pop_front();
  }
  update_mode(now);
  update_landing(contact, now);
  disarm_when_idle(now);
  if (!armed_) return {};
  update_takeoff(estimate, now);
  const bool fresh_attitude = mode_ == FlightMode::kOffboard && attitude_target_;
  if (fresh_attitude || ticks_ % kPositionTicks == 0) update_targets(estimate, now);
  if (ticks_ % kAttitudeTicks == 0)
    rate_ = attitude_.has_attitude ? control_.turn(estimate, attitude_) : attitude_.rate;
  ++ticks_;
  const bool on_legs = takeoff_ == Takeoff::kSpoolUp || takeoff_ == Takeoff::kReady || settles_;
  if (on_legs) return mix(control_.model(), 0, Vector3::Zero());
  return control_.drive(estimate, rate_, attitude_.thrust, kStep);
}

}  // namespace swiftlet::tools
