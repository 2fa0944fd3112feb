#include "companion/settings.hpp"

#include <cmath>

#include "swiftlet/flatness.hpp"

namespace swiftlet::companion {
namespace {

constexpr TimeUs kLongest = 60 * kSecondUs;
constexpr TimeUs kIdleDisarm = 10 * kSecondUs;  // PX4 disarms a vehicle that has not taken off by then
constexpr Real kSteepest = Real(1.5);           // [rad] short of a right angle
constexpr Real kMaxSearchWeight = Real(1e6);

// All false for NaN.
bool is_share(Real value) { return value >= 0 && value <= 100; }
bool is_positive_share(Real value) { return value > 0 && value <= 100; }
bool are_shares(const Vector3& v) { return is_share(v.x()) && is_share(v.y()) && is_share(v.z()); }
bool is_place(const Vector3& v) { return (v.array().abs() <= kLargestInput).all(); }
bool is_angle(Real value) { return std::fabs(value) <= kLargestInput; }
bool is_time(TimeUs value) { return value >= 0 && value <= kLongest; }
bool is_positive_time(TimeUs value) { return value > 0 && value <= kLongest; }

const char* flight_fault(const Settings& settings) {
  if (settings.system_id == 0) return "system id: not in 1 to 255";
  if (!is_usable(settings.limits)) return "limits: not positive, out of range, or a vehicle that cannot hover";
  if (!is_place(settings.start) || !is_angle(settings.start_yaw)) return "start: not finite, or out of range";
  if (!is_positive_share(settings.arrival_tolerance)) return "arrival tolerance: not in 0 to 100 m";
  const Margins& margins = settings.margins;
  for (const Real share : {margins.vehicle_radius, margins.map_error, margins.numeric_margin, margins.tubes.position,
                           margins.tubes.attitude, margins.tubes.rates}) {
    if (!is_share(share)) return "margins: not in 0 to 100 m";
  }
  if (!(margins.heading_accuracy >= 0 && margins.heading_accuracy <= 1)) return "heading accuracy: not in 0 to 1 rad";
  const Real weight = settings.planning.search.weight;
  if (!(weight >= 1 && weight <= kMaxSearchWeight)) return "search weight: not in 1 to 1e6";
  for (const TimeUs time : {settings.planning.latency, settings.delays.position, settings.delays.attitude,
                            settings.delays.rates, settings.predictor.longest}) {
    if (!is_time(time)) return "a time: not in 0 to 60 s";
  }
  return nullptr;
}

const char* takeoff_fault(const TakeoffSettings& takeoff) {
  if (!is_positive_share(takeoff.height)) return "take-off height: not in 0 to 100 m";
  if (!(takeoff.tolerance > 0 && takeoff.tolerance < takeoff.height))
    return "take-off tolerance: not between 0 and the height";
  if (!is_positive_time(takeoff.patience)) return "take-off patience: not in 0 to 60 s";
  if (!(is_time(takeoff.standing) && takeoff.standing < kIdleDisarm))
    return "standing: not in 0 to 10 s, after which PX4 disarms";
  return nullptr;
}

const char* yaw_fault(const YawSettings& yaw) {
  if (!is_positive_share(yaw.rate_max) || !is_positive_share(yaw.acceleration_max))
    return "yaw limits: not in 0 to 100";
  if (!is_share(yaw.look_ahead) || !is_share(yaw.least_distance)) return "yaw distances: not in 0 to 100";
  if (!is_angle(yaw.angle) || !is_place(yaw.target)) return "yaw angle or point: not finite, or out of range";
  return nullptr;
}

const char* control_fault(const ControllerSettings& control) {
  for (const Vector3& gain : {control.k_position, control.k_velocity, control.k_attitude, control.k_rate,
                              control.k_attitude_rate, control.k_position_form, control.k_velocity_form}) {
    if (!are_shares(gain)) return "control: a gain is not in 0 to 100";
  }
  if (!is_share(control.form_feedback_max) || !is_share(control.drag))
    return "control: feedback or drag not in 0 to 100";
  if (!(control.mass > 0 && control.mass <= kLargestInput)) return "control: mass not positive, or out of range";
  if (!(control.tilt_max > 0 && control.tilt_max <= kSteepest)) return "control: tilt not in 0 to 1.5 rad";
  if (!(control.thrust_min > 0 && control.thrust_min < kGravity && kGravity < control.thrust_max &&
        control.thrust_max <= 1000))
    return "control: thrust bounds do not hold gravity between them";
  if (!are_shares(control.rate_max) || !(control.rate_max.minCoeff() > 0))
    return "control: rates not in 0 to 100 rad/s";
  return nullptr;
}

const char* estimation_fault(const PredictorSettings& predictor, const HoverThrustSettings& hover) {
  for (const Real share : {predictor.response_time, predictor.thrust_time, predictor.disturbance_max}) {
    if (!is_share(share)) return "predictor: not in 0 to 100";
  }
  if (!is_positive_share(predictor.disturbance_time)) return "predictor: disturbance time not in 0 to 100 s";
  if (!(hover.least > 0 && hover.least <= hover.initial && hover.initial <= hover.most && hover.most <= 1))
    return "hover thrust: not 0 < least <= initial <= most <= 1";
  if (!is_share(hover.time_constant) || !is_positive_time(hover.window)) return "hover thrust: a time is out of range";
  return nullptr;
}

const char* supervisor_fault(const SupervisorSettings& supervisor) {
  for (const TimeUs time : {supervisor.odometry_age_max, supervisor.link_age_max, supervisor.setpoint_age_max,
                            supervisor.setpoint_age_yield, supervisor.clock_gap_max}) {
    if (!is_positive_time(time)) return "supervisor: a time is not in 0 to 60 s";
  }
  if (!is_time(supervisor.blocked_patience)) return "supervisor: blocked patience not in 0 to 60 s";
  if (supervisor.setpoint_age_yield < supervisor.setpoint_age_max) return "supervisor: yields before it brakes";
  if (supervisor.deadline_misses_max == 0) return "supervisor: no missed deadline is one too many";
  if (!is_positive_share(supervisor.position_jump)) return "supervisor: position jump not in 0 to 100 m";
  return nullptr;
}

}  // namespace

const char* find_fault(const Settings& settings) {
  for (const char* fault :
       {flight_fault(settings), takeoff_fault(settings.takeoff), yaw_fault(settings.yaw),
        control_fault(settings.control.attitude), control_fault(settings.control.rates),
        estimation_fault(settings.predictor, settings.hover_thrust), supervisor_fault(settings.supervisor)}) {
    if (fault != nullptr) return fault;
  }
  return nullptr;
}

MarginReport margins_of(const Settings& settings, Real map_radius, const Tie& tie) {
  MarginLedger ledger;
  ledger.vehicle_radius = settings.margins.vehicle_radius;
  ledger.map_error = settings.margins.map_error + tie.error;
  ledger.tracking_tube = tube_of(settings.margins.tubes, settings.form);
  ledger.numeric_margin = settings.margins.numeric_margin;
  ledger.heading_accuracy = static_cast<Real>(tie.readings) * settings.margins.heading_accuracy;
  return check_margins(ledger, map_radius);
}

}  // namespace swiftlet::companion
