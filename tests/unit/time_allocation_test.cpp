#include "swiftlet/time_allocation.hpp"

#include <array>
#include <limits>
#include <span>

#include "swiftlet_test.hpp"

namespace {

using swiftlet::allocate_durations;
using swiftlet::Real;
using swiftlet::SpeedLimits;
using swiftlet::Status;
using swiftlet::Vector3;

constexpr double kTolerance = sizeof(Real) == 8 ? 1e-12 : 1e-5;
constexpr SpeedLimits kLimits{.v_max = 2, .a_max = 1};  // the two ramps take 4 m and 4 s

double leg_duration(Real length) {
  const std::array<Vector3, 2> points{Vector3::Zero(), Vector3{length, 0, 0}};
  std::array<Real, 1> duration{};
  EXPECT_EQ(allocate_durations(points, kLimits, duration), Status::kOk);
  return duration[0];
}

TEST(TimeAllocation, GivesTheWorkedValuesOnBothSidesOfThe4mSwitch) {
  EXPECT_NEAR(leg_duration(1), 2, kTolerance);
  EXPECT_NEAR(leg_duration(4), 4, kTolerance);
  EXPECT_NEAR(leg_duration(8), 6, kTolerance);
}

TEST(TimeAllocation, OneProfileRunsOverAllLegs) {
  // 8 m: 2 m up in 2 s, 4 m at 2 m/s, 2 m down in 2 s; corners do not slow it down.
  const std::array<Vector3, 5> points{Vector3{0, 0, 0}, Vector3{Real(0.5), 0, 0}, Vector3{2, 0, 0}, Vector3{2, 4, 0},
                                      Vector3{2, 4, 2}};
  std::array<Real, 4> durations{};
  ASSERT_EQ(allocate_durations(points, kLimits, durations), Status::kOk);
  EXPECT_NEAR(durations[0], 1, kTolerance);
  EXPECT_NEAR(durations[1], 1, kTolerance);
  EXPECT_NEAR(durations[2], 2, kTolerance);
  EXPECT_NEAR(durations[3], 2, kTolerance);
}

TEST(TimeAllocation, ALegMayHoldAllThreePhasesAndItsNeighboursOnlyRamps) {
  const std::array<Vector3, 4> points{Vector3{0, 0, 0}, Vector3{0, Real(0.5), 0}, Vector3{0, Real(7.5), 0},
                                      Vector3{0, 8, 0}};
  std::array<Real, 3> durations{};
  ASSERT_EQ(allocate_durations(points, kLimits, durations), Status::kOk);
  EXPECT_NEAR(durations[0], 1, kTolerance);
  EXPECT_NEAR(durations[1], 4, kTolerance);
  EXPECT_NEAR(durations[2], 1, kTolerance);
}

TEST(TimeAllocation, TheSumDoesNotDependOnHowThePathIsCut) {
  std::array<Vector3, 101> points{};
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = {0, 0, Real(0.08) * static_cast<Real>(i)};
  std::array<Real, 100> durations{};
  ASSERT_EQ(allocate_durations(points, kLimits, durations), Status::kOk);
  double sum = 0;
  for (const Real duration : durations) sum += static_cast<double>(duration);
  EXPECT_NEAR(sum, 6, 10 * kTolerance);
}

TEST(TimeAllocation, ALegOfNoLengthStillGetsAThousandthOfTheMean) {
  const std::array<Vector3, 4> points{Vector3{0, 0, 0}, Vector3{0, 0, 0}, Vector3{4, 0, 0}, Vector3{4, 0, 0}};
  std::array<Real, 3> durations{};
  ASSERT_EQ(allocate_durations(points, kLimits, durations), Status::kOk);
  EXPECT_NEAR(durations[0], 4.0 / 3 * 1e-3, kTolerance);
  EXPECT_NEAR(durations[1], 4, kTolerance);
  EXPECT_NEAR(durations[2], 4.0 / 3 * 1e-3, kTolerance);
}

TEST(TimeAllocation, StayingInPlaceTakesAMillisecond) {
  const std::array<Vector3, 3> points{Vector3{1, 1, 1}, Vector3{1, 1, 1}, Vector3{1, 1, 1}};
  std::array<Real, 2> durations{};
  ASSERT_EQ(allocate_durations(points, kLimits, durations), Status::kOk);
  EXPECT_NEAR(durations[0], 0.5e-3, kTolerance);
  EXPECT_NEAR(durations[1], 0.5e-3, kTolerance);
}

TEST(TimeAllocation, RefusesBadInputBeforeTheFirstWrite) {
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  const Real infinity = std::numeric_limits<Real>::infinity();
  const std::array<Vector3, 2> points{Vector3::Zero(), Vector3{1, 0, 0}};
  const std::array<Vector3, 2> endless{Vector3::Zero(), Vector3{infinity, 0, 0}};
  const std::array<Vector3, 2> unknown{Vector3::Zero(), Vector3{nan, 0, 0}};
  std::array<Real, 1> durations{Real(-7)};
  EXPECT_EQ(allocate_durations(std::span(points).first(1), kLimits, durations), Status::kBadRequest);
  EXPECT_EQ(allocate_durations({}, kLimits, durations), Status::kBadRequest);
  for (const Real bad : {Real(0), Real(-1), nan, infinity}) {
    EXPECT_EQ(allocate_durations(points, {.v_max = bad, .a_max = 1}, durations), Status::kBadRequest);
    EXPECT_EQ(allocate_durations(points, {.v_max = 1, .a_max = bad}, durations), Status::kBadRequest);
  }
  EXPECT_EQ(allocate_durations(endless, kLimits, durations), Status::kBadRequest);
  EXPECT_EQ(allocate_durations(unknown, kLimits, durations), Status::kBadRequest);
  EXPECT_EQ(allocate_durations(points, kLimits, {}), Status::kBufferTooSmall);
  EXPECT_EQ(durations[0], Real(-7));
}

TEST(TimeAllocation, LeavesElementsPastTheLastLegAlone) {
  const std::array<Vector3, 2> points{Vector3::Zero(), Vector3{4, 0, 0}};
  std::array<Real, 2> durations{0, Real(-7)};
  ASSERT_EQ(allocate_durations(points, kLimits, durations), Status::kOk);
  EXPECT_NEAR(durations[0], 4, kTolerance);
  EXPECT_EQ(durations[1], Real(-7));
}

}  // namespace
