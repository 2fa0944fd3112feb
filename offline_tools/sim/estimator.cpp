#include "sim/estimator.hpp"

#include <cmath>

namespace swiftlet::tools {
namespace {

// [s] How long each error lasts.
constexpr double kPositionTime = 2;
constexpr double kVelocityTime = 0.5;
constexpr double kAttitudeTime = 1.5;
constexpr double kNoiseStep = 0.004;

Quaternion about_z(double angle) { return Quaternion(Eigen::AngleAxis<double>(angle, Vector3::UnitZ())); }

}  // namespace

Estimator::Estimator(const EstimatorSettings& settings, std::uint64_t seed)
    : settings_(settings),
      noise_(seed),
      position_(settings.position_sigma, kPositionTime),
      velocity_(settings.velocity_sigma, kVelocityTime),
      attitude_(settings.attitude_sigma, kAttitudeTime),
      offset_(settings.boot_sigma.cwiseProduct(noise_.vector())),
      local_of_world_(about_z(-settings.heading)) {}

void Estimator::step(double dt, const RigidState& truth, bool armed) {
  since_noise_ += dt;
  if (since_noise_ >= kNoiseStep - dt / 2) {
    step_noise(since_noise_, armed);
    since_noise_ = 0;
  }
  past_.push_back(truth);
  const auto kept = static_cast<std::size_t>(std::lround(settings_.delay / dt)) + 1;
  while (past_.size() > kept) past_.pop_front();
  estimate_ = localized(past_.front());
  estimate_.position += position_.value();
  estimate_.velocity += velocity_.value();
  const Vector3 half = attitude_.value() / 2;
  estimate_.attitude = (estimate_.attitude * Quaternion(1, half.x(), half.y(), half.z())).normalized();
  estimate_.rate += settings_.rate_sigma.cwiseProduct(noise_.vector());
}

void Estimator::step_noise(double dt, bool armed) {
  position_.step(dt, noise_);
  velocity_.step(dt, noise_);
  attitude_.step(dt, noise_);
  const Vector3 drift = std::sqrt(dt) * settings_.drift_sigma.cwiseProduct(noise_.vector());
  if (!armed) offset_ += drift;
}

Vector3 Estimator::to_local(const Vector3& p_W) const { return local_of_world_ * (p_W - settings_.origin) + offset_; }

Vector3 Estimator::to_world(const Vector3& p_L) const {
  return local_of_world_.conjugate() * (p_L - offset_) + settings_.origin;
}

Estimate Estimator::localized(const RigidState& truth) const {
  return {to_local(truth.position), local_of_world_ * truth.velocity, local_of_world_ * truth.attitude, truth.rate};
}

}  // namespace swiftlet::tools
