#include "swiftlet/braking.hpp"

#include <cmath>

#include "harness/random_corridor.hpp"
#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr Real kTolerance = sizeof(Real) == 8 ? Real(1e-9) : Real(1e-4);

Braking brake(const State& start, Real v_max, Real a_max, Real j_max = kUnlimited) {
  return brake_within({{0, 0, 0}, {4, 4, 4}}, start, Vector3::Constant(v_max), Vector3::Constant(a_max), j_max);
}

TEST(Braking, EndsAtRestWithinTheBoxAndTheLimits) {
  test::Random random(7);
  int braked = 0;
  for (int run = 0; run < 300; ++run) {
    State start;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      start.position[axis] = random.uniform(Real(0.5), Real(3.5));
      start.velocity[axis] = random.uniform(Real(-1.5), Real(1.5));
      if (run % 3 == 0) start.acceleration[axis] = random.uniform(-1, 1);
    }
    const Braking braking = brake(start, 2, 2);
    EXPECT_EQ(braking.count > 0, braking.missing == 0);
    if (braking.count == 0) continue;
    ++braked;
    State state = start;
    for (std::size_t i = 0; i < braking.count; ++i) {
      const Segment& piece = braking.pieces[i];
      const Sample begin = sample_segment(piece, 0);
      EXPECT_LT((begin.position - state.position).norm(), kTolerance);
      EXPECT_LT((begin.velocity - state.velocity).norm(), kTolerance);
      EXPECT_LT((begin.acceleration - state.acceleration).norm(), kTolerance);
      for (int k = 0; k <= 50; ++k) {
        const Sample s = sample_segment(piece, piece.duration * static_cast<Real>(k) / 50);
        EXPECT_LE(s.velocity.cwiseAbs().maxCoeff(), 2 + kTolerance);
        EXPECT_LE(s.acceleration.cwiseAbs().maxCoeff(), 2 + kTolerance);
        EXPECT_GE(s.position.minCoeff(), -kTolerance);
        EXPECT_LE(s.position.maxCoeff(), 4 + kTolerance);
      }
      const Sample end = sample_segment(piece, piece.duration);
      state = {end.position, end.velocity, end.acceleration};
    }
    EXPECT_LT(state.velocity.norm(), kTolerance);
    EXPECT_LT(state.acceleration.norm(), kTolerance);
  }
  EXPECT_GT(braked, 200);
}

TEST(Braking, Needs055TimesTheSquareOfTheSpeedOverTheDecelerationAndNoLess) {
  State start;
  start.position = {2, 2, 2};
  start.velocity = {0, 1, 0};  // v^2 / a is 1 m at 1 m/s^2
  start.position[1] = 4 - Real(0.55);
  EXPECT_GT(brake(start, 1, 1).count, std::size_t{0});
  start.position[1] = 4 - Real(0.49);
  const Braking braking = brake(start, 1, 1);
  EXPECT_EQ(braking.count, std::size_t{0});
  EXPECT_EQ(braking.axis, std::size_t{1});
  EXPECT_GT(braking.missing, Real(0.01));
  EXPECT_LT(braking.missing, Real(0.06));
}

TEST(Braking, AJerkLimitIsKeptAndCostsRoom) {
  State start;
  start.position = {2, 2, 4 - Real(0.6)};
  start.velocity = {0, 0, 1};
  EXPECT_GT(brake(start, 1, 1).count, std::size_t{0});
  EXPECT_EQ(brake(start, 1, 1, 2).count, std::size_t{0});  // the ramps alone take half a second each
  start.position[2] = 2;
  const Braking braking = brake(start, 1, 1, 2);
  ASSERT_GT(braking.count, std::size_t{0});
  for (std::size_t i = 0; i < braking.count; ++i) {
    EXPECT_LE(sample_segment(braking.pieces[i], 0).jerk.cwiseAbs().maxCoeff(), 2 + kTolerance);
  }
}

}  // namespace
}  // namespace swiftlet
