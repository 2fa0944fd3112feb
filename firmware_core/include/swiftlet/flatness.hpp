#pragma once
#include <Eigen/Geometry>
#include <cstdint>

#include "swiftlet/status.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

using Matrix3 = Eigen::Matrix<Real, 3, 3>;
using Quaternion = Eigen::Quaternion<Real>;  ///< unit; constructor order w, x, y, z

/// What a quadrotor's motion is given by, with derivatives, in frame W: [m/s^2] [m/s^3] [rad] [rad/s]. (Position and
/// velocity do not enter attitude, thrust or rates without a model of drag.)
struct FlatOutputs {
  Vector3 acceleration = Vector3::Zero();
  Vector3 jerk = Vector3::Zero();
  Real yaw = 0;       ///< heading of the body's x axis, anticlockwise from east
  Real yaw_rate = 0;  ///< its derivative
};

/// Where attitude or rates are not determined by the flat outputs, and what was done about it.
enum class Singularity : std::uint8_t {
  kNone,
  kFreeFall,         ///< thrust below kLeastThrust has no direction: attitude is the hint's, rates are zero
  kYawAlongThrust,   ///< thrust along the body's y axis at that yaw: the heading comes from the hint
  kThrustHorizontal  ///< no rate about the thrust axis turns the heading: the rate about body z is zero
};

/// Attitude, collective thrust and body rates that fly the flat outputs.
struct FlatState {
  Matrix3 attitude = Matrix3::Identity();  ///< R_WB of the body (forward-left-up)
  Real thrust = kGravity;                  ///< [m/s^2] specific collective thrust, along body z; >= 0
  Vector3 body_rates = Vector3::Zero();    ///< [rad/s] omega_WB_B, in the body frame
  Singularity singularity = Singularity::kNone;
};

inline constexpr Real kLeastThrust = Real(0.5);   ///< [m/s^2]
inline constexpr Real kLargestInput = Real(1e6);  ///< magnitudes beyond this are no flight: kBadRequest

/// Differential flatness (paper Sec. IV-A, eq. 3; Mellinger and Kumar 2011). Thrust a + g z_W gives the body's z axis
/// and its magnitude; the body's x axis lies in the vertical plane of the heading, as in PX4, also when inverted.
///   hint   attitude kept where the flat outputs leave it open; the previous one, as a rule
/// Errors: kBadRequest for numbers that are not finite or beyond kLargestInput. What returns is always finite and a
/// rotation.
Result<FlatState> flat_to_state(const FlatOutputs& flat, const Matrix3& hint = Matrix3::Identity());

/// The attitude with thrust along the unit vector `z_B` and heading `yaw`; `hint` as above, `singularity` may become
/// kYawAlongThrust.
Matrix3 attitude_from(const Vector3& z_B, Real yaw, const Matrix3& hint, Singularity& singularity);

/// Heading of the body's x axis [rad] in (-pi, pi]; 0 when it is vertical.
Real heading_of(const Matrix3& R_WB);

/// The nearest unit quaternion with w >= 0, or the identity when there is none (zero or not finite).
Quaternion to_quaternion(const Matrix3& R_WB);

/// `angle` brought to (-pi, pi]; |angle| must be below kLargestInput.
Real wrap_angle(Real angle);

inline constexpr Real kPi = Real(3.14159265358979323846);

}  // namespace swiftlet
