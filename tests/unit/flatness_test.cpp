#include "swiftlet/flatness.hpp"

#include <cmath>
#include <limits>

#include "harness/random_corridor.hpp"
#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr bool kIsDouble = sizeof(Real) == 8;
constexpr Real kTolerance = kIsDouble ? Real(1e-9) : Real(1e-5);
using test::Random;

Vector3 random_vector(Random& random, Real size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

FlatOutputs random_flat(Random& random, Real acceleration) {
  return {random_vector(random, acceleration), random_vector(random, 5), random.uniform(-kPi, kPi),
          random.uniform(-2, 2)};
}

Real rotation_error(const Matrix3& R_WB) {
  const Real orthogonal = (R_WB * R_WB.transpose() - Matrix3::Identity()).cwiseAbs().maxCoeff();
  const Real right_handed = (R_WB.col(0).cross(R_WB.col(1)) - R_WB.col(2)).norm();
  return orthogonal + right_handed;
}

TEST(Flatness, HoverIsLevelAtItsHeadingAndCarriesTheWeight) {
  const Result<FlatState> state = flat_to_state({Vector3::Zero(), Vector3::Zero(), Real(0.7), Real(0.3)});
  ASSERT_TRUE(state.ok());
  EXPECT_NEAR(state->thrust, 9.80665, kTolerance);
  EXPECT_NEAR(heading_of(state->attitude), 0.7, kTolerance);
  EXPECT_NEAR(state->attitude(2, 2), 1, kTolerance);
  EXPECT_NEAR(state->body_rates.z(), 0.3, kTolerance);
}

// Accelerating east with g, nose east: pitched nose down by 45 degrees, x_B = (1, 0, -1) / sqrt 2.
TEST(Flatness, AcceleratingForwardPitchesTheNoseDown) {
  const Result<FlatState> state = flat_to_state({{kGravity, 0, 0}, Vector3::Zero(), 0, 0});
  ASSERT_TRUE(state.ok());
  EXPECT_NEAR(state->thrust, 9.80665 * std::sqrt(2.0), 10 * kTolerance);
  EXPECT_NEAR(state->attitude(0, 0), std::sqrt(0.5), kTolerance);
  EXPECT_NEAR(state->attitude(2, 0), -std::sqrt(0.5), kTolerance);
  EXPECT_NEAR(state->attitude(1, 1), 1, kTolerance);
}

// At hover, jerk east of g per second turns the thrust axis east at 1 rad/s: about body y.
TEST(Flatness, JerkTurnsTheThrustAxis) {
  const Result<FlatState> state = flat_to_state({Vector3::Zero(), {kGravity, 0, 0}, 0, 0});
  ASSERT_TRUE(state.ok());
  EXPECT_NEAR(state->body_rates.y(), 1, kTolerance);
  EXPECT_NEAR(state->body_rates.x(), 0, kTolerance);
}

TEST(Flatness, ThrustAlongBodyZIsTheForceAndTheHeadingIsTheYaw) {
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const FlatOutputs flat = random_flat(random, 25);
    const Result<FlatState> state = flat_to_state(flat);
    ASSERT_TRUE(state.ok());
    EXPECT_LE(rotation_error(state->attitude), 10 * kTolerance);
    if (state->singularity == Singularity::kFreeFall) continue;
    const Vector3 force = state->thrust * state->attitude.col(2);
    EXPECT_LE((force - flat.acceleration - Vector3{0, 0, kGravity}).norm(), 100 * kTolerance);
    if (state->singularity == Singularity::kYawAlongThrust) continue;
    EXPECT_NEAR(wrap_angle(heading_of(state->attitude) - flat.yaw), 0, 100 * kTolerance);
  }
}

// Body rates against the difference of two attitudes a short time apart, upright and inverted.
TEST(Flatness, BodyRatesAreTheDerivativeOfTheAttitude) {
  Random random(2);
  const Real h = kIsDouble ? Real(1e-6) : Real(2e-3);
  int checked = 0;
  for (int i = 0; i < 300; ++i) {
    const FlatOutputs flat = random_flat(random, 20);
    FlatOutputs later = flat;
    later.acceleration += h * flat.jerk;
    later.yaw += h * flat.yaw_rate;
    const Result<FlatState> now = flat_to_state(flat);
    const Result<FlatState> next = flat_to_state(later);
    ASSERT_TRUE(now.ok() && next.ok());
    const bool regular = now->singularity == Singularity::kNone && next->singularity == Singularity::kNone;
    if (!regular || now->thrust < 4 || std::fabs(now->attitude(2, 2)) < Real(0.3)) continue;
    const Matrix3 turn = now->attitude.transpose() * next->attitude;
    const Vector3 omega = Vector3{turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0), turn(1, 0) - turn(0, 1)} / (2 * h);
    EXPECT_LE((omega - now->body_rates).norm(), (kIsDouble ? Real(1e-3) : Real(0.1)) * (1 + omega.norm()));
    ++checked;
  }
  EXPECT_GT(checked, 100);
}

TEST(Flatness, InFreeFallTheAttitudeIsTheHints) {
  Singularity none{};
  const Matrix3 hint = attitude_from(Vector3{Real(0.6), 0, Real(0.8)}, 1, Matrix3::Identity(), none);
  const Result<FlatState> state = flat_to_state({{0, 0, -kGravity}, {1, 2, 3}, 0, 1}, hint);
  ASSERT_TRUE(state.ok());
  EXPECT_TRUE(state->singularity == Singularity::kFreeFall);
  EXPECT_LE((state->attitude - hint).norm(), 10 * kTolerance);
  EXPECT_EQ(state->body_rates.norm(), 0);
  EXPECT_NEAR(state->thrust, 0, kTolerance);
}

TEST(Flatness, InvertedTheNoseStillPointsAlongTheHeading) {
  const Result<FlatState> state = flat_to_state({{1, 2, -20}, Vector3::Zero(), Real(2.5), 0});
  ASSERT_TRUE(state.ok());
  EXPECT_LT(state->attitude(2, 2), 0);
  EXPECT_NEAR(heading_of(state->attitude), 2.5, 10 * kTolerance);
  EXPECT_LE(rotation_error(state->attitude), 10 * kTolerance);
}

TEST(Flatness, ThrustAlongTheSidewaysAxisTakesTheHeadingOfTheHint) {
  Singularity none{};
  for (const Real yaw : {Real(0), Real(0.5)}) {
    const Matrix3 hint = attitude_from(Vector3::UnitZ(), yaw, Matrix3::Identity(), none);
    const Result<FlatState> state = flat_to_state({{0, 10, -kGravity}, {1, 1, 1}, 0, 1}, hint);
    ASSERT_TRUE(state.ok());
    EXPECT_TRUE(state->singularity == Singularity::kYawAlongThrust);
    EXPECT_LE(rotation_error(state->attitude), 10 * kTolerance);
    EXPECT_TRUE(state->body_rates.allFinite());
  }
}

TEST(Flatness, HorizontalThrustForwardHasNoRateAboutIt) {
  const Result<FlatState> state = flat_to_state({{10, 0, -kGravity}, {0, 1, 0}, 0, 1});
  ASSERT_TRUE(state.ok());
  EXPECT_TRUE(state->singularity == Singularity::kThrustHorizontal);
  EXPECT_EQ(state->body_rates.z(), 0);
}

TEST(Flatness, RefusesNumbersThatAreNone) {
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  const Real infinity = std::numeric_limits<Real>::infinity();
  for (const Real bad : {nan, infinity, -infinity, std::numeric_limits<Real>::max()}) {
    for (int field = 0; field < 8; ++field) {
      FlatOutputs flat;
      if (field < 3) flat.acceleration[field] = bad;
      if (field >= 3 && field < 6) flat.jerk[field - 3] = bad;
      if (field == 6) flat.yaw = bad;
      if (field == 7) flat.yaw_rate = bad;
      EXPECT_TRUE(flat_to_state(flat).status() == Status::kBadRequest);
    }
  }
  EXPECT_TRUE(flat_to_state({}, Matrix3::Constant(nan)).status() == Status::kBadRequest);
}

// Whatever is finite goes in, a rotation comes out: near every singularity, with any hint.
TEST(Flatness, NothingButRotationsLeaves) {
  Random random(3);
  for (int i = 0; i < 2000; ++i) {
    FlatOutputs flat = random_flat(random, 15);
    const Real small = random.uniform(0, 1) < Real(0.5) ? Real(1e-3) : Real(0.6);
    switch (i % 4) {
      case 0:
        flat.acceleration = Vector3{0, 0, -kGravity} + random_vector(random, small);
        break;
      case 1:
        flat.acceleration = Vector3{-std::sin(flat.yaw), std::cos(flat.yaw), 0} * 10 - Vector3{0, 0, kGravity} +
                            random_vector(random, small);
        break;
      case 2:
        flat.acceleration.z() = -kGravity + random.uniform(-small, small);
        break;
      default:
        flat.jerk *= Real(1e4);
    }
    Matrix3 hint;
    for (Eigen::Index column = 0; column < 3; ++column) hint.col(column) = random_vector(random, i % 3 == 0 ? 0 : 1);
    const Result<FlatState> state = flat_to_state(flat, hint);
    ASSERT_TRUE(state.ok());
    EXPECT_LE(rotation_error(state->attitude), 100 * kTolerance);
    EXPECT_TRUE(state->body_rates.allFinite());
    EXPECT_GE(state->thrust, 0);
  }
}

TEST(Flatness, QuaternionsAreUnitWithPositiveRealPart) {
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    const FlatOutputs flat = random_flat(random, 25);
    const Result<FlatState> state = flat_to_state(flat);
    ASSERT_TRUE(state.ok());
    const Quaternion q = to_quaternion(state->attitude);
    EXPECT_NEAR(q.norm(), 1, 10 * kTolerance);
    EXPECT_GE(q.w(), 0);
    EXPECT_LE((q.toRotationMatrix() - state->attitude).norm(), 100 * kTolerance);
  }
  EXPECT_EQ(to_quaternion(Matrix3::Constant(std::numeric_limits<Real>::quiet_NaN())).w(), 1);
}

TEST(Flatness, WrapsAngles) {
  EXPECT_NEAR(wrap_angle(3 * kPi / 2), -kPi / 2, kTolerance);
  EXPECT_NEAR(wrap_angle(-3 * kPi / 2), kPi / 2, kTolerance);
  EXPECT_NEAR(wrap_angle(Real(0.3) + 20 * kPi), 0.3, 100 * kTolerance);
}

}  // namespace
}  // namespace swiftlet
