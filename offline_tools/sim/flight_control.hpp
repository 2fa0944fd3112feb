#pragma once
#include <limits>

#include "sim/estimator.hpp"

namespace swiftlet::tools {

inline constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

/// What SET_POSITION_TARGET_LOCAL_NED asks for, in frame L; a component that is not a number is not asked for.
struct PositionSetpoint {
  Vector3 position = Vector3::Constant(kNotGiven);      ///< [m]
  Vector3 velocity = Vector3::Constant(kNotGiven);      ///< [m/s]
  Vector3 acceleration = Vector3::Constant(kNotGiven);  ///< [m/s^2]
  double yaw = kNotGiven;                               ///< [rad] from east, anticlockwise
  double yaw_rate = kNotGiven;                          ///< [rad/s]
};

/// What SET_ATTITUDE_TARGET asks for. PX4 takes the attitude where it is given and of the rates then only that of yaw.
struct AttitudeSetpoint {
  bool has_attitude = false;
  Quaternion attitude = Quaternion::Identity();  ///< from B to L
  Vector3 rate = Vector3::Zero();                ///< [rad/s] frame B
  double thrust = 0;                             ///< 0 to 1, of full thrust
};

/// PX4's defaults, under their names there.
struct ControlGains {
  double xy_p = 0.95;          ///< MPC_XY_P [1/s]
  double z_p = 1;              ///< MPC_Z_P [1/s]
  double xy_vel_p = 1.8;       ///< MPC_XY_VEL_P_ACC [1/s]
  double xy_vel_i = 0.4;       ///< MPC_XY_VEL_I_ACC [1/s^2]
  double xy_vel_d = 0.2;       ///< MPC_XY_VEL_D_ACC
  double z_vel_p = 4;          ///< MPC_Z_VEL_P_ACC [1/s]
  double z_vel_i = 2;          ///< MPC_Z_VEL_I_ACC [1/s^2]
  double xy_vel_max = 12;      ///< MPC_XY_VEL_MAX [m/s]
  double vel_max_up = 3;       ///< MPC_Z_VEL_MAX_UP [m/s]
  double vel_max_down = 1.5;   ///< MPC_Z_VEL_MAX_DN [m/s]
  double tilt_max = 0.785;     ///< MPC_TILTMAX_AIR [rad]
  double thrust_min = 0.12;    ///< MPC_THR_MIN
  double hover_thrust = 0.5;   ///< MPC_THR_HOVER
  double attitude_p = 6.5;     ///< MC_ROLL_P, MC_PITCH_P [1/s]
  double yaw_p = 2.8;          ///< MC_YAW_P [1/s]
  double yaw_weight = 0.4;     ///< MC_YAW_WEIGHT
  double yaw_rate_max = 3.49;  ///< MC_YAWRATE_MAX [rad/s]
};

/// The cascade of PX4: position and velocity, attitude, rate.
class FlightControl {
 public:
  FlightControl(const VehicleModel& model, const ControlGains& gains) : model_(model), gains_(gains) {}

  ControlGains& gains() { return gains_; }
  [[nodiscard]] const ControlGains& gains() const { return gains_; }
  [[nodiscard]] const VehicleModel& model() const { return model_; }
  /// Forgets integrals and filters, as at every take-off.
  void reset();

  /// The attitude and thrust that follow `target`. `climb_limit` [m/s] bounds the speed upwards (negative values hold
  /// the vehicle down: the take-off ramp).
  AttitudeSetpoint follow(const Estimate& estimate, const PositionSetpoint& target, double climb_limit, double dt);
  /// The rates that turn to the wanted attitude.
  Vector3 turn(const Estimate& estimate, const AttitudeSetpoint& target) const;
  MotorCommands drive(const Estimate& estimate, const Vector3& rate, double thrust, double dt);

  /// Vertical speed that `follow` last asked for [m/s].
  [[nodiscard]] double wanted_climb() const { return wanted_climb_; }

 private:
  [[nodiscard]] Vector3 wanted_velocity(const Estimate& estimate, const PositionSetpoint& target,
                                        double climb_limit) const;
  Vector3 wanted_acceleration(const Estimate& estimate, const Vector3& velocity, double dt);

  VehicleModel model_;
  ControlGains gains_;
  Vector3 velocity_integral_ = Vector3::Zero();  ///< [m/s^2]
  Vector3 last_velocity_ = Vector3::Constant(kNotGiven);
  Vector3 acceleration_ = Vector3::Zero();   ///< [m/s^2] estimated, filtered
  Vector3 rate_integral_ = Vector3::Zero();  ///< [rad/s^2]
  Vector3 last_rate_ = Vector3::Zero();
  Vector3 rate_slope_ = Vector3::Zero();  ///< [rad/s^2] filtered
  double wanted_climb_ = 0;
  double thrust_ = 0;  ///< that `follow` last asked for
};

}  // namespace swiftlet::tools
