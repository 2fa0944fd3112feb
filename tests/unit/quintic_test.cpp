#include "swiftlet/quintic.hpp"

#include "harness/random_corridor.hpp"
#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr Real kTolerance = sizeof(Real) == 8 ? Real(1e-11) : Real(2e-3);

QuinticEnds random_ends(test::Random& random) {
  QuinticEnds ends{};
  for (Real& end : ends) end = random.uniform(-2, 2);
  return ends;
}

TEST(Quintic, TakesItsEndStatesAtBothEnds) {
  test::Random random(1);
  for (int run = 0; run < 100; ++run) {
    const QuinticEnds ends = random_ends(random);
    const Quintic quintic = quintic_from_ends(ends);
    for (int derivative = 0; derivative <= 2; ++derivative) {
      const auto k = static_cast<std::size_t>(derivative);
      EXPECT_NEAR(quintic_value(quintic, derivative, 0), ends[k], kTolerance);
      EXPECT_NEAR(quintic_value(quintic, derivative, 1), ends[3 + k], kTolerance);
    }
  }
}

TEST(Quintic, BasisWeighsTheEndStatesToTheValueAnywhere) {
  test::Random random(2);
  for (int run = 0; run < 100; ++run) {
    const QuinticEnds ends = random_ends(random);
    const Quintic quintic = quintic_from_ends(ends);
    const Real tau = random.uniform(0, 1);
    for (int derivative = 0; derivative <= 2; ++derivative) {
      const QuinticEnds basis = quintic_basis(derivative, tau);
      Real sum = 0;
      for (std::size_t k = 0; k < ends.size(); ++k) sum += basis[k] * ends[k];
      EXPECT_NEAR(sum, quintic_value(quintic, derivative, tau), 100 * kTolerance);
    }
  }
}

TEST(Quintic, LiesInTheHullOfItsControlPoints) {
  test::Random random(3);
  for (int run = 0; run < 200; ++run) {
    const QuinticEnds ends = random_ends(random);
    const std::array<Real, 6> points = quintic_control_points(ends);
    const Real lo = *std::min_element(points.begin(), points.end());
    const Real hi = *std::max_element(points.begin(), points.end());
    for (int i = 0; i <= 50; ++i) {
      const Real value = quintic_value(quintic_from_ends(ends), 0, static_cast<Real>(i) / 50);
      EXPECT_GE(value, lo - kTolerance);
      EXPECT_LE(value, hi + kTolerance);
    }
  }
}

TEST(Quintic, NoSampleExceedsTheValuesAtCriticalPointsAndEnds) {
  test::Random random(4);
  for (int run = 0; run < 300; ++run) {
    const Quintic quintic = quintic_from_ends(random_ends(random));
    for (int derivative = 0; derivative <= 2; ++derivative) {
      Real lo = std::min(quintic_value(quintic, derivative, 0), quintic_value(quintic, derivative, 1));
      Real hi = std::max(quintic_value(quintic, derivative, 0), quintic_value(quintic, derivative, 1));
      const CriticalPoints critical = critical_points(quintic, derivative);
      EXPECT_LE(critical.count, std::size_t{4});
      for (std::size_t i = 0; i < critical.count; ++i) {
        const Real value = quintic_value(quintic, derivative, critical.tau[i]);
        lo = std::min(lo, value);
        hi = std::max(hi, value);
      }
      for (int i = 0; i <= 100; ++i) {
        const Real value = quintic_value(quintic, derivative, static_cast<Real>(i) / 100);
        EXPECT_GE(value, lo - 10 * kTolerance);
        EXPECT_LE(value, hi + 10 * kTolerance);
      }
    }
  }
}

TEST(Quintic, RestToRestPeaksInSpeedHalfwayAndInAccelerationAtTheWorkedTimes) {
  const Quintic quintic = quintic_from_ends({0, 0, 0, 1, 0, 0});
  bool has_middle = false;
  const CriticalPoints of_speed = critical_points(quintic, 1);
  for (std::size_t i = 0; i < of_speed.count; ++i) has_middle |= std::fabs(of_speed.tau[i] - Real(0.5)) < Real(1e-4);
  EXPECT_TRUE(has_middle);
  EXPECT_NEAR(quintic_value(quintic, 1, Real(0.5)), 1.875, kTolerance);
  const CriticalPoints of_acceleration = critical_points(quintic, 2);  // tau = 1/2 -+ 1/(2 sqrt 3)
  ASSERT_EQ(of_acceleration.count, std::size_t{2});
  EXPECT_NEAR(of_acceleration.tau[0], 0.21132486540518712, 1e-5);
  EXPECT_NEAR(of_acceleration.tau[1], 0.78867513459481288, 1e-5);
  EXPECT_NEAR(quintic_value(quintic, 2, of_acceleration.tau[0]), 5.7735026918962576, 1e-3);
}

}  // namespace
}  // namespace swiftlet
