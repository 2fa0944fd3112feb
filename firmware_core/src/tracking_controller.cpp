#include "swiftlet/tracking_controller.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/trigonometry.hpp"

namespace swiftlet {
namespace {

const Vector3 kWeight{0, 0, kGravity};

bool is_sane(const Vector3& v) { return (v.array().abs() <= kLargestInput).all(); }

bool is_usable(const Reference& reference) {
  const Sample& sample = reference.sample;
  return is_sane(sample.position) && is_sane(sample.velocity) && is_sane(sample.acceleration) && is_sane(sample.jerk) &&
         std::fabs(reference.yaw) <= kLargestInput && std::fabs(reference.yaw_rate) <= kLargestInput;
}

Vector3 clamped(const Vector3& v, const Vector3& bound) { return v.cwiseMax(-bound).cwiseMin(bound); }

}  // namespace

void TrackingController::reset() {
  desired_attitude_.setIdentity();
  desired_rates_.setZero();
}

/// Bounds a specific force [m/s^2]; true when it had to change.
bool TrackingController::bound_force(Vector3& force) const {
  const Vector3 wanted = force;
  force.z() = std::clamp(force.z(), settings_.thrust_min, settings_.thrust_max);
  const Real horizontal = std::sqrt(force.x() * force.x() + force.y() * force.y());
  const Real left2 = settings_.thrust_max * settings_.thrust_max - force.z() * force.z();
  const Real most =
      std::min(force.z() * sine(settings_.tilt_max) / cosine(settings_.tilt_max), std::sqrt(std::max(left2, Real(0))));
  if (horizontal > most) {
    force.x() *= most / horizontal;
    force.y() *= most / horizontal;
  }
  return (force - wanted).squaredNorm() > 0;
}

/// Everything but the attitude loop.
TrackingCommand TrackingController::command_for(const Reference& reference, const Vector3& feedback,
                                                CommandBasis basis) {
  TrackingCommand command;
  command.basis = basis;
  command.position = reference.sample.position;
  command.velocity = reference.sample.velocity;
  command.acceleration = reference.sample.acceleration + settings_.drag * reference.sample.velocity;
  command.yaw = wrap_angle(reference.yaw);
  command.yaw_rate = reference.yaw_rate;
  Vector3 force = reference.sample.acceleration + feedback + kWeight;
  command.saturated = bound_force(force);
  command.commanded_acceleration = force - kWeight;
  const Result<FlatState> flat = flat_to_state(
      {command.commanded_acceleration, reference.sample.jerk, reference.yaw, reference.yaw_rate}, desired_attitude_);
  if (!flat.ok()) return level();  // not reached: everything was bounded
  desired_attitude_ = flat->attitude;
  desired_rates_ = flat->body_rates;
  command.attitude = to_quaternion(desired_attitude_);
  command.body_rates = clamped(desired_rates_, settings_.rate_max);
  command.thrust = flat->thrust;
  command.force = settings_.mass * command.thrust;
  return command;
}

/// Thrust along the axis that the body has, moment and body rates that turn it to the one that it should have.
void TrackingController::close_attitude_loop(const VehicleState& state, TrackingCommand& command) const {
  const Matrix3 R_WB = state.attitude.normalized().toRotationMatrix();
  const Matrix3 R_BD = R_WB.transpose() * desired_attitude_;
  // (R_BD^T - R_BD)^vee / 2
  const Vector3 e_R = Vector3{R_BD(1, 2) - R_BD(2, 1), R_BD(2, 0) - R_BD(0, 2), R_BD(0, 1) - R_BD(1, 0)} / 2;
  const Vector3 omega_D_B = R_BD * desired_rates_;
  const Vector3 e_omega = state.body_rates - omega_D_B;
  command.moment = -settings_.k_attitude.cwiseProduct(e_R) - settings_.k_rate.cwiseProduct(e_omega);
  command.body_rates = clamped(omega_D_B - settings_.k_attitude_rate.cwiseProduct(e_R), settings_.rate_max);
  const Real along = (command.commanded_acceleration + kWeight).dot(R_WB.col(2));
  command.thrust = std::clamp(along, settings_.thrust_min, settings_.thrust_max);
  command.force = settings_.mass * command.thrust;
}

TrackingCommand TrackingController::level() const {
  TrackingCommand command;
  Singularity singularity{};
  const Real heading = heading_of(desired_attitude_);
  command.yaw = heading;
  command.attitude = to_quaternion(attitude_from(Vector3::UnitZ(), heading, desired_attitude_, singularity));
  command.force = settings_.mass * kGravity;
  return command;
}

TrackingCommand TrackingController::step(const Reference& reference, const VehicleState& state,
                                         const Vector3& disturbance) {
  if (!is_usable(reference)) return level();
  const Vector3 taken_off = is_sane(disturbance) ? Vector3(-disturbance) : Vector3::Zero();
  if (!is_usable(state)) return command_for(reference, taken_off, CommandBasis::kReference);
  const Vector3 e_r = state.position - reference.sample.position;
  const Vector3 e_v = state.velocity - reference.sample.velocity;
  const Vector3 feedback = -settings_.k_position.cwiseProduct(e_r) - settings_.k_velocity.cwiseProduct(e_v);
  TrackingCommand command = command_for(reference, feedback + taken_off, CommandBasis::kFeedback);
  const Vector3 addition = -settings_.k_position_form.cwiseProduct(e_r) - settings_.k_velocity_form.cwiseProduct(e_v);
  command.acceleration += clamped(addition, Vector3::Constant(settings_.form_feedback_max));
  close_attitude_loop(state, command);
  return command;
}

}  // namespace swiftlet
