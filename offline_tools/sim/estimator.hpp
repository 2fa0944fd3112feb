#pragma once
#include <cstdint>
#include <deque>

#include "sim/noise.hpp"
#include "sim/quadrotor.hpp"

namespace swiftlet::tools {

/// What the autopilot believes. Frame L is its local frame: level, z up, like W but for origin and heading.
struct Estimate {
  Vector3 position = Vector3::Zero();            ///< [m] frame L
  Vector3 velocity = Vector3::Zero();            ///< [m/s] frame L
  Quaternion attitude = Quaternion::Identity();  ///< from B to L
  Vector3 rate = Vector3::Zero();                ///< [rad/s] frame B
};

/// Errors of an estimator with positions of a few centimetres (motion capture, or satellites with corrections) and the
/// inertial noise of PX4's built-in simulator. A tilt that is believed wrong accelerates the vehicle: that is what lets
/// a hovering one wander.
struct EstimatorSettings {
  double delay = 0;                            ///< [s] of the whole estimate
  Vector3 position_sigma{0.01, 0.01, 0.02};    ///< [m]
  Vector3 velocity_sigma{0.02, 0.02, 0.02};    ///< [m/s]
  Vector3 attitude_sigma{0.032, 0.032, 0.01};  ///< [rad] rotation vector in frame B
  Vector3 rate_sigma{0.01, 0.01, 0.01};        ///< [rad/s] white
  Vector3 origin = Vector3::Zero();            ///< [m] of frame L in frame W, but for the drift
  double heading = 0;                          ///< [rad] of L's x axis in W, anticlockwise
  Vector3 boot_sigma{0.1, 0.1, 0.4};           ///< [m] local position of a vehicle that boots at `origin`
  Vector3 drift_sigma{0.02, 0.02, 0.05};       ///< [m/sqrt(s)] of the origin until arming
};

/// Turns the truth into what the autopilot believes.
class Estimator {
 public:
  Estimator(const EstimatorSettings& settings, std::uint64_t seed);

  /// The origin drifts until `armed`.
  void step(double dt, const RigidState& truth, bool armed);
  /// An error that stays, as after a false fix [m], frame L.
  void jump(const Vector3& offset) { offset_ += offset; }

  [[nodiscard]] const Estimate& estimate() const { return estimate_; }

  /// The truth without errors but in frame L as it lies now: what a perfect estimator would say.
  [[nodiscard]] Vector3 to_local(const Vector3& p_W) const;
  [[nodiscard]] Vector3 to_world(const Vector3& p_L) const;

 private:
  [[nodiscard]] Estimate localized(const RigidState& truth) const;
  void step_noise(double dt, bool armed);

  EstimatorSettings settings_;
  Noise noise_;
  ColouredNoise position_;
  ColouredNoise velocity_;
  ColouredNoise attitude_;
  Vector3 offset_;  ///< [m] frame L
  Quaternion local_of_world_;
  std::deque<RigidState> past_;  ///< oldest first, a step apart
  Estimate estimate_;
  double since_noise_ = 0;
};

}  // namespace swiftlet::tools
