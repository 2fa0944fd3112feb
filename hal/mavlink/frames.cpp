#include "swiftlet/mavlink/frames.hpp"

#include <cmath>
#include <numbers>

#include "swiftlet/trigonometry.hpp"

namespace swiftlet::mavlink {
namespace {

constexpr Real kPi = std::numbers::pi_v<Real>;

/// The change of both frames at once; the sign is free and chosen so that applying it twice gives `q` itself.
Quaternion swap_frames(const Quaternion& q) {
  constexpr Real kHalfRoot = std::numbers::sqrt2_v<Real> / 2;
  return Quaternion((q.w() + q.z()) * kHalfRoot, (q.x() + q.y()) * kHalfRoot, (q.x() - q.y()) * kHalfRoot,
                    (q.w() - q.z()) * kHalfRoot);
}

}  // namespace

NedQuaternion to_ned(const Quaternion& q) { return {swap_frames(q)}; }
Quaternion to_enu(const NedQuaternion& q) { return swap_frames(q.value); }

Real ned_yaw(Real yaw_enu) { return wrap_angle(kPi / 2 - yaw_enu); }
Real enu_yaw(Real yaw_ned) { return wrap_angle(kPi / 2 - yaw_ned); }

Real wrap_angle(Real angle) {
  const Real wrapped = angle - 2 * kPi * std::floor(angle / (2 * kPi) + Real(0.5));
  return wrapped <= -kPi ? kPi : wrapped;  // the half-open end, and one rounding past it
}

Real yaw_of(const Quaternion& q) {
  return angle_of(2 * (q.w() * q.z() + q.x() * q.y()), 1 - 2 * (q.y() * q.y() + q.z() * q.z()));
}

Alignment::Alignment(const Vector3& p_L, Real yaw_L, const Vector3& p_W, Real yaw_W)
    : yaw_(wrap_angle(yaw_W - yaw_L)),
      rotation_(cosine(yaw_ / 2), 0, 0, sine(yaw_ / 2)),
      cos_yaw_(cosine(yaw_)),
      sin_yaw_(sine(yaw_)) {
  origin_ = p_W - vector_to_map(p_L);
}

Vector3 Alignment::vector_to_map(const Vector3& v_L) const {
  return {cos_yaw_ * v_L.x() - sin_yaw_ * v_L.y(), sin_yaw_ * v_L.x() + cos_yaw_ * v_L.y(), v_L.z()};
}

Vector3 Alignment::vector_to_local(const Vector3& v_W) const {
  return {cos_yaw_ * v_W.x() + sin_yaw_ * v_W.y(), cos_yaw_ * v_W.y() - sin_yaw_ * v_W.x(), v_W.z()};
}

}  // namespace swiftlet::mavlink
