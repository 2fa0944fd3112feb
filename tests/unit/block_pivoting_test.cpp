#include "swiftlet/block_pivoting.hpp"

#include "harness/random_corridor.hpp"
#include "swiftlet/storage.hpp"
#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr bool kIsDouble = sizeof(Real) == 8;
constexpr std::uint32_t kMostSweeps = 60;
constexpr Real kAnyCost = std::numeric_limits<Real>::infinity();

TrajectoryStorage<test::RandomCorridor::kMost> storage;

/// A corridor in less time than its plan from gate to gate takes, so that rows are needed.
struct Hurried {
  test::RandomCorridor corridor;
  TrajectoryProblem problem;

  explicit Hurried(std::size_t seed) : corridor(seed, 4 + seed % 20, seed % 2 == 0) {
    for (Real& duration : std::span(corridor.durations).first(corridor.count)) duration *= Real(0.8);
    problem = corridor.problem();
  }

  [[nodiscard]] AxisBounds bounds(std::size_t axis) const {
    const auto row = static_cast<Eigen::Index>(axis);
    const Real reference = corridor.boxes[0].lo[row];
    return {&problem,
            {axis,
             problem.durations,
             {},
             problem.gates,
             {corridor.start.position[row] - reference, 0, 0},
             {corridor.goal.position[row] - reference, 0, 0},
             reference},
            {}};
  }
};

std::size_t active_rows_of(const BlockPivoting& pivoting) {
  std::size_t rows = 0;
  pivoting.for_each_active([&](const QpLabel& label, Real) { rows += to_place(label).what != kGate ? 1 : 0; });
  return rows;
}

TEST(BlockPivoting, SettlesNearlyAlwaysAndItsMultipliersPress) {
  int axes = 0;
  int settled = 0;
  std::size_t rows = 0;
  for (std::size_t seed = 0; seed < 60; ++seed) {
    const Hurried hurried(seed);
    TrajectoryReport report;
    std::array<Segment, test::RandomCorridor::kMost> segments;
    if (generate_trajectory(hurried.problem, storage.spans(), segments, report) != Status::kOk) continue;
    for (std::size_t axis = 0; axis < 3; ++axis, ++axes) {
      const AxisBounds bounds = hurried.bounds(axis);
      BlockPivoting pivoting(bounds, storage.spans(), kMostSweeps, kAnyCost);
      if (pivoting.run({}) != Status::kOk) continue;
      ++settled;
      rows += active_rows_of(pivoting);
      pivoting.for_each_active([&](const QpLabel&, Real multiplier) { EXPECT_GE(multiplier, 0); });
      EXPECT_LE(pivoting.residual(), kIsDouble ? Real(1e-9) : Real(1e-3));
    }
  }
  EXPECT_GE(axes, 90);
  EXPECT_GE(settled, axes - axes / 25);
  EXPECT_GE(rows, 30U);
}

TEST(BlockPivoting, FindsItsAnswerAgainInOneSweep) {
  for (std::size_t seed = 0; seed < 30; ++seed) {
    const Hurried hurried(seed);
    const AxisBounds bounds = hurried.bounds(seed % 3);
    BlockPivoting first(bounds, storage.spans(), kMostSweeps, kAnyCost);
    if (first.run({}) != Status::kOk) continue;
    const Real cost = first.cost();
    std::array<QpLabel, 64> labels;
    std::size_t count = 0;
    first.for_each_active([&](const QpLabel& label, Real) { labels[count++] = label; });
    BlockPivoting again(bounds, storage.spans(), kMostSweeps, kAnyCost);
    EXPECT_TRUE(again.run(std::span(labels).first(count)) == Status::kOk);
    EXPECT_EQ(again.sweeps(), 1U);
    EXPECT_NEAR(again.cost(), cost, (kIsDouble ? Real(1e-9) : Real(1e-4)) * cost);
  }
}

TEST(BlockPivoting, TheDualMethodAgrees) {
  int compared = 0;
  for (std::size_t seed = 0; seed < 60; ++seed) {
    const Hurried hurried(seed);
    std::array<Segment, test::RandomCorridor::kMost> segments;
    TrajectoryReport own;
    const Status status = generate_trajectory(hurried.problem, storage.spans(), segments, own);
    TrajectorySpans without_rows = storage.spans();
    without_rows.pivoting.rows = {};  // nothing but gates: the dual method has to decide the rest
    TrajectoryReport dual;
    EXPECT_EQ(generate_trajectory(hurried.problem, without_rows, segments, dual), status);
    if (status != Status::kOk) continue;
    EXPECT_NEAR(own.cost, dual.cost, (kIsDouble ? Real(1e-6) : Real(1e-2)) * dual.cost);
    compared += dual.qp_iterations > own.qp_iterations ? 1 : 0;
  }
  EXPECT_GE(compared, 15);
}

TEST(BlockPivoting, LeavesOpenWhatItHasNoSweepsFor) {
  const Hurried hurried(2);
  const AxisBounds bounds = hurried.bounds(0);
  BlockPivoting none(bounds, storage.spans(), 0, kAnyCost);
  EXPECT_FALSE(none.run({}).has_value());
  EXPECT_EQ(none.sweeps(), 0U);
}

TEST(BlockPivoting, EndsOnceTheAxisIsTooDear) {
  int ended = 0;
  for (std::size_t seed = 0; seed < 30; ++seed) {
    const Hurried hurried(seed);
    const AxisBounds bounds = hurried.bounds(0);
    BlockPivoting whole(bounds, storage.spans(), kMostSweeps, kAnyCost);
    if (whole.run({}) != Status::kOk) continue;
    const Real cost = whole.cost();
    BlockPivoting cheaper(bounds, storage.spans(), kMostSweeps, Real(0.9) * cost);
    const std::optional<Status> status = cheaper.run({});
    EXPECT_TRUE(status == Status::kIterationLimit);
    ended += status == Status::kIterationLimit ? 1 : 0;
  }
  EXPECT_GE(ended, 15);
}

TEST(BlockPivoting, OneSegmentHasNothingToPivot) {
  const test::RandomCorridor corridor(3, 1, true);
  const TrajectoryProblem problem = corridor.problem();
  const Real reference = corridor.boxes[0].lo[0];
  const AxisBounds bounds{&problem,
                          {0,
                           problem.durations,
                           {},
                           problem.gates,
                           {corridor.start.position[0] - reference, 0, 0},
                           {corridor.goal.position[0] - reference, 0, 0},
                           reference},
                          {}};
  BlockPivoting pivoting(bounds, storage.spans(), kMostSweeps, kAnyCost);
  EXPECT_TRUE(pivoting.run({}) == Status::kOk);
  EXPECT_EQ(pivoting.active_count(), 0U);
}

}  // namespace
}  // namespace swiftlet
