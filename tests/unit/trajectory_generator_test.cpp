#include "swiftlet/trajectory_generator.hpp"

#include "harness/random_corridor.hpp"
#include "swiftlet/certificate.hpp"
#include "swiftlet/storage.hpp"
#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr bool kIsDouble = sizeof(Real) == 8;
constexpr Real kBound = kIsDouble ? Real(1e-6) : Real(1e-3);
constexpr Real kInfinity = std::numeric_limits<Real>::infinity();
using test::RandomCorridor;

TrajectoryStorage<RandomCorridor::kMost> storage;

struct Answer {
  std::array<Segment, RandomCorridor::kMost> segments;
  TrajectoryReport report;
  Status status = Status::kBadRequest;
  std::size_t count = 0;

  explicit Answer(const TrajectoryProblem& problem) : count(problem.boxes.size()) {
    status = generate_trajectory(problem, storage.spans(), segments, report);
  }
  [[nodiscard]] std::span<const Segment> all() const { return std::span(segments).first(count); }
};

void expect_inside(const TrajectoryProblem& problem, std::span<const Segment> segments) {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    for (int k = 0; k <= 100; ++k) {
      const Sample sample = sample_segment(segments[i], segments[i].duration * static_cast<Real>(k) / 100);
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        EXPECT_GE(sample.position[axis], problem.boxes[i].lo[axis] - kBound);
        EXPECT_LE(sample.position[axis], problem.boxes[i].hi[axis] + kBound);
        EXPECT_LE(std::fabs(sample.velocity[axis]), problem.v_max[axis] + kBound);
        EXPECT_LE(std::fabs(sample.acceleration[axis]), problem.a_max[axis] + 4 * kBound);
      }
    }
  }
}

TEST(TrajectoryGenerator, AtTheStoppingTimesEveryCorridorHasACertifiedAnswer) {
  const int runs = test::kPropertyRuns / 5;
  for (int run = 0; run < runs; ++run) {
    const RandomCorridor corridor(static_cast<std::uint64_t>(run), 1 + static_cast<std::size_t>(run) % 12,
                                  run % 2 == 0);
    const TrajectoryProblem problem = corridor.problem();
    const Answer answer(problem);
    ASSERT_EQ(answer.status, Status::kOk);
    expect_inside(problem, answer.all());
    const Certificate certificate = certify(answer.all(), {problem.boxes, problem.gates, problem.start, problem.goal,
                                                           problem.v_max, problem.a_max, kInfinity, kInfinity});
    EXPECT_TRUE(certificate.pass);
  }
}

TEST(TrajectoryGenerator, NeverCostsMoreThanStoppingAtEveryGate) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const RandomCorridor corridor(seed, 6, seed % 2 == 0);
    std::array<Segment, RandomCorridor::kMost> stop;
    const TrajectoryProblem problem = corridor.problem();
    stop_at_gates(std::span(corridor.points).first(7), problem.v_max, problem.a_max, stop);
    const Answer answer(problem);
    ASSERT_EQ(answer.status, Status::kOk);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_LE(jerk_cost(answer.all(), axis), jerk_cost(std::span(stop).first(6), axis) * Real(1.0001) + Real(1e-6));
    }
  }
}

TEST(TrajectoryGenerator, LongChainsOfWideGatesAreSolvedInEitherPrecision) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const RandomCorridor corridor(seed, RandomCorridor::kMost, false);
    const TrajectoryProblem problem = corridor.problem();
    const Answer answer(problem);
    ASSERT_EQ(answer.status, Status::kOk);
    expect_inside(problem, answer.all());
  }
}

TEST(TrajectoryGenerator, PermutingTheAxesPermutesTheAnswer) {
  const RandomCorridor corridor(3, 8, true);
  RandomCorridor turned = corridor;
  const auto turn = [](Vector3& v) { v = Vector3{v[2], v[0], v[1]}; };
  for (std::size_t i = 0; i < corridor.count; ++i) {
    turn(turned.boxes[i].lo);
    turn(turned.boxes[i].hi);
    if (i + 1 == corridor.count) continue;
    turn(turned.gates[i].lo);
    turn(turned.gates[i].hi);
  }
  turn(turned.start.position);
  turn(turned.goal.position);
  const Answer a(corridor.problem());
  const Answer b(turned.problem());
  ASSERT_EQ(a.status, Status::kOk);
  ASSERT_EQ(b.status, Status::kOk);
  for (std::size_t i = 0; i < corridor.count; ++i) {
    for (std::size_t j = 0; j < kQuinticTerms; ++j) {
      EXPECT_EQ(a.segments[i].coefficients[2][j], b.segments[i].coefficients[0][j]);
    }
  }
}

TEST(TrajectoryGenerator, AboveTheOptimumJerkIsContinuousWhereNoRowIsActive) {
  // One straight corridor with generous limits: nothing is active, so the answer is a single quintic.
  RandomCorridor corridor(5, 4, false);
  for (std::size_t i = 0; i < 4; ++i) {
    corridor.boxes[i] = {Vector3::Constant(-50), Vector3::Constant(50)};
    corridor.gates[i] = corridor.boxes[i];
  }
  corridor.v_max = corridor.a_max = 100;
  const Answer answer(corridor.problem());
  ASSERT_EQ(answer.status, Status::kOk);
  EXPECT_EQ(answer.report.active, std::uint32_t{0});
  for (std::size_t i = 0; i + 1 < 4; ++i) {
    const Vector3 before = sample_segment(answer.segments[i], answer.segments[i].duration).jerk;
    const Vector3 after = sample_segment(answer.segments[i + 1], 0).jerk;
    EXPECT_LT((before - after).norm(), kIsDouble ? 1e-8 : 1e-1);
  }
}

TEST(TrajectoryGenerator, MarginsKeepThePathFartherInsideOrFallBackToNone) {
  const RandomCorridor corridor(11, 6, true);
  TrajectoryProblem problem = corridor.problem();
  const Answer plain(problem);
  problem.margins = {Real(0.002), Real(0.05), Real(0.05)};
  const Answer kept(problem);
  ASSERT_EQ(kept.status, Status::kOk);
  expect_inside(problem, kept.all());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_GE(jerk_cost(kept.all(), axis), jerk_cost(plain.all(), axis) * (1 - (kIsDouble ? Real(1e-7) : Real(2e-2))));
  }
}

TEST(TrajectoryGenerator, TooShortTimesAreInfeasibleAndSayWhatBlocks) {
  RandomCorridor corridor(2, 3, true);
  for (std::size_t i = 0; i < 3; ++i) corridor.durations[i] /= 10;
  const TrajectoryProblem problem = corridor.problem();
  Answer answer(problem);
  ASSERT_EQ(answer.status, Status::kInfeasible);
  EXPECT_LT(answer.report.blocking.box, std::uint32_t{3});
  EXPECT_LT(answer.report.blocking.axis, 3);
  EXPECT_GT(answer.report.blocking.missing, Real(0));
  std::array<Real, 3> scratch{};
  const Real stretch = smallest_stretch(problem, storage.spans(), answer.segments, scratch);
  EXPECT_GT(stretch, Real(1));
  EXPECT_LE(stretch, Real(10.2));
  for (std::size_t i = 0; i < 3; ++i) corridor.durations[i] *= stretch;
  EXPECT_EQ(Answer(corridor.problem()).status, Status::kOk);
}

TEST(TrajectoryGenerator, AStartFasterThanTheLimitIsInfeasible) {
  RandomCorridor corridor(2, 3, true);
  corridor.start.velocity[1] = corridor.v_max * Real(1.5);
  const Answer answer(corridor.problem());
  EXPECT_EQ(answer.status, Status::kInfeasible);
  EXPECT_EQ(answer.report.blocking.axis, 1);
  EXPECT_TRUE(answer.report.blocking.bound == BoundKind::kVelocity);
}

TEST(TrajectoryGenerator, AStartOutsideItsBoxIsInfeasible) {
  RandomCorridor corridor(2, 3, true);
  corridor.start.position[0] = corridor.boxes[0].hi[0] + 1;
  EXPECT_EQ(Answer(corridor.problem()).status, Status::kInfeasible);
}

TEST(TrajectoryGenerator, RefusesRequestsThatMakeNoSense) {
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  const auto status_of = [](auto&& spoil) {
    RandomCorridor corridor(2, 3, true);
    TrajectoryProblem problem = corridor.problem();
    spoil(corridor, problem);
    return Answer(problem).status;
  };
  EXPECT_EQ(status_of([&](RandomCorridor& c, TrajectoryProblem&) { c.durations[1] = 0; }), Status::kBadRequest);
  EXPECT_EQ(status_of([&](RandomCorridor& c, TrajectoryProblem&) { c.durations[1] = nan; }), Status::kBadRequest);
  EXPECT_EQ(status_of([&](RandomCorridor& c, TrajectoryProblem&) { c.durations[2] = kInfinity; }), Status::kBadRequest);
  EXPECT_EQ(status_of([&](RandomCorridor& c, TrajectoryProblem&) { std::swap(c.boxes[1].lo, c.boxes[1].hi); }),
            Status::kBadRequest);
  EXPECT_EQ(status_of([&](RandomCorridor& c, TrajectoryProblem&) { c.gates[0].hi[0] += 10; }), Status::kBadRequest);
  EXPECT_EQ(status_of([&](RandomCorridor&, TrajectoryProblem& p) { p.gates = p.gates.first(1); }), Status::kBadRequest);
  EXPECT_EQ(status_of([&](RandomCorridor&, TrajectoryProblem& p) { p.durations = p.durations.first(2); }),
            Status::kBadRequest);
  EXPECT_EQ(status_of([&](RandomCorridor&, TrajectoryProblem& p) { p.start.position[2] = nan; }), Status::kBadRequest);
  EXPECT_EQ(status_of([&](RandomCorridor&, TrajectoryProblem& p) { p.v_max[0] = 0; }), Status::kBadRequest);
  EXPECT_EQ(status_of([&](RandomCorridor&, TrajectoryProblem& p) { p.a_max[0] = nan; }), Status::kBadRequest);
  EXPECT_EQ(status_of([&](RandomCorridor&, TrajectoryProblem& p) { p.margins.position = -1; }), Status::kBadRequest);
}

TEST(TrajectoryGenerator, ACorridorLongerThanTheStorageIsRefused) {
  static TrajectoryStorage<4> small;
  const RandomCorridor fits(1, 4, true);
  const RandomCorridor longer(1, 5, true);
  std::array<Segment, 5> segments;
  TrajectoryReport report;
  EXPECT_EQ(generate_trajectory(fits.problem(), small.spans(), segments, report), Status::kOk);
  EXPECT_EQ(generate_trajectory(longer.problem(), small.spans(), segments, report), Status::kCorridorCapacity);
}

TEST(TrajectoryGenerator, SixtyFourSegmentsFitInto64KiB) {
  constexpr std::size_t kBytes = sizeof(TrajectoryStorage<64>) + sizeof(RefinementStorage<64>);
  static_assert(kBytes <= std::size_t{64} * 1024, "memory of the trajectory stage, refinement of times included");
  EXPECT_LE(kBytes, (kIsDouble ? std::size_t{64} : std::size_t{40}) * 1024);
}

TEST(StopAtGates, ReachesItsPointsAtRestWithinTheLimits) {
  const RandomCorridor corridor(9, 5, true);
  std::array<Segment, 5> stop;
  const TrajectoryProblem problem = corridor.problem();
  stop_at_gates(std::span(corridor.points).first(6), problem.v_max, problem.a_max, stop);
  expect_inside(problem, stop);
  for (std::size_t i = 0; i < 5; ++i) {
    const Sample end = sample_segment(stop[i], stop[i].duration);
    EXPECT_LT((end.position - corridor.points[i + 1]).norm(), kBound);
    EXPECT_LT(end.velocity.norm(), kBound);
  }
}

TEST(StopAtGates, GivesPointsThatCoincideAShortPositiveTime) {
  const std::array<Vector3, 2> points{Vector3::Ones(), Vector3::Ones()};
  std::array<Segment, 1> stop;
  stop_at_gates(points, Vector3::Ones(), Vector3::Ones(), stop);
  EXPECT_GT(stop[0].duration, Real(0));
  EXPECT_LT((sample_segment(stop[0], stop[0].duration).position - points[1]).norm(), Real(1e-6));
}

}  // namespace
}  // namespace swiftlet
