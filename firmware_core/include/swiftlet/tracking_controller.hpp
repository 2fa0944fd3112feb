#pragma once
#include <cstdint>

#include "swiftlet/flatness.hpp"
#include "swiftlet/trajectory.hpp"
#include "swiftlet/types.hpp"
#include "swiftlet/vehicle_state.hpp"

namespace swiftlet {

/// Gains and bounds of the controller. Position gains are per unit of mass, so they do not change with the payload.
struct ControllerSettings {
  Real mass = 1;                                           ///< [kg] m
  Vector3 k_position = {Real(12), Real(12), Real(12)};     ///< [1/s^2] k_x / m
  Vector3 k_velocity = {Real(5), Real(5), Real(5)};        ///< [1/s] k_v / m
  Vector3 k_attitude = {Real(0.8), Real(0.8), Real(0.3)};  ///< [N m] k_R
  Vector3 k_rate = {Real(0.12), Real(0.12), Real(0.08)};   ///< [N m s] k_omega
  Vector3 k_attitude_rate = {Real(7), Real(7), Real(3)};   ///< [1/s] attitude error to body rate
  // Position form: what our own feedback adds to the acceleration that the autopilot's slower loop is given.
  Vector3 k_position_form = {Real(3), Real(3), Real(3)};  ///< [1/s^2]
  Vector3 k_velocity_form = {Real(1), Real(1), Real(1)};  ///< [1/s]
  Real form_feedback_max = 1;                             ///< [m/s^2] per axis
  Real drag = 0;               ///< [1/s] linear drag over mass, added to the position form's acceleration (drag * v)
  Real tilt_max = Real(0.6);   ///< [rad] of the commanded attitude, < pi/2
  Real thrust_min = Real(3);   ///< [m/s^2] specific, > 0: attitude is defined
  Real thrust_max = Real(18);  ///< [m/s^2]
  Vector3 rate_max = {Real(3), Real(3), Real(1.5)};  ///< [rad/s] of the commanded body rates
};

/// What is to be tracked at the instant when the command takes effect.
struct Reference {
  Sample sample;
  Real yaw = 0;       ///< [rad]
  Real yaw_rate = 0;  ///< [rad/s]
};

/// What a command rests on. With bad numbers the last command is never repeated: an old one is worse than none.
enum class CommandBasis : std::uint8_t {
  kFeedback,   ///< reference and measured state
  kReference,  ///< the state is unusable: the reference's own attitude, thrust and rates, open loop
  kLevel,      ///< the reference is unusable: level at the last heading, hover thrust, no rates; no position form
};

/// One command in all three forms; whichever is sent, its numbers are finite.
struct TrackingCommand {
  CommandBasis basis = CommandBasis::kLevel;
  // Position form: the reference; its acceleration with drag and, where the state is usable, feedback.
  Vector3 position = Vector3::Zero();
  Vector3 velocity = Vector3::Zero();
  Vector3 acceleration = Vector3::Zero();
  Real yaw = 0;
  Real yaw_rate = 0;
  // Attitude form and body rate form, both with thrust.
  Quaternion attitude{1, 0, 0, 0};       ///< q_WB, w >= 0
  Vector3 body_rates = Vector3::Zero();  ///< [rad/s] omega_WB_B
  Real thrust = kGravity;                ///< [m/s^2] specific, along body z, in [thrust_min, thrust_max]
  // Eq. 4.
  Real force = 0;                    ///< [N] f
  Vector3 moment = Vector3::Zero();  ///< [N m] M_b
  // What the predictor and the log want.
  Vector3 commanded_acceleration = Vector3::Zero();  ///< [m/s^2] after all bounds
  bool saturated = false;                            ///< a bound of thrust or tilt is active
};

/// The controller of eq. 4 (Mellinger and Kumar 2011) with a disturbance d that is known (StatePredictor) taken off,
/// where the usual one has an integral:
///   f = z_B . m (-k_x e_r - k_v e_v - d + a_d + g z_W)     M = -k_R e_R - k_omega e_omega
/// with e_r = r - r_d, e_R = (R_d^T R - R^T R_d)^vee / 2, e_omega = omega - R^T R_d omega_d, and R_d, omega_d from
/// flatness. The desired force is bounded before the attitude is taken from it: its vertical part to the thrust bounds,
/// its horizontal part to tilt_max and to what thrust_max leaves.
class TrackingController {
 public:
  explicit TrackingController(const ControllerSettings& settings) : settings_(settings) {}

  /// `state` is the measured state predicted to the instant of the reference, `disturbance` [m/s^2] what acts on the
  /// vehicle beyond thrust and gravity; one that is not finite counts as none. A state that is unusable, or not to be
  /// trusted (pass one that is unusable), leaves the reference open loop.
  TrackingCommand step(const Reference& reference, const VehicleState& state, const Vector3& disturbance);

  /// Forgets the last attitude: when control was not ours.
  void reset();

 private:
  bool bound_force(Vector3& force) const;
  TrackingCommand command_for(const Reference& reference, const Vector3& feedback, CommandBasis basis);
  void close_attitude_loop(const VehicleState& state, TrackingCommand& command) const;
  [[nodiscard]] TrackingCommand level() const;

  ControllerSettings settings_;
  Matrix3 desired_attitude_ = Matrix3::Identity();  // last desired attitude
  Vector3 desired_rates_ = Vector3::Zero();         // its rates, in its own frame
};

}  // namespace swiftlet
