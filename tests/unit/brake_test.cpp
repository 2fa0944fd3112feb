#include "swiftlet/brake.hpp"

#include <algorithm>

#include "harness/random_corridor.hpp"
#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr bool kIsDouble = sizeof(Real) == 8;
using test::Random;
using test::RandomCorridor;

/// 4 m along x from rest to rest in 4 s: 1.875 m/s and 1.443 m/s^2 at most.
Segment straight_leg() {
  Segment leg;
  leg.duration = 4;
  leg.coefficients[0] = {0, 0, 0, Real(40) / 64, Real(-60) / 256, Real(24) / 1024};
  return leg;
}

BrakeLimits axis_limit(Real a_max) {
  BrakeLimits limits;
  limits.a_max = Vector3::Constant(a_max);
  return limits;
}

/// The excess of a braked trajectory over per-axis limits at any of its samples [m/s^2].
Real largest_excess(std::span<const Segment> segments, const BrakeProfile& profile, const BrakeLimits& limits) {
  Real excess = -limits.a_max[0];
  const Real stop = profile.delay + profile.duration;
  for (int k = 0; k <= 400; ++k) {
    const PathTime at = path_time(profile, stop * static_cast<Real>(k) / 400);
    const Sample sample = slowed(sample_trajectory(segments, at.s), at);
    excess = std::max(excess, (sample.acceleration.cwiseAbs() - limits.a_max).maxCoeff());
  }
  return excess;
}

TEST(Brake, PathTimeFallsSmoothlyToRest) {
  const BrakeProfile profile{2, Real(0.5), 1};
  EXPECT_NEAR(path_time(profile, 0).s, 2, 1e-6);
  EXPECT_NEAR(path_time(profile, Real(0.5)).s, 2.5, 1e-6);
  EXPECT_NEAR(path_time(profile, Real(0.5)).rate, 1, 1e-6);
  EXPECT_NEAR(path_time(profile, 1).rate, 0.5, 1e-6);
  EXPECT_NEAR(path_time(profile, 1).rate1, -1.875, 1e-5);
  EXPECT_NEAR(path_time(profile, Real(1.5)).s, 3, 1e-6);
  EXPECT_EQ(path_time(profile, 9).s, 3);
  EXPECT_EQ(path_time(profile, 9).rate, 0);
}

TEST(Brake, DerivativesOfPathTimeAreThoseOfItsValues) {
  const BrakeProfile profile{1, Real(0.25), Real(0.8)};
  const Real h = kIsDouble ? Real(1e-5) : Real(1e-2);
  const Real tolerance = kIsDouble ? Real(1e-5) : Real(2e-2);
  for (int k = 1; k < 20; ++k) {
    const Real t = Real(0.06) * static_cast<Real>(k);
    const PathTime before = path_time(profile, t - h);
    const PathTime at = path_time(profile, t);
    const PathTime after = path_time(profile, t + h);
    EXPECT_NEAR(at.rate, (after.s - before.s) / (2 * h), tolerance);
    EXPECT_NEAR(at.rate1, (after.rate - before.rate) / (2 * h), 10 * tolerance);
    EXPECT_NEAR(at.rate2, (after.rate1 - before.rate1) / (2 * h), 100 * tolerance);
  }
}

TEST(Brake, SlowedDerivativesAreThoseOfTheSlowedPosition) {
  const Segment leg = straight_leg();
  const BrakeProfile profile{1, 0, 1};
  const Real h = kIsDouble ? Real(1e-5) : Real(1e-2);
  const Real tolerance = kIsDouble ? Real(1e-4) : Real(0.2);
  const auto at = [&](Real t) {
    const PathTime time = path_time(profile, t);
    return slowed(sample_segment(leg, time.s), time);
  };
  for (int k = 1; k < 10; ++k) {
    const Real t = Real(0.1) * static_cast<Real>(k);
    EXPECT_NEAR(at(t).velocity[0], (at(t + h).position[0] - at(t - h).position[0]) / (2 * h), tolerance);
    EXPECT_NEAR(at(t).acceleration[0], (at(t + h).velocity[0] - at(t - h).velocity[0]) / (2 * h), tolerance);
    EXPECT_NEAR(at(t).jerk[0], (at(t + h).acceleration[0] - at(t - h).acceleration[0]) / (2 * h), 10 * tolerance);
  }
}

TEST(Brake, ABrakeHarderThanTheLimitsIsNotProven) {
  const Segment leg = straight_leg();
  EXPECT_FALSE(keeps_limits({&leg, 1}, {2, 0, Real(0.5)}, axis_limit(2)));  // 1.875 * 1.875 / 0.5 = 7 m/s^2
  EXPECT_TRUE(keeps_limits({&leg, 1}, {2, 0, 4}, axis_limit(2)));
}

TEST(Brake, StopsLongBeforeTheEndAndWithinTheLimits) {
  const Segment leg = straight_leg();
  const BrakeLimits limits = axis_limit(2);
  const BrakeProfile profile = find_brake({&leg, 1}, Real(1.5), limits);
  EXPECT_GT(profile.duration, 0);
  EXPECT_LT(path_time(profile, 100).s, 3);
  EXPECT_LE(largest_excess({&leg, 1}, profile, limits), Real(2e-3));
}

TEST(Brake, WaitsWhileTheTrajectorySlowsDownAtItsLimit) {
  const Segment leg = straight_leg();
  const BrakeLimits limits = axis_limit(Real(1.4434));  // the leg's own extreme, at 0.789 of its duration
  const BrakeProfile profile = find_brake({&leg, 1}, Real(3.1), limits);
  EXPECT_LE(largest_excess({&leg, 1}, profile, limits), Real(2e-3));
}

TEST(Brake, KeepsTheJerkLimit) {
  const Segment leg = straight_leg();
  BrakeLimits limits = axis_limit(4);
  limits.jerk_norm_max = 5;
  const BrakeProfile profile = find_brake({&leg, 1}, Real(1.5), limits);
  EXPECT_GT(profile.duration, 0);
  for (int k = 0; k <= 200; ++k) {
    const PathTime at = path_time(profile, (profile.delay + profile.duration) * static_cast<Real>(k) / 200);
    EXPECT_LE(slowed(sample_segment(leg, at.s), at).jerk.norm(), Real(5.01));
  }
}

TEST(Brake, PastTheEndThereIsNothingToBrake) {
  const Segment leg = straight_leg();
  EXPECT_EQ(find_brake({&leg, 1}, 7, axis_limit(2)).duration, 0);
}

// Any trajectory that keeps its limits, braked anywhere: limits kept, and never later at rest than the trajectory.
TEST(Brake, KeepsTheLimitsOfRandomTrajectoriesAtAnyInstant) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const RandomCorridor corridor(seed, 5, seed % 2 == 0);
    const TrajectoryProblem problem = corridor.problem();
    std::array<Segment, RandomCorridor::kMost> storage;
    stop_at_gates(std::span(corridor.points).first(6), problem.v_max, problem.a_max, storage);
    const std::span<const Segment> segments = std::span(storage).first(5);
    const BrakeLimits limits{problem.a_max};
    const Real total = total_duration(segments);
    Random random(seed);
    for (int k = 0; k < 10; ++k) {
      const BrakeProfile profile = find_brake(segments, random.uniform(0, total), limits);
      EXPECT_LE(largest_excess(segments, profile, limits), Real(2e-3) * problem.a_max[0]);
      EXPECT_LE(profile.duration > 0 ? path_time(profile, 1000).s : total, total);
    }
  }
}

}  // namespace
}  // namespace swiftlet
