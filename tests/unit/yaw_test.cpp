#include "swiftlet/yaw.hpp"

#include <cmath>
#include <limits>

#include "harness/random_corridor.hpp"
#include "swiftlet/flatness.hpp"
#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr Real kTolerance = sizeof(Real) == 8 ? Real(1e-9) : Real(1e-5);
constexpr Real kStep = Real(0.02);  // [s]

TEST(Yaw, WantedYawOfEachMode) {
  const Vector3 here{1, 1, 0};
  YawSettings settings;
  settings.mode = YawMode::kFixed;
  settings.angle = Real(0.5) + 2 * kPi;
  EXPECT_NEAR(wanted_yaw(settings, here, {9, 9, 9}, 3), 0.5, 1e-5);
  settings.mode = YawMode::kAlongPath;
  EXPECT_NEAR(wanted_yaw(settings, here, {1, 2, 5}, 3), 3.14159265 / 2, 1e-6);
  settings.mode = YawMode::kTowards;
  settings.target = {0, 0, 4};
  EXPECT_NEAR(wanted_yaw(settings, here, {1, 2, 5}, 3), -3 * 3.14159265 / 4, 1e-6);
}

TEST(Yaw, WithoutADirectionItStays) {
  YawSettings settings;
  EXPECT_EQ(wanted_yaw(settings, {1, 1, 0}, {Real(1.01), 1, 7}, Real(0.4)), Real(0.4));
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  EXPECT_EQ(wanted_yaw(settings, {1, 1, 0}, {nan, 1, 7}, Real(0.4)), Real(0.4));
}

TEST(Yaw, TurnsTheShorterWay) {
  const YawSettings settings;
  EXPECT_GT(step_yaw(settings, {3, 0}, -3, kStep).rate, 0);
  EXPECT_LT(step_yaw(settings, {-3, 0}, 3, kStep).rate, 0);
}

TEST(Yaw, ReachesAFixedGoalWithoutOvershoot) {
  YawSettings settings;
  for (const Real goal : {Real(0.01), Real(0.5), Real(3)}) {
    YawState state;
    int steps = 0;
    for (; steps < 1000 && std::fabs(state.yaw - goal) + std::fabs(state.rate) > Real(1e-4); ++steps) {
      state = step_yaw(settings, state, goal, kStep);
      EXPECT_LE(state.yaw, goal + Real(1e-4));
    }
    // Two ramps and a cruise: goal / rate + rate / acceleration, or 2 sqrt(goal / acceleration).
    EXPECT_LE(static_cast<Real>(steps) * kStep, goal / settings.rate_max + Real(0.9));
  }
}

TEST(Yaw, KeepsItsLimitsWhateverIsWanted) {
  YawSettings settings;
  test::Random random(1);
  YawState state;
  Real wanted = 0;
  for (int i = 0; i < 5000; ++i) {
    if (i % 17 == 0) wanted = random.uniform(-10, 10);
    const Real dt = random.uniform(Real(0.001), Real(0.05));
    const YawState next = step_yaw(settings, state, wanted, dt);
    EXPECT_LE(std::fabs(next.rate), settings.rate_max + kTolerance);
    EXPECT_LE(std::fabs(next.rate - state.rate), settings.acceleration_max * dt + kTolerance);
    EXPECT_LE(std::fabs(next.yaw), kPi + kTolerance);
    EXPECT_NEAR(wrap_angle(next.yaw - state.yaw - next.rate * dt), 0, 10 * kTolerance);
    state = next;
  }
}

TEST(Yaw, FollowsATurnSlowerThanItsLimit) {
  const YawSettings settings;
  YawState state;
  for (int i = 0; i < 500; ++i) state = step_yaw(settings, state, wrap_angle(Real(0.02) * static_cast<Real>(i)), kStep);
  EXPECT_NEAR(wrap_angle(state.yaw - Real(0.02) * 499), 0, 0.2);
  EXPECT_NEAR(state.rate, 1, 0.05);
}

TEST(Yaw, NumbersThatAreNoneLeaveTheStateAsItWas) {
  const YawSettings settings;
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  const YawState state{1, Real(0.5)};
  for (const Real dt : {nan, Real(0), Real(-1), Real(5)}) EXPECT_EQ(step_yaw(settings, state, 2, dt).yaw, 1);
  EXPECT_EQ(step_yaw(settings, state, nan, kStep).rate, Real(0.5));
  EXPECT_EQ(step_yaw(settings, state, std::numeric_limits<Real>::infinity(), kStep).rate, Real(0.5));
}

}  // namespace
}  // namespace swiftlet
