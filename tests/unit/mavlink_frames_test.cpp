#include <cmath>
#include <numbers>

#include "swiftlet/mavlink/frames.hpp"
#include "swiftlet_test.hpp"

namespace {

using swiftlet::Real;
using swiftlet::Vector3;
using swiftlet::mavlink::Alignment;
using swiftlet::mavlink::NedQuaternion;
using swiftlet::mavlink::Quaternion;

constexpr double kTolerance = 1e-6;
constexpr Real kPi = std::numbers::pi_v<Real>;

void expect_equal(const Vector3& a, const Vector3& b) {
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(a[axis], b[axis], kTolerance);
}

/// The same rotation: quaternions of either sign.
void expect_same_rotation(const Quaternion& a, const Quaternion& b) { EXPECT_NEAR(std::abs(a.dot(b)), 1, kTolerance); }

Quaternion about(int axis, double angle) {
  Vector3 xyz = Vector3::Zero();
  xyz[axis] = static_cast<Real>(std::sin(angle / 2));
  return Quaternion(static_cast<Real>(std::cos(angle / 2)), xyz.x(), xyz.y(), xyz.z());
}

TEST(MavlinkFrames, TurnVectorsByHand) {
  // 1 m east, 2 m north, 3 m up.
  expect_equal(swiftlet::mavlink::to_ned(Vector3(1, 2, 3)).value, Vector3(2, 1, -3));
  expect_equal(swiftlet::mavlink::to_enu(swiftlet::mavlink::NedVector{{2, 1, -3}}), Vector3(1, 2, 3));
  // 1 forward, 2 left, 3 up.
  expect_equal(swiftlet::mavlink::to_frd(Vector3(1, 2, 3)).value, Vector3(1, -2, -3));
  expect_equal(swiftlet::mavlink::to_flu(swiftlet::mavlink::FrdVector{{1, -2, -3}}), Vector3(1, 2, 3));
}

TEST(MavlinkFrames, TurnAttitudesByHand) {
  // Level and facing east: ENU identity; seen from north that is 90 degrees of yaw.
  expect_same_rotation(swiftlet::mavlink::to_ned(Quaternion::Identity()).value, about(2, kPi / 2));
  // Level and facing north: NED identity; counted from east 90 degrees.
  expect_same_rotation(swiftlet::mavlink::to_enu(NedQuaternion{}), about(2, kPi / 2));
  // Facing north, nose 0.3 rad up: positive pitch about the right axis (east), which is y of NED.
  expect_same_rotation(swiftlet::mavlink::to_enu(NedQuaternion{about(1, 0.3)}), about(0, 0.3) * about(2, kPi / 2));
  // Facing north, right side 0.3 rad down: about the forward axis (north), which is x of NED and y of ENU.
  expect_same_rotation(swiftlet::mavlink::to_enu(NedQuaternion{about(0, 0.3)}), about(1, 0.3) * about(2, kPi / 2));
}

TEST(MavlinkFrames, AnAttitudeTurnsBodyVectorsTheSameWayInBothWorlds) {
  const Quaternion q = (about(0, 0.4) * about(1, -1.1) * about(2, 2.5)).normalized();
  const Vector3 v_B(0.3, -0.7, 1.9);
  const Vector3 v_enu = q * v_B;
  const Vector3 v_ned = swiftlet::mavlink::to_ned(q).value * swiftlet::mavlink::to_frd(v_B).value;
  expect_equal(v_ned, swiftlet::mavlink::to_ned(v_enu).value);
  expect_same_rotation(swiftlet::mavlink::to_enu(swiftlet::mavlink::to_ned(q)), q);
}

TEST(MavlinkFrames, TurnYawsByHand) {
  EXPECT_NEAR(swiftlet::mavlink::ned_yaw(0), kPi / 2, kTolerance);               // east
  EXPECT_NEAR(swiftlet::mavlink::ned_yaw(kPi / 2), 0, kTolerance);               // north
  EXPECT_NEAR(swiftlet::mavlink::ned_yaw(kPi), -kPi / 2, kTolerance);            // west
  EXPECT_NEAR(std::abs(swiftlet::mavlink::ned_yaw(-kPi / 2)), kPi, kTolerance);  // south
  EXPECT_NEAR(swiftlet::mavlink::enu_yaw(swiftlet::mavlink::ned_yaw(1)), 1, kTolerance);
  EXPECT_NEAR(swiftlet::mavlink::yaw_of(about(2, -2.0)), -2.0, kTolerance);
  EXPECT_NEAR(swiftlet::mavlink::wrap_angle(-kPi), kPi, kTolerance);
  EXPECT_NEAR(swiftlet::mavlink::wrap_angle(7), 7 - 2 * kPi, kTolerance);
}

TEST(MavlinkAlignment, PutsTheVehicleWhereItIsInTheMap) {
  // The autopilot has drifted to (1, -0.5, 0.8) facing its east; on the map the vehicle stands at (10, 20, 0.1) facing
  // the map's y. So L is turned by 90 degrees: L's x is the map's y.
  const Alignment alignment(Vector3(1, Real(-0.5), Real(0.8)), 0, Vector3(10, 20, Real(0.1)), kPi / 2);
  expect_equal(alignment.point_to_map(Vector3(1, Real(-0.5), Real(0.8))), Vector3(10, 20, Real(0.1)));
  expect_equal(alignment.point_to_map(Vector3(2, Real(-0.5), Real(0.8))), Vector3(10, 21, Real(0.1)));
  expect_equal(alignment.vector_to_map(Vector3(0, 1, 2)), Vector3(-1, 0, 2));
  expect_equal(alignment.point_to_local(Vector3(10, 21, Real(0.1))), Vector3(2, Real(-0.5), Real(0.8)));
  expect_equal(alignment.vector_to_local(Vector3(-1, 0, 2)), Vector3(0, 1, 2));
  EXPECT_NEAR(alignment.yaw_to_map(Real(0.25)), kPi / 2 + 0.25, kTolerance);
  EXPECT_NEAR(alignment.yaw_to_local(0), -kPi / 2, kTolerance);
  expect_same_rotation(alignment.attitude_to_map(about(0, 0.2)), about(2, kPi / 2) * about(0, 0.2));
  expect_same_rotation(alignment.attitude_to_local(alignment.attitude_to_map(about(1, 0.2))), about(1, 0.2));
}

TEST(MavlinkAlignment, IsTheIdentityBeforeItIsMade) {
  const Alignment alignment;
  expect_equal(alignment.point_to_map(Vector3(1, 2, 3)), Vector3(1, 2, 3));
  expect_equal(alignment.vector_to_local(Vector3(1, 2, 3)), Vector3(1, 2, 3));
  EXPECT_EQ(alignment.yaw(), 0);
}

}  // namespace
