// Theorem 1 by the paper's own iteration (Sec. IV-C): the QP is solved with all rows so far, a row is added at every
// violating extremum delta_p inside the bound, and so on. Each point is at least delta_p / s from those before it, s
// being the largest speed of any iterate, so a segment of duration T takes at most ceil(T s / delta_p) + 1 a side.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "harness/random_corridor.hpp"
#include "swiftlet/min_jerk.hpp"
#include "swiftlet/storage.hpp"

namespace swiftlet {
namespace {

constexpr Real kMargin = Real(0.002);  // delta_p [m]
constexpr Real kHolds = sizeof(Real) == 8 ? Real(1e-9) : Real(2e-4);
constexpr int kRoundLimit = 60;
constexpr std::size_t kRows = 400;

/// The paper's iteration on one axis.
class PointIteration {
 public:
  PointIteration(const AxisProblem& axis, std::span<const Box> boxes, const QpSpans& spans)
      : axis_(axis),
        boxes_(boxes),
        solver_(factored(axis, spans), axis.segment_count() - 1, 4000),
        counts_(2 * boxes.size(), 0) {
    for (std::size_t k = 0; k + 1 < axis.segment_count(); ++k) {
      if (is_pinned(axis, k)) continue;
      rows_.push_back(gate_row(k, 1, axis.gate_hi(k)));
      rows_.push_back(gate_row(k, -1, axis.gate_lo(k)));
    }
  }

  /// False when the rows with their margin contradict each other; the points added until then count all the same.
  bool run() {
    for (int round = 0; round < kRoundLimit; ++round) {
      if (!solve()) return false;
      measure_speed();
      if (!add_points()) return true;
    }
    return true;
  }

  [[nodiscard]] Real speed() const { return speed_; }
  [[nodiscard]] const std::vector<int>& counts() const { return counts_; }  ///< a segment: above, below

 private:
  static const QpSpans& factored(const AxisProblem& axis, const QpSpans& spans) {
    factor_jerk_cost(axis, spans.factor, spans.optimum);
    return spans;
  }

  bool solve() {
    while (true) {
      const QpRow* worst = nullptr;
      Real excess = kHolds;
      for (const QpRow& row : rows_) {
        const Real violation = row_value(row, solver_.solution()) - row.bound;
        if (violation <= excess) continue;
        excess = violation;
        worst = &row;
      }
      if (worst == nullptr) return true;
      if (solver_.enforce(*worst) != Status::kOk) return false;
    }
  }

  [[nodiscard]] Quintic segment(std::size_t i) const {
    return quintic_from_ends(segment_ends(axis_, i, solver_.solution()));
  }

  void measure_speed() {
    for (std::size_t i = 0; i < axis_.segment_count(); ++i) {
      const Quintic quintic = segment(i);
      const CriticalPoints points = critical_points(quintic, 1);
      const auto consider = [&](Real tau) {
        speed_ = std::max(speed_, std::fabs(quintic_value(quintic, 1, tau)) / axis_.durations[i]);
      };
      for (std::size_t k = 0; k < points.count; ++k) consider(points.tau[k]);
      consider(0);
      consider(1);
    }
  }

  bool add_points() {
    const auto row = static_cast<Eigen::Index>(axis_.axis);
    bool added = false;
    for (std::size_t i = 0; i < axis_.segment_count(); ++i) {
      const Quintic quintic = segment(i);
      const Real hi = boxes_[i].hi[row] - axis_.reference;
      const Real lo = boxes_[i].lo[row] - axis_.reference;
      const CriticalPoints points = critical_points(quintic, 0);
      for (std::size_t k = 0; k < points.count; ++k) {
        const Real position = quintic_value(quintic, 0, points.tau[k]);
        const bool above = position > hi + kHolds;
        if (!above && position >= lo - kHolds) continue;
        const Real sign = above ? Real(1) : Real(-1);
        rows_.push_back(extremum_row(axis_, i, 0, points.tau[k], sign, above ? hi - kMargin : lo + kMargin));
        ++counts_[2 * i + (above ? 0 : 1)];
        added = true;
      }
    }
    return added;
  }

  const AxisProblem& axis_;
  std::span<const Box> boxes_;
  DualActiveSet solver_;
  std::vector<QpRow> rows_;
  std::vector<int> counts_;
  Real speed_ = 0;
};

/// Durations at which a corridor is flown at about `speed`, too fast for it now and then.
std::vector<Real> durations_at(const test::RandomCorridor& corridor, Real speed) {
  std::vector<Real> durations;
  for (std::size_t i = 0; i < corridor.count; ++i) {
    const Real length = (corridor.points[i + 1] - corridor.points[i]).norm();
    durations.push_back(std::max(length / speed, Real(0.05)));
  }
  return durations;
}

TEST(ConstraintPointsProperty, TheIterationNeverAddsMoreThanTheorem1Allows) {
  std::vector<FactorBlock> factor(test::RandomCorridor::kMost);
  std::vector<Real> optimum(kBlockSize * test::RandomCorridor::kMost);
  std::vector<Real> solution(optimum.size());
  std::vector<Real> work(optimum.size());
  std::vector<QpRow> active(kRows);
  std::vector<Real> multipliers(kRows);
  std::vector<Real> target(kRows);
  std::vector<Real> direction(kRows);
  std::vector<Real> gram(kRows * (kRows + 1) / 2);
  const QpSpans spans{factor, optimum, solution, work, active, multipliers, target, direction, gram};
  double largest_share = 0;
  int most = 0;
  long points = 0;
  int infeasible = 0;
  int axes = 0;
  for (std::uint64_t seed = 0; seed < SWIFTLET_PROPERTY_RUNS; ++seed) {
    test::Random random(seed + 77000);
    const test::RandomCorridor corridor(seed, 2 + random.below(11), seed % 2 == 0);
    const std::vector<Real> durations = durations_at(corridor, random.uniform(Real(0.5), 5));
    std::vector<Real> scales(corridor.count - 1);
    junction_scales(durations, scales);
    const TrajectoryProblem problem = corridor.problem();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      const Real reference = corridor.boxes[0].lo[row];
      const AxisProblem axis{k,
                             durations,
                             scales,
                             problem.gates,
                             {corridor.start.position[row] - reference, 0, 0},
                             {corridor.goal.position[row] - reference, 0, 0},
                             reference};
      PointIteration iteration(axis, problem.boxes, spans);
      infeasible += iteration.run() ? 0 : 1;
      ++axes;
      for (std::size_t j = 0; j < iteration.counts().size(); ++j) {
        const Real bound = std::ceil(durations[j / 2] * iteration.speed() / kMargin) + 1;
        const int count = iteration.counts()[j];
        ASSERT_LE(static_cast<Real>(count), bound) << "seed " << seed << " axis " << k << " segment " << j / 2;
        largest_share = std::max(largest_share, static_cast<double>(static_cast<Real>(count) / bound));
        most = std::max(most, count);
        points += count;
      }
    }
  }
  EXPECT_GT(points, axes / 20);  // or nothing was tested
  RecordProperty("largest_share_of_the_bound", std::to_string(largest_share));
  RecordProperty("most_points_of_a_segment_and_side", most);
  std::printf(
      "%d axes (%d infeasible with margin), %ld points; most a segment and side %d, largest share of the bound %.4f\n",
      axes, infeasible, points, most, largest_share);
}

}  // namespace
}  // namespace swiftlet
