#include "sim/quadrotor.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet::tools {
namespace {

constexpr std::size_t kMotors = 4;
// By motor: side of the x axis it sits on (left +), of the y axis (rear +: nose down is positive pitch), and the sense
// of its reaction torque.
constexpr std::array<double, kMotors> kRoll{-1, 1, 1, -1};
constexpr std::array<double, kMotors> kPitch{-1, 1, -1, 1};
constexpr std::array<double, kMotors> kYaw{-1, -1, 1, 1};

struct Derivative {
  Vector3 p;
  Vector3 v;
  Eigen::Vector4d q;  ///< x y z w
  Vector3 omega;
  std::array<double, kMotors> thrust;
};

Vector3 torque_of(const VehicleModel& model, const std::array<double, kMotors>& thrust) {
  Vector3 torque = Vector3::Zero();
  for (std::size_t i = 0; i < kMotors; ++i) {
    torque += thrust[i] * Vector3{kRoll[i] * model.arm, kPitch[i] * model.arm, kYaw[i] * model.torque_per_thrust};
  }
  return torque;
}

double total(const std::array<double, kMotors>& thrust) { return thrust[0] + thrust[1] + thrust[2] + thrust[3]; }

Derivative derivative(const VehicleModel& model, const RigidState& s, const MotorCommands& commands,
                      const Vector3& wind_W) {
  Derivative d;
  d.p = s.velocity;
  const Vector3 thrust_W = s.attitude * Vector3{0, 0, total(s.thrust)};
  d.v = (thrust_W - model.drag * (s.velocity - wind_W)) / model.mass - Vector3{0, 0, kGravity};
  const Quaternion rate(0, s.rate.x(), s.rate.y(), s.rate.z());
  d.q = 0.5 * (s.attitude * rate).coeffs();
  const Vector3 momentum = model.inertia.cwiseProduct(s.rate);
  const Vector3 torque = torque_of(model, s.thrust) - model.angular_drag * s.rate - s.rate.cross(momentum);
  d.omega = torque.cwiseQuotient(model.inertia);
  for (std::size_t i = 0; i < kMotors; ++i) {
    d.thrust[i] = (commands[i] * model.thrust_max / kMotors - s.thrust[i]) / model.motor_lag;
  }
  return d;
}

RigidState advanced(const RigidState& s, const Derivative& d, double dt) {
  RigidState next = s;
  next.position += dt * d.p;
  next.velocity += dt * d.v;
  next.attitude.coeffs() += dt * d.q;
  next.rate += dt * d.omega;
  for (std::size_t i = 0; i < kMotors; ++i) next.thrust[i] += dt * d.thrust[i];
  return next;
}

}  // namespace

double yaw_of(const Quaternion& q_WB) {
  const Vector3 x_W = q_WB * Vector3::UnitX();
  return std::atan2(x_W.y(), x_W.x());
}

MotorCommands mix(const VehicleModel& model, double thrust, const Vector3& torque_B) {
  const double full = model.thrust_max / kMotors;
  const double idle = model.thrust_min / kMotors;
  std::array<double, kMotors> tilt{};
  for (std::size_t i = 0; i < kMotors; ++i) {
    tilt[i] = (kRoll[i] * torque_B.x() + kPitch[i] * torque_B.y()) / (kMotors * model.arm);
  }
  const auto [low, high] = std::minmax_element(tilt.begin(), tilt.end());
  const double share = std::min(1.0, (full - idle) / std::max(*high - *low, 1e-9));
  const double base = std::clamp(thrust / kMotors, idle - share * *low, full - share * *high);
  // What roll, pitch and thrust leave is yaw's.
  const double room = std::min(base + share * *low - idle, full - base - share * *high);
  const double yaw = std::clamp(torque_B.z() / (kMotors * model.torque_per_thrust), -room, room);
  MotorCommands commands{};
  for (std::size_t i = 0; i < kMotors; ++i) {
    commands[i] = std::clamp((base + share * tilt[i] + kYaw[i] * yaw) / full, idle / full, 1.0);
  }
  return commands;
}

Quadrotor::Quadrotor(const VehicleModel& model, const Vector3& p_W, double yaw) : model_(model), ground_(p_W.z()) {
  state_.position = p_W;
  state_.attitude = Eigen::AngleAxis<double>(yaw, Vector3::UnitZ());
}

void Quadrotor::step(double dt, const MotorCommands& commands, const Vector3& wind_W) {
  const RigidState& s = state_;
  const Derivative k1 = derivative(model_, s, commands, wind_W);
  const Derivative k2 = derivative(model_, advanced(s, k1, dt / 2), commands, wind_W);
  const Derivative k3 = derivative(model_, advanced(s, k2, dt / 2), commands, wind_W);
  const Derivative k4 = derivative(model_, advanced(s, k3, dt), commands, wind_W);
  Derivative mean;
  mean.p = (k1.p + 2 * k2.p + 2 * k3.p + k4.p) / 6;
  mean.v = (k1.v + 2 * k2.v + 2 * k3.v + k4.v) / 6;
  mean.q = (k1.q + 2 * k2.q + 2 * k3.q + k4.q) / 6;
  mean.omega = (k1.omega + 2 * k2.omega + 2 * k3.omega + k4.omega) / 6;
  for (std::size_t i = 0; i < kMotors; ++i) {
    mean.thrust[i] = (k1.thrust[i] + 2 * k2.thrust[i] + 2 * k3.thrust[i] + k4.thrust[i]) / 6;
  }
  const RigidState next = advanced(s, mean, dt);
  if (on_ground_ && total(s.thrust) <= model_.mass * kGravity) {  // legs hold it
    state_.thrust = next.thrust;
    return;
  }
  state_ = next;
  state_.attitude.normalize();
  meet_ground();
}

void Quadrotor::meet_ground() {
  const bool touches = state_.position.z() <= ground_;
  if (touches && !on_ground_) {
    impact_speed_ = std::max(impact_speed_, state_.velocity.norm());
    const double yaw = yaw_of(state_.attitude);
    state_.attitude = Eigen::AngleAxis<double>(yaw, Vector3::UnitZ());
    state_.rate.setZero();
    state_.velocity.setZero();
  }
  if (touches) {
    state_.position.z() = ground_;
    state_.velocity.z() = std::max(state_.velocity.z(), 0.0);
  }
  on_ground_ = touches;
}

}  // namespace swiftlet::tools
