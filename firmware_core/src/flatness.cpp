#include "swiftlet/flatness.hpp"

#include <cmath>

#include "swiftlet/trigonometry.hpp"

namespace swiftlet {
namespace {

// Sine of the angle between thrust and body y below which the heading comes from the hint: three degrees.
constexpr Real kLeastSine = Real(0.05);

bool is_usable(const Vector3& v) { return v.cwiseAbs().maxCoeff() <= kLargestInput && v.allFinite(); }
bool is_usable(Real x) { return std::fabs(x) <= kLargestInput; }

/// Body rates: the thrust axis follows the jerk, the heading the yaw rate. The heading psi of x_B obeys
/// psi' = k . x_B' with k = (-x_B.y, x_B.x, 0) / |x_B's horizontal part|^2 and x_B' = w_z y_B - w_y z_B.
Vector3 body_rates(const Matrix3& R_WB, Real thrust, const FlatOutputs& flat, Singularity& singularity) {
  const Vector3 x_B = R_WB.col(0);
  const Vector3 y_B = R_WB.col(1);
  const Vector3 z_B = R_WB.col(2);
  Vector3 omega{-flat.jerk.dot(y_B) / thrust, flat.jerk.dot(x_B) / thrust, 0};
  const Vector3 k{-x_B.y(), x_B.x(), 0};  // times the square below
  const Real horizontal2 = x_B.x() * x_B.x() + x_B.y() * x_B.y();
  const Real grip = k.dot(y_B);  // = z_B.z
  if (std::fabs(grip) < kLeastSine) {
    if (singularity == Singularity::kNone) singularity = Singularity::kThrustHorizontal;
    return omega;
  }
  omega.z() = (flat.yaw_rate * horizontal2 + omega.y() * k.dot(z_B)) / grip;
  return omega;
}

}  // namespace

Matrix3 attitude_from(const Vector3& z_B, Real yaw, const Matrix3& hint, Singularity& singularity) {
  const Vector3 y_C{-sine(yaw), cosine(yaw), 0};
  Vector3 x_B = y_C.cross(z_B);
  Real length = x_B.norm();
  if (length < kLeastSine) {
    singularity = Singularity::kYawAlongThrust;
    x_B = hint.col(1).cross(z_B);
    length = x_B.norm();
    if (!(length >= kLeastSine)) {  // the hint's y axis is along the thrust as well, or no hint at all
      x_B = Vector3{cosine(yaw), sine(yaw), 0};
      x_B -= x_B.dot(z_B) * z_B;
      length = x_B.norm();
    }
  } else if (z_B.z() < 0) {
    x_B = -x_B;  // inverted, the nose still points along the heading
  }
  Matrix3 R_WB;
  R_WB.col(0) = x_B / length;
  R_WB.col(1) = z_B.cross(R_WB.col(0));
  R_WB.col(2) = z_B;
  return R_WB;
}

Result<FlatState> flat_to_state(const FlatOutputs& flat, const Matrix3& hint) {
  if (!is_usable(flat.acceleration) || !is_usable(flat.jerk) || !is_usable(flat.yaw) || !is_usable(flat.yaw_rate)) {
    return Status::kBadRequest;
  }
  if (!hint.allFinite()) return Status::kBadRequest;
  const Vector3 force = flat.acceleration + Vector3{0, 0, kGravity};
  FlatState state;
  state.thrust = force.norm();
  if (state.thrust < kLeastThrust) {
    state.singularity = Singularity::kFreeFall;
    state.attitude = to_quaternion(hint).toRotationMatrix();
    return state;
  }
  state.attitude = attitude_from(force / state.thrust, flat.yaw, hint, state.singularity);
  state.body_rates = body_rates(state.attitude, state.thrust, flat, state.singularity);
  return state;
}

Real heading_of(const Matrix3& R_WB) { return angle_of(R_WB(1, 0), R_WB(0, 0)); }

Quaternion to_quaternion(const Matrix3& R_WB) {
  Quaternion q(R_WB);
  const Real norm = std::sqrt(q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z());
  if (!(norm > Real(1e-6) && norm < kLargestInput)) return Quaternion::Identity();
  const Real scale = (q.w() < 0 ? Real(-1) : Real(1)) / norm;
  return {q.w() * scale, q.x() * scale, q.y() * scale, q.z() * scale};
}

Real wrap_angle(Real angle) {
  const Real turns = std::ceil(angle / (2 * kPi) - Real(0.5));
  return angle - 2 * kPi * turns;
}

}  // namespace swiftlet
