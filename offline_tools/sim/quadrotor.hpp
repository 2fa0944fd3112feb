#pragma once
#include <Eigen/Geometry>
#include <array>

#include "swiftlet/types.hpp"

namespace swiftlet::tools {

using Quaternion = Eigen::Quaternion<double>;

/// The simulated vehicle. The defaults are those of the simulator built into PX4 ("sihsim_quadx"), with the drag that
/// the autopilot's own tracking was measured at.
struct VehicleModel {
  double mass = 1;                       ///< [kg]
  double thrust_min = 0;                 ///< [N] all four motors, idling
  double rate_max = 3.84;                ///< [rad/s] that its autopilot lets it roll and pitch at
  double thrust_max = 20;                ///< [N] all four motors
  Vector3 inertia{0.025, 0.025, 0.030};  ///< [kg m^2] principal moments, frame B
  double motor_lag = 0.05;               ///< [s] of first order
  double arm = 0.2;                      ///< [m] of a motor from the centre, along x and along y
  double torque_per_thrust = 0.02;       ///< [m] reaction of a propeller
  double drag = 0.25;                    ///< [N/(m/s)] linear, same on every axis
  double angular_drag = 0.025;           ///< [N m/(rad/s)]
};

/// The fraction of full thrust at which the vehicle hovers.
inline double hover_fraction(const VehicleModel& model) { return model.mass * kGravity / model.thrust_max; }

/// Front right, rear left, front left, rear right; each 0 (off) to 1 (full thrust).
using MotorCommands = std::array<double, 4>;

/// Frame W is ENU, frame B forward-left-up.
struct RigidState {
  Vector3 position = Vector3::Zero();            ///< [m] of the centre of mass, frame W
  Vector3 velocity = Vector3::Zero();            ///< [m/s] frame W
  Quaternion attitude = Quaternion::Identity();  ///< from B to W
  Vector3 rate = Vector3::Zero();                ///< [rad/s] frame B
  std::array<double, 4> thrust{};                ///< [N] of each motor, after its lag
};

/// Motor commands for a thrust [N] along the body's z axis and a torque [N m] in frame B. Where the motors cannot give
/// both, yaw gives way first, then thrust.
MotorCommands mix(const VehicleModel& model, double thrust, const Vector3& torque_B);

/// A rigid body with four motors over level ground, integrated by the classical Runge-Kutta method. On the ground it
/// stands level and still until its thrust exceeds its weight.
class Quadrotor {
 public:
  /// Stands on the ground at `p_W`, whose height is the ground's from then on, with heading `yaw` [rad] from east.
  Quadrotor(const VehicleModel& model, const Vector3& p_W, double yaw);

  /// `dt` [s] at most a fifth of the motors' lag; `wind_W` [m/s] is constant over it.
  void step(double dt, const MotorCommands& commands, const Vector3& wind_W);

  [[nodiscard]] const RigidState& state() const { return state_; }
  [[nodiscard]] const VehicleModel& model() const { return model_; }
  [[nodiscard]] bool on_ground() const { return on_ground_; }
  [[nodiscard]] double ground() const { return ground_; }  ///< [m] height of the ground
  /// Over steps and edges: from now on the ground is level at this height [m], unless the vehicle stands on it.
  void set_ground(double height) {
    if (!on_ground_) ground_ = height;
  }
  [[nodiscard]] double impact_speed() const { return impact_speed_; }  ///< [m/s] fastest touch-down so far

 private:
  void meet_ground();

  VehicleModel model_;
  RigidState state_;
  double ground_;
  bool on_ground_ = true;
  double impact_speed_ = 0;
};

/// The angle from east to the body's x axis, anticlockwise [rad].
double yaw_of(const Quaternion& q_WB);

}  // namespace swiftlet::tools
