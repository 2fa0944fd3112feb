#include "swiftlet/time_refinement.hpp"

#include "harness/random_corridor.hpp"
#include "swiftlet/storage.hpp"
#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr bool kIsDouble = sizeof(Real) == 8;
using test::RandomCorridor;

TrajectoryStorage<RandomCorridor::kMost> storage;
RefinementStorage<RandomCorridor::kMost> refinement_storage;
constexpr std::uint64_t kWork = 20'000;

/// No rows to start from.
RefinementSpans fresh() { return refinement_storage.spans(); }

Real summed_cost(std::span<const Segment> segments) {
  return jerk_cost(segments, 0) + jerk_cost(segments, 1) + jerk_cost(segments, 2);
}

TEST(TimeRefinement, TheGradientIsTheSlopeOfTheOptimalCost) {
  if (!kIsDouble) return;  // differences of floats say nothing
  int active = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    RandomCorridor corridor(seed, 6, seed % 2 == 0);
    for (std::size_t i = 0; i < 6; ++i) corridor.durations[i] *= Real(0.8);  // so that limits are active
    std::array<Segment, RandomCorridor::kMost> segments;
    std::array<Real, 6> gradient{};
    TrajectoryReport report;
    if (generate_trajectory(corridor.problem(), storage.spans(), segments, report, nullptr, gradient) != Status::kOk) {
      continue;
    }
    active += static_cast<int>(report.active);
    for (std::size_t i = 0; i < 6; ++i) {
      const Real step = Real(1e-6);
      std::array<Real, 2> cost{};
      for (const std::size_t side : {0, 1}) {
        RandomCorridor moved = corridor;
        moved.durations[i] += side == 0 ? -step : step;
        ASSERT_EQ(generate_trajectory(moved.problem(), storage.spans(), segments, report), Status::kOk);
        cost[side] = summed_cost(std::span(segments).first(6));
      }
      const Real slope = (cost[1] - cost[0]) / (2 * step);
      EXPECT_NEAR(gradient[i], slope, Real(1e-3) * (1 + std::fabs(slope)));
    }
  }
  EXPECT_GT(active, 20);
}

/// The solve that comes before a refinement.
Status try_durations(const RandomCorridor& corridor, std::span<Segment> segments, TrajectoryReport& report,
                     RefinementSpans& spans) {
  TrajectoryProblem problem = corridor.problem();
  problem.effort = kTrialEffort;
  return generate_trajectory(problem, storage.spans(), segments, report, &spans.warm,
                             spans.gradient.first(corridor.count));
}

TEST(TimeRefinement, NeverEndsWorseThanItBeganAndUsuallyFarBetter) {
  int far_better = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    RandomCorridor corridor(seed, 2 + seed % 8, seed % 2 == 0);
    const std::span<Real> durations = std::span(corridor.durations).first(corridor.count);
    std::array<Segment, RandomCorridor::kMost> segments;
    const std::span<Segment> used = std::span(segments).first(corridor.count);
    TrajectoryReport report;
    const Real weight = 10;
    RefinementSpans refinement_spans = fresh();
    ASSERT_EQ(try_durations(corridor, segments, report, refinement_spans), Status::kOk);
    const Real before = summed_cost(used) + weight * total_duration(used);
    ASSERT_EQ(refine_durations(corridor.problem(), {weight, kWork, {}}, storage.spans(), refinement_spans, durations,
                               segments, report),
              Status::kOk);
    const Real after = summed_cost(used) + weight * total_duration(used);
    EXPECT_LE(after, before * (1 + (kIsDouble ? Real(1e-9) : Real(1e-2))));
    far_better += after < Real(0.8) * before ? 1 : 0;
    for (std::size_t i = 0; i < corridor.count; ++i) EXPECT_EQ(segments[i].duration, corridor.durations[i]);
  }
  EXPECT_GT(far_better, 20);
}

TEST(TimeRefinement, WithoutABudgetTheDurationsStay) {
  RandomCorridor corridor(4, 5, true);
  const std::array<Real, RandomCorridor::kMost> given = corridor.durations;
  std::array<Segment, RandomCorridor::kMost> segments;
  TrajectoryReport report;
  RefinementSpans refinement_spans = fresh();
  ASSERT_EQ(refine_durations(corridor.problem(), {10, 0, {}}, storage.spans(), refinement_spans,
                             std::span(corridor.durations).first(5), segments, report),
            Status::kOk);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(corridor.durations[i], given[i]);
}

TEST(TimeRefinement, GivesUpOnATrialOnceItMustCostMoreThanTheBest) {
  int saved = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const RandomCorridor corridor(seed, 8, seed % 2 == 0);
    std::array<Segment, RandomCorridor::kMost> segments;
    TrajectoryReport whole;
    TrajectoryProblem problem = corridor.problem();
    ASSERT_EQ(generate_trajectory(problem, storage.spans(), segments, whole), Status::kOk);
    const Real cost = summed_cost(std::span(segments).first(8));
    EXPECT_NEAR(whole.cost, cost, (kIsDouble ? Real(1e-8) : Real(1e-2)) * cost);
    TrajectoryReport report;
    problem.effort.most_cost = Real(1.05) * whole.cost;
    EXPECT_EQ(generate_trajectory(problem, storage.spans(), segments, report), Status::kOk);
    problem.effort.most_cost = Real(0.95) * whole.cost;
    EXPECT_EQ(generate_trajectory(problem, storage.spans(), segments, report), Status::kIterationLimit);
    saved += static_cast<int>(whole.qp_iterations) - static_cast<int>(report.qp_iterations);
  }
  EXPECT_GT(saved, 20);
}

TEST(TimeRefinement, PassesOnThatTheDurationsGivenAreInfeasible) {
  RandomCorridor corridor(4, 5, true);
  for (std::size_t i = 0; i < 5; ++i) corridor.durations[i] /= 10;
  std::array<Segment, RandomCorridor::kMost> segments;
  TrajectoryReport report;
  RefinementSpans refinement_spans = fresh();
  const Status status = refine_durations(corridor.problem(), {10, 0, {}}, storage.spans(), refinement_spans,
                                         std::span(corridor.durations).first(5), segments, report);
  // Float may give up before it has proven as much.
  EXPECT_TRUE(status == Status::kInfeasible || (!kIsDouble && status == Status::kIterationLimit));
}

}  // namespace
}  // namespace swiftlet
