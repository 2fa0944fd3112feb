#include "sim/flight_control.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet::tools {
namespace {

// MC_ROLLRATE_P, I and D as angular accelerations: they give the bandwidth that those defaults give the vehicle of
// PX4's built-in simulator, to a vehicle of any inertia.
constexpr double kRateP = 17;  // [1/s]
constexpr double kRateI = 22;  // [1/s^2]
constexpr double kRateD = 0.34;
constexpr double kYawRateP = 8;                // [1/s]
constexpr double kRateIntegralMax = 5;         // [rad/s^2]
constexpr double kSlopeFilter = 0.005;         // [s] IMU_DGYRO_CUTOFF of 30 Hz
constexpr double kAccelerationFilter = 0.032;  // [s] MPC_VELD_LP of 5 Hz

double given_or(double value, double otherwise) { return std::isnan(value) ? otherwise : value; }

Vector3 limited(const Vector3& v, double norm) { return v.norm() > norm ? Vector3(v * (norm / v.norm())) : v; }

/// The attitude whose z axis is `up` and whose x axis lies in the vertical plane of `yaw`.
Quaternion attitude_of(const Vector3& up, double yaw) {
  const Vector3 left{-std::sin(yaw), std::cos(yaw), 0};
  Eigen::Matrix3d R;
  R.col(2) = up;
  R.col(0) = left.cross(up).normalized();
  R.col(1) = up.cross(R.col(0));
  return Quaternion(R);
}

}  // namespace

void FlightControl::reset() {
  velocity_integral_.setZero();
  rate_integral_.setZero();
  last_velocity_.setConstant(kNotGiven);
  acceleration_.setZero();
  thrust_ = 0;
}

Vector3 FlightControl::wanted_velocity(const Estimate& estimate, const PositionSetpoint& target,
                                       double climb_limit) const {
  Vector3 wanted = Vector3::Constant(kNotGiven);
  const Vector3 gain{gains_.xy_p, gains_.xy_p, gains_.z_p};
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isnan(target.velocity[axis])) wanted[axis] = target.velocity[axis];
    if (!std::isnan(target.position[axis])) {
      wanted[axis] = given_or(wanted[axis], 0) + gain[axis] * (target.position[axis] - estimate.position[axis]);
    }
  }
  const double speed = std::hypot(wanted.x(), wanted.y());
  if (speed > gains_.xy_vel_max) wanted.head<2>() *= gains_.xy_vel_max / speed;
  if (!std::isnan(wanted.z())) {
    wanted.z() = std::clamp(wanted.z(), -gains_.vel_max_down, gains_.vel_max_up);
  }
  if (std::isfinite(climb_limit)) wanted.z() = std::min(given_or(wanted.z(), climb_limit), climb_limit);
  return wanted;
}

Vector3 FlightControl::wanted_acceleration(const Estimate& estimate, const Vector3& velocity, double dt) {
  const Vector3 slope =
      last_velocity_.allFinite() ? Vector3((estimate.velocity - last_velocity_) / dt) : Vector3::Zero();
  acceleration_ += dt / (kAccelerationFilter + dt) * (slope - acceleration_);
  last_velocity_ = estimate.velocity;
  const Vector3 p{gains_.xy_vel_p, gains_.xy_vel_p, gains_.z_vel_p};
  const Vector3 i{gains_.xy_vel_i, gains_.xy_vel_i, gains_.z_vel_i};
  const Vector3 d{gains_.xy_vel_d, gains_.xy_vel_d, 0};
  Vector3 wanted = Vector3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    if (std::isnan(velocity[axis])) continue;  // only an acceleration was asked for
    const double error = velocity[axis] - estimate.velocity[axis];
    const bool saturated = axis == 2 && ((thrust_ <= gains_.thrust_min && error < 0) || (thrust_ >= 1 && error > 0));
    if (!saturated) velocity_integral_[axis] += i[axis] * error * dt;
    velocity_integral_[axis] = std::clamp(velocity_integral_[axis], -kGravity / 2, kGravity / 2);
    wanted[axis] = p[axis] * error + velocity_integral_[axis] - d[axis] * acceleration_[axis];
  }
  return wanted;
}

AttitudeSetpoint FlightControl::follow(const Estimate& estimate, const PositionSetpoint& target, double climb_limit,
                                       double dt) {
  const Vector3 velocity = wanted_velocity(estimate, target, climb_limit);
  wanted_climb_ = given_or(velocity.z(), given_or(target.acceleration.z(), 0));
  Vector3 acceleration = wanted_acceleration(estimate, velocity, dt);
  const bool ramp = std::isfinite(climb_limit);  // feed-forward waits until the vehicle flies
  for (int axis = 0; axis < 3 && !ramp; ++axis) acceleration[axis] += given_or(target.acceleration[axis], 0);

  AttitudeSetpoint attitude;
  attitude.has_attitude = true;
  const Vector3 lift{acceleration.x(), acceleration.y(), kGravity};
  Vector3 up = lift.normalized();
  if (const double level = up.head<2>().norm(); level > std::sin(gains_.tilt_max)) {
    up.head<2>() *= std::sin(gains_.tilt_max) / level;
    up.z() = std::cos(gains_.tilt_max);
  }
  attitude.attitude = attitude_of(up, given_or(target.yaw, yaw_of(estimate.attitude)));
  attitude.rate.z() = given_or(target.yaw_rate, 0);
  const double collective = gains_.hover_thrust * (1 + acceleration.z() / kGravity) / up.z();
  attitude.thrust = thrust_ = std::clamp(collective, gains_.thrust_min, 1.0);
  return attitude;
}

/// PX4's quaternion control: tilt first, and of the remaining turn about the body's z axis only a part.
Vector3 FlightControl::turn(const Estimate& estimate, const AttitudeSetpoint& target) const {
  const Quaternion& q = estimate.attitude;
  const Quaternion tilt = Quaternion::FromTwoVectors(q * Vector3::UnitZ(), target.attitude * Vector3::UnitZ());
  const Quaternion reduced = tilt * q;
  Quaternion about_z = reduced.conjugate() * target.attitude;
  if (about_z.w() < 0) about_z.coeffs() *= -1;
  const double half = std::atan2(about_z.z(), about_z.w()) * gains_.yaw_weight;
  const Quaternion wanted = reduced * Quaternion(std::cos(half), 0, 0, std::sin(half));
  Quaternion error = q.conjugate() * wanted;
  if (error.w() < 0) error.coeffs() *= -1;
  const Vector3 gain{gains_.attitude_p, gains_.attitude_p, gains_.yaw_p / gains_.yaw_weight};
  Vector3 rate = 2 * gain.cwiseProduct(error.vec());
  rate += q.conjugate() * Vector3{0, 0, target.rate.z()};
  return rate;
}

MotorCommands FlightControl::drive(const Estimate& estimate, const Vector3& rate, double thrust, double dt) {
  const Vector3 limit{model_.rate_max, model_.rate_max, std::min(model_.rate_max, gains_.yaw_rate_max)};
  const Vector3 error = rate.cwiseMax(-limit).cwiseMin(limit) - estimate.rate;
  rate_slope_ += dt / (kSlopeFilter + dt) * ((estimate.rate - last_rate_) / dt - rate_slope_);
  last_rate_ = estimate.rate;
  rate_integral_ = limited(rate_integral_ + kRateI * dt * error, kRateIntegralMax);
  const Vector3 p{kRateP, kRateP, kYawRateP};
  const Vector3 d{kRateD, kRateD, 0};
  const Vector3 angular = p.cwiseProduct(error) + rate_integral_ - d.cwiseProduct(rate_slope_);
  return mix(model_, thrust * model_.thrust_max, model_.inertia.cwiseProduct(angular));
}

}  // namespace swiftlet::tools
