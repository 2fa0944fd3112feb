#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "swiftlet/types.hpp"

/// The frames of MAVLink, and the only place where they meet ours. Ours: W and L are ENU (x east, y north, z up), B is
/// forward-left-up. Theirs: NED (x north, y east, z down) and forward-right-down. Each conversion is its own inverse.
namespace swiftlet::mavlink {

using Quaternion = Eigen::Quaternion<Real>;

/// A vector in a local north-east-down frame.
struct NedVector {
  Vector3 value = Vector3::Zero();
};
/// A vector in the body's forward-right-down frame.
struct FrdVector {
  Vector3 value = Vector3::Zero();
};
/// Attitude of the forward-right-down body in the north-east-down frame.
struct NedQuaternion {
  Quaternion value = Quaternion::Identity();
};

inline NedVector to_ned(const Vector3& v) { return {{v.y(), v.x(), -v.z()}}; }
inline Vector3 to_enu(const NedVector& v) { return {v.value.y(), v.value.x(), -v.value.z()}; }
inline FrdVector to_frd(const Vector3& v_B) { return {{v_B.x(), -v_B.y(), -v_B.z()}}; }
inline Vector3 to_flu(const FrdVector& v) { return {v.value.x(), -v.value.y(), -v.value.z()}; }

/// `q` is the attitude of B (FLU) in ENU: (0, s, s, 0) q (0, 1, 0, 0) with s = sqrt(1/2), sign turned.
NedQuaternion to_ned(const Quaternion& q);
Quaternion to_enu(const NedQuaternion& q);

/// Yaw from east, counter-clockwise, to yaw from north, clockwise, and back [rad]; in (-pi, pi].
Real ned_yaw(Real yaw_enu);
Real enu_yaw(Real yaw_ned);

/// Into (-pi, pi] [rad]; any finite angle.
Real wrap_angle(Real angle);

/// Heading of the body's x axis [rad]: from the first axis of the frame, counter-clockwise about its third.
Real yaw_of(const Quaternion& q);

/// Where the autopilot's local frame L (ENU) lies in the map's frame W: the same vertical, turned by a yaw and shifted.
/// L's origin is where the estimator started, and drifts until arming, so the two are tied together at arming.
class Alignment {
 public:
  /// W is L.
  Alignment() = default;
  /// The alignment that puts a vehicle, which the autopilot sees at `p_L` with `yaw_L`, at `p_W` with `yaw_W` [m]
  /// [rad].
  Alignment(const Vector3& p_L, Real yaw_L, const Vector3& p_W, Real yaw_W);

  [[nodiscard]] const Vector3& offset() const { return origin_; }  ///< L's origin in W [m].
  [[nodiscard]] Real yaw() const { return yaw_; }                  ///< [rad]

  [[nodiscard]] Vector3 point_to_map(const Vector3& p_L) const { return origin_ + vector_to_map(p_L); }
  [[nodiscard]] Vector3 point_to_local(const Vector3& p_W) const { return vector_to_local(p_W - origin_); }
  [[nodiscard]] Vector3 vector_to_map(const Vector3& v_L) const;
  [[nodiscard]] Vector3 vector_to_local(const Vector3& v_W) const;
  [[nodiscard]] Quaternion attitude_to_map(const Quaternion& q_LB) const { return rotation_ * q_LB; }
  [[nodiscard]] Quaternion attitude_to_local(const Quaternion& q_WB) const { return rotation_.conjugate() * q_WB; }
  [[nodiscard]] Real yaw_to_map(Real yaw_L) const { return wrap_angle(yaw_L + yaw_); }
  [[nodiscard]] Real yaw_to_local(Real yaw_W) const { return wrap_angle(yaw_W - yaw_); }

 private:
  Vector3 origin_ = Vector3::Zero();
  Real yaw_ = 0;
  Quaternion rotation_ = Quaternion::Identity();
  Real cos_yaw_ = 1;
  Real sin_yaw_ = 0;
};

}  // namespace swiftlet::mavlink
