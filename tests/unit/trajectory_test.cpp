#include "swiftlet/trajectory.hpp"

#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

/// 1 m in 2 s from rest to rest along x, then 3 m in 1 s along y at constant speed.
std::array<Segment, 2> two_segments() {
  std::array<Segment, 2> segments;
  segments[0].duration = 2;
  segments[0].coefficients[0] = {0, 0, 0, Real(10) / 8, Real(-15) / 16, Real(6) / 32};
  segments[1].duration = 1;
  segments[1].coefficients[0][0] = 1;
  segments[1].coefficients[1][1] = 3;
  return segments;
}

TEST(Trajectory, SamplesPositionToJerkByHand) {
  const std::array<Segment, 2> segments = two_segments();
  const Sample middle = sample_segment(segments[0], 1);
  EXPECT_NEAR(middle.position[0], 0.5, 1e-6);
  EXPECT_NEAR(middle.velocity[0], 1.875 / 2, 1e-6);
  EXPECT_NEAR(middle.acceleration[0], 0, 1e-5);
  EXPECT_NEAR(middle.jerk[0], -30.0 / 8, 1e-5);
}

TEST(Trajectory, RunsThroughItsSegmentsAndHoldsItsEnds) {
  const std::array<Segment, 2> segments = two_segments();
  EXPECT_NEAR(sample_trajectory(segments, -5).position[0], 0, 1e-6);
  EXPECT_NEAR(sample_trajectory(segments, Real(2.5)).position[1], 1.5, 1e-6);
  EXPECT_NEAR(sample_trajectory(segments, 100).position[1], 3, 1e-6);
  EXPECT_NEAR(total_duration(segments), 3, 1e-6);
}

TEST(Trajectory, JerkCostOfRestToRestIs720OverT5) {
  const std::array<Segment, 2> segments = two_segments();
  EXPECT_NEAR(jerk_cost(segments, 0), 720.0 / 32, 1e-4);
  EXPECT_NEAR(jerk_cost(segments, 1), 0, 1e-6);
}

TEST(Trajectory, ArcLengthAddsUpToTheWayFlown) { EXPECT_NEAR(arc_length(two_segments()), 4, 4e-4); }

}  // namespace
}  // namespace swiftlet
