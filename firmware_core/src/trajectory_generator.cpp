#include "swiftlet/trajectory_generator.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/min_jerk.hpp"
#include "swiftlet/quintic.hpp"

namespace swiftlet {
namespace {

constexpr std::uint32_t kSweepLimit = 60;  // sweeps over all segments
// Two active rows of one kind this close together (in normalised time) hold one extremum between them. Adding a third
// there would only halve the gap; the one row that stands for both lies at their multipliers' centre of gravity, to
// second order in the gap. Sweeps beyond kMergingSweeps keep all rows, in case two points of one kind are needed side
// by side.
constexpr Real kSameExtremum = Real(0.2);
constexpr std::uint32_t kMergingSweeps = 20;
constexpr std::uint32_t kJointRounds = 40;  // of gates together; the longest corridors measured take 25
constexpr Real kGateTolerance = Real(1e-6);

/// Where a row comes from; labels carry it through the solver.
struct RowPlace {
  std::size_t place;   // segment, or junction of a gate
  std::uint32_t what;  // derivative, or kGate
  Real sign;
  Real tau;
};
constexpr std::uint32_t kGate = 3;

QpLabel to_label(const RowPlace& at) {
  return {static_cast<std::uint32_t>(at.place) << 3U | at.what << 1U | (at.sign > 0 ? 1U : 0U), at.tau};
}

RowPlace to_place(const QpLabel& label) {
  return {label.kind >> 3U, label.kind >> 1U & 3U, (label.kind & 1U) != 0 ? Real(1) : Real(-1), label.where};
}

/// One axis of a problem with its bounds, relative to the low corner of the first box.
struct AxisBounds {
  const TrajectoryProblem* problem;
  AxisProblem axis;
  Margins margins;

  [[nodiscard]] Eigen::Index row() const { return static_cast<Eigen::Index>(axis.axis); }
  [[nodiscard]] Real lower(std::size_t segment, int derivative) const {
    if (derivative == 0) return problem->boxes[segment].lo[row()] - axis.reference;
    return -upper(segment, derivative);
  }
  [[nodiscard]] Real upper(std::size_t segment, int derivative) const {
    if (derivative == 0) return problem->boxes[segment].hi[row()] - axis.reference;
    return derivative == 1 ? problem->v_max[row()] : problem->a_max[row()];
  }
  [[nodiscard]] Real margin(int derivative) const {
    return derivative == 0 ? margins.position : derivative == 1 ? margins.velocity : margins.acceleration;
  }
};

/// Rows that one axis may add and drop.
std::uint32_t step_limit(const AxisBounds& bounds) {
  const auto segments = static_cast<std::uint32_t>(bounds.axis.segment_count());
  const SolveEffort& effort = bounds.problem->effort;
  return std::min(effort.steps_per_segment * segments + 100, effort.most_steps);
}

/// The row of a bound at a point, its margin inside (eq. 9, 10, 14, 15).
QpRow bound_row(const AxisBounds& bounds, const RowPlace& at) {
  QpRow row;
  if (at.what == kGate) {
    row = gate_row(at.place, at.sign, at.sign > 0 ? bounds.axis.gate_hi(at.place) : bounds.axis.gate_lo(at.place));
  } else {
    const int derivative = static_cast<int>(at.what);
    const Real bound = at.sign > 0 ? bounds.upper(at.place, derivative) : bounds.lower(at.place, derivative);
    row = extremum_row(bounds.axis, at.place, derivative, at.tau, at.sign, bound - at.sign * bounds.margin(derivative));
  }
  row.label = to_label(at);
  return row;
}

AxisBounds axis_bounds(const TrajectoryProblem& problem, std::span<const Real> scales, std::size_t axis,
                       const Margins& margins) {
  const auto row = static_cast<Eigen::Index>(axis);
  const Real reference = problem.boxes[0].lo[row];
  AxisBounds bounds{&problem, {}, margins};
  bounds.axis = {
      axis,
      problem.durations,
      scales,
      problem.gates,
      {problem.start.position[row] - reference, problem.start.velocity[row], problem.start.acceleration[row]},
      {problem.goal.position[row] - reference, problem.goal.velocity[row], problem.goal.acceleration[row]},
      reference};
  return bounds;
}

bool is_finite(const Vector3& v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }

bool is_finite(const State& state) {
  return is_finite(state.position) && is_finite(state.velocity) && is_finite(state.acceleration);
}

bool is_box(const Box& box) {
  return is_finite(box.lo) && is_finite(box.hi) && (box.lo.array() <= box.hi.array()).all();
}

bool lies_in(const Box& inner, const Box& outer) {
  return (inner.lo.array() >= outer.lo.array() - kGateTolerance).all() &&
         (inner.hi.array() <= outer.hi.array() + kGateTolerance).all();
}

bool is_well_posed(const TrajectoryProblem& problem, std::span<Segment> segments) {
  const std::size_t count = problem.boxes.size();
  if (count == 0 || problem.gates.size() + 1 != count || problem.durations.size() != count) return false;
  if (segments.size() < count || !is_finite(problem.start) || !is_finite(problem.goal)) return false;
  if (!(problem.v_max.array() > 0).all() || !(problem.a_max.array() > 0).all()) return false;
  const Margins& m = problem.margins;
  if (!(m.position >= 0 && m.velocity >= 0 && m.acceleration >= 0)) return false;
  for (const Real duration : problem.durations) {
    if (!(duration > 0) || !std::isfinite(duration)) return false;
  }
  for (const Box& box : problem.boxes) {
    if (!is_box(box)) return false;
  }
  for (std::size_t k = 0; k + 1 < count; ++k) {
    const Box& gate = problem.gates[k];
    if (!is_box(gate) || !lies_in(gate, problem.boxes[k]) || !lies_in(gate, problem.boxes[k + 1])) return false;
  }
  return true;
}

struct Range {
  Real least;
  Real most;
  void add(Real value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
  [[nodiscard]] bool lies_in(const Range& outer) const { return least >= outer.least && most <= outer.most; }
};

/// Range of the first `count` Bernstein control points.
Range hull(const std::array<Real, 6>& points, std::size_t count) {
  Range range{points[0], points[0]};
  for (std::size_t i = 1; i < count; ++i) range.add(points[i]);
  return range;
}

/// Range of the control points of the two halves (de Casteljau).
Range hull_of_halves(std::array<Real, 6> points, std::size_t count) {
  Range range{points[0], points[0]};
  for (; count > 0; --count) {
    range.add(points[0]);
    range.add(points[count - 1]);
    for (std::size_t i = 0; i + 1 < count; ++i) points[i] = (points[i] + points[i + 1]) / 2;
  }
  return range;
}

/// The bound that the segment exceeds most, relative to the bound's own scale; excess 0 when it keeps them all.
class SegmentSweep {
 public:
  SegmentSweep(const AxisBounds& bounds, std::size_t segment, std::span<const Real> unknowns)
      : bounds_(bounds), segment_(segment), ends_(segment_ends(bounds.axis, segment, unknowns)) {}

  Violation worst() {
    // Control points of the derivatives by differences. Inside its bounds they, or those of its halves, prove that no
    // extremum violates: the cheap reject that most segments take.
    std::array<Real, 6> points = quintic_control_points(ends_);
    const Real rate = 1 / bounds_.axis.durations[segment_];
    const Real tolerance = bounds_.problem->effort.tolerance;
    std::size_t count = points.size();
    for (int derivative = 0; derivative <= 2; ++derivative) {
      const Range allowed{bounds_.lower(segment_, derivative) - tolerance,
                          bounds_.upper(segment_, derivative) + tolerance};
      if (!hull(points, count).lies_in(allowed) && !hull_of_halves(points, count).lies_in(allowed)) {
        check_extrema(derivative);
      }
      const Real factor = static_cast<Real>(--count) * rate;
      for (std::size_t i = 0; i < count; ++i) points[i] = factor * (points[i + 1] - points[i]);
    }
    return worst_;
  }

 private:
  void check_extrema(int derivative) {
    const Quintic quintic = quintic_from_ends(ends_);
    const CriticalPoints inner = critical_points(quintic, derivative);
    for (std::size_t i = 0; i < inner.count; ++i) check(quintic, derivative, inner.tau[i]);
    // Junctions: once, from the segment on their right; the two ends of the trajectory belong to their only segment.
    check(quintic, derivative, 0);
    if (segment_ + 1 == bounds_.axis.segment_count()) check(quintic, derivative, 1);
  }

  void check(const Quintic& quintic, int derivative, Real tau) {
    Real value = quintic_value(quintic, derivative, tau);
    for (int d = 0; d < derivative; ++d) value /= bounds_.axis.durations[segment_];
    const Real lo = bounds_.lower(segment_, derivative);
    const Real hi = bounds_.upper(segment_, derivative);
    const Real excess = std::max(value - hi, lo - value);
    const Real scale = derivative == 0 ? Real(1) : hi;
    if (!(excess > bounds_.problem->effort.tolerance) || excess / scale <= worst_ratio_) return;
    worst_ratio_ = excess / scale;
    const bool above = value - hi >= lo - value;
    worst_ = {static_cast<std::uint32_t>(segment_),
              static_cast<std::uint8_t>(derivative),
              tau,
              above ? Real(1) : Real(-1),
              above ? hi : lo,
              excess};
  }

  const AxisBounds& bounds_;
  std::size_t segment_;
  QuinticEnds ends_;
  Violation worst_;
  Real worst_ratio_ = 0;
};

/// Eq. 10 without its margin: how far the point of a violation is beyond the bound by now.
Real remaining_excess(const AxisBounds& bounds, const Violation& violation, std::span<const Real> unknowns) {
  const QpRow row = extremum_row(bounds.axis, violation.segment, violation.derivative, violation.tau, violation.sign,
                                 violation.bound);
  return row_value(row, unknowns) - row.bound;
}

/// The solve of one axis: gates first, then extrema, until no bound is exceeded.
class AxisSolve {
 public:
  /// `most_cost`: when the axis must cost more than this, the solve ends with kIterationLimit.
  AxisSolve(const AxisBounds& bounds, const TrajectorySpans& spans, Real most_cost)
      : bounds_(bounds),
        violations_(spans.violations),
        most_cost_(most_cost),
        unconstrained_cost_(factor_jerk_cost(bounds.axis, spans.qp.factor, spans.qp.optimum)),
        solver_(spans.qp, bounds.axis.segment_count() - 1, step_limit(bounds)) {}

  /// `labels`: rows to start from.
  Status run(std::span<const QpLabel> labels) {
    if (!ends_are_inside()) return Status::kInfeasible;
    if (const Status status = start_from(labels); status != Status::kOk) return status;
    for (std::uint32_t sweep = 0; sweep < kSweepLimit; ++sweep) {
      if (const Status status = enforce_gates(); status != Status::kOk) return status;
      const std::size_t count = find_violations();
      if (count == 0) return Status::kOk;
      merging_ = sweep < kMergingSweeps;
      const std::uint32_t before = rows_added_;
      if (const Status status = enforce_violations(count); status != Status::kOk) return status;
      if (rows_added_ == before) return Status::kOk;  // every point keeps its bound; what is left is rounding
    }
    return Status::kIterationLimit;
  }

  [[nodiscard]] const DualActiveSet& solver() const { return solver_; }
  [[nodiscard]] const Violation& last() const { return last_; }
  [[nodiscard]] std::uint32_t rows_added() const { return rows_added_; }
  /// Of the solution; under way a lower bound, since more rows only cost more [m^2/s^5].
  [[nodiscard]] Real cost() const { return unconstrained_cost_ + solver_.distance2(); }

 private:
  [[nodiscard]] Real tolerance() const { return bounds_.problem->effort.tolerance; }

  /// Rows of an earlier solve, rebuilt for this one's durations.
  Status start_from(std::span<const QpLabel> labels) {
    for (const QpLabel& label : labels) {
      if (const Status status = solver_.join(bound_row(bounds_, to_place(label))); status != Status::kOk) return status;
    }
    return affordable(labels.empty() ? Status::kOk : solver_.move());
  }

  /// `status` of a step of the solver, unless the solution has become too dear.
  [[nodiscard]] Status affordable(Status status) const {
    return status == Status::kOk && cost() > most_cost_ ? Status::kIterationLimit : status;
  }

  /// Start and goal states are constants: no row can help where one is beyond its bound.
  bool ends_are_inside() {
    const auto last = static_cast<std::uint32_t>(bounds_.axis.segment_count() - 1);
    for (std::uint8_t derivative = 0; derivative <= 2; ++derivative) {
      for (const bool at_goal : {false, true}) {
        const std::uint32_t segment = at_goal ? last : 0;
        const Real value = (at_goal ? bounds_.axis.goal : bounds_.axis.start)[derivative];
        const Real above = value - bounds_.upper(segment, derivative);
        const Real below = bounds_.lower(segment, derivative) - value;
        if (std::max(above, below) <= tolerance()) continue;
        last_ = {segment,
                 derivative,
                 at_goal ? Real(1) : Real(0),
                 above > below ? Real(1) : Real(-1),
                 value,
                 std::max(above, below)};
        return false;
      }
    }
    return true;
  }

  Status enforce(const QpRow& row, const Violation& violation) {
    last_ = violation;
    ++rows_added_;
    const Pair pair = merging_ ? rows_around(row.label) : Pair{};
    if (pair.count < 2) return affordable(solver_.enforce(row));
    RowPlace merged = to_place(row.label);
    const Real u0 = solver_.multipliers()[pair.first];
    const Real u1 = solver_.multipliers()[pair.second];
    const Real t0 = solver_.active_rows()[pair.first].label.where;
    const Real t1 = solver_.active_rows()[pair.second].label.where;
    if (u0 + u1 > 0) merged.tau = (u0 * t0 + u1 * t1) / (u0 + u1);
    return affordable(solver_.merge(pair.first, pair.second, bound_row(bounds_, merged)));
  }

  /// The active rows that bound the same extremum as `label`.
  struct Pair {
    std::size_t count = 0;
    std::size_t first = 0;
    std::size_t second = 0;
  };
  [[nodiscard]] Pair rows_around(const QpLabel& label) const {
    const std::span<const QpRow> active = solver_.active_rows();
    Pair pair;
    for (std::size_t j = 0; j < active.size(); ++j) {
      if (active[j].label.kind != label.kind || std::fabs(active[j].label.where - label.where) > kSameExtremum)
        continue;
      (pair.count++ == 0 ? pair.first : pair.second) = j;
    }
    return pair;
  }

  /// Window constraints (eq. 9, 14, 15). The worst gate of each neighbourhood joins at once: gates far apart hardly
  /// feel each other, so the number of rounds hardly grows with the chain. The last rounds take one gate at a time,
  /// each of which raises the dual cost.
  Status enforce_gates() {
    for (std::uint32_t round = 0;; ++round) {
      const std::size_t count = find_violated_gates();
      if (count == 0) return Status::kOk;
      Status status = Status::kOk;
      if (count == 1 || round >= kJointRounds) {
        status = enforce(gate_bound(violations_[0]), violations_[0]);
      } else {
        for (const Violation& violation : violations_.first(count)) {
          if (status == Status::kOk) status = solver_.join(gate_bound(violation));
        }
        rows_added_ += static_cast<std::uint32_t>(count);
        if (status == Status::kOk) status = affordable(solver_.move());
      }
      if (status != Status::kOk) return status;
    }
  }

  /// Excess of a junction over its gate, positive above the upper bound, negative below the lower one, 0 inside.
  [[nodiscard]] Real gate_excess(std::size_t k) const {
    if (k + 1 >= bounds_.axis.segment_count() || is_pinned(bounds_.axis, k)) return 0;
    const Real p = solver_.solution()[kBlockSize * k];
    const Real above = p - bounds_.axis.gate_hi(k);
    const Real below = bounds_.axis.gate_lo(k) - p;
    if (above > tolerance() && above >= below) return above;
    return below > tolerance() ? -below : Real(0);
  }

  /// Gates more violated than the two on either side of them, the worst first.
  std::size_t find_violated_gates() {
    std::array<Real, 5> excess{0, 0, 0, gate_excess(0), gate_excess(1)};  // of junctions k - 2 to k + 2
    std::size_t count = 0;
    for (std::size_t k = 0; k + 1 < bounds_.axis.segment_count(); ++k) {
      for (std::size_t i = 0; i + 1 < excess.size(); ++i) excess[i] = excess[i + 1];
      excess[4] = gate_excess(k + 2);
      const Real own = std::fabs(excess[2]);
      const bool worst = own > std::fabs(excess[0]) && own > std::fabs(excess[1]) && own >= std::fabs(excess[3]) &&
                         own >= std::fabs(excess[4]);
      if (!worst) continue;
      const Real sign = excess[2] > 0 ? Real(1) : Real(-1);
      const Real bound = sign > 0 ? bounds_.axis.gate_hi(k) : bounds_.axis.gate_lo(k);
      violations_[count] = {static_cast<std::uint32_t>(k), 0, 1, sign, bound, own};
      if (own > violations_[0].excess) std::swap(violations_[0], violations_[count]);
      ++count;
    }
    return count;
  }

  [[nodiscard]] QpRow gate_bound(const Violation& violation) const {
    return bound_row(bounds_, {violation.segment, kGate, violation.sign, 0});
  }

  /// The worst violation of each segment that has one, most exceeded first.
  std::size_t find_violations() {
    std::size_t count = 0;
    for (std::size_t i = 0; i < bounds_.axis.segment_count(); ++i) {
      const Violation violation = SegmentSweep(bounds_, i, solver_.solution()).worst();
      if (violation.excess == 0) continue;
      std::size_t place = count++;
      for (; place > 0 && violations_[place - 1].excess < violation.excess; --place) {
        violations_[place] = violations_[place - 1];
      }
      violations_[place] = violation;
    }
    return count;
  }

  Status enforce_violations(std::size_t count) {
    for (const Violation& violation : violations_.first(count)) {
      if (remaining_excess(bounds_, violation, solver_.solution()) <= tolerance()) continue;
      const QpRow row = bound_row(bounds_, {violation.segment, violation.derivative, violation.sign, violation.tau});
      if (const Status status = enforce(row, violation); status != Status::kOk) return status;
    }
    return Status::kOk;
  }

  const AxisBounds& bounds_;
  std::span<Violation> violations_;
  Real most_cost_;
  Real unconstrained_cost_;
  DualActiveSet solver_;
  Violation last_;
  std::uint32_t rows_added_ = 0;
  bool merging_ = false;
};

void emit_axis(const AxisBounds& bounds, std::span<const Real> unknowns, std::span<Segment> segments) {
  for (std::size_t i = 0; i < bounds.axis.segment_count(); ++i) {
    const Quintic quintic = quintic_from_ends(segment_ends(bounds.axis, i, unknowns));
    const Real T = bounds.axis.durations[i];
    std::array<Real, kQuinticTerms>& c = segments[i].coefficients[bounds.axis.axis];
    Real unit = 1;
    for (std::size_t j = 0; j < kQuinticTerms; ++j) {
      c[j] = quintic[j] / unit;
      unit *= T;
    }
    c[0] += bounds.axis.reference;
    segments[i].duration = T;
  }
}

/// Adds the derivative of the optimal cost by each duration: that of a minimum-jerk arc between fixed states, which is
/// minus its conserved quantity jerk^2 - 2 acceleration snap + 2 velocity crackle, and that of each active row times
/// its multiplier.
void add_gradient(const AxisBounds& bounds, const DualActiveSet& solver, std::span<Real> gradient) {
  const std::span<const Real> unknowns = solver.solution();
  for (std::size_t i = 0; i < bounds.axis.segment_count(); ++i) {
    const Real T = bounds.axis.durations[i];
    const Quintic c = quintic_from_ends(segment_ends(bounds.axis, i, unknowns));
    gradient[i] -= (36 * c[3] * c[3] - 96 * c[2] * c[4] + 240 * c[1] * c[5]) / (T * T * T * T * T * T);
  }
  for (std::size_t j = 0; j < solver.active_count(); ++j) {
    const RowPlace at = to_place(solver.active_rows()[j].label);
    if (at.what == kGate) continue;
    const Real T = bounds.axis.durations[at.place];
    const QuinticEnds ends = segment_ends(bounds.axis, at.place, unknowns);
    const QuinticEnds basis = quintic_basis(static_cast<int>(at.what), at.tau);
    Real slope = 0;
    for (std::size_t k = 0; k < ends.size(); ++k) {
      slope += (static_cast<Real>(k % kBlockSize) - static_cast<Real>(at.what)) * basis[k] * ends[k];
    }
    for (std::uint32_t d = 0; d <= at.what; ++d) slope /= T;
    // The solver minimises half the cost.
    gradient[at.place] += 2 * solver.multipliers()[j] * at.sign * slope;
  }
}

void keep_labels(const DualActiveSet& solver, std::span<QpLabel> labels, std::size_t& count) {
  count = std::min(labels.size(), solver.active_count());
  for (std::size_t j = 0; j < count; ++j) labels[j] = solver.active_rows()[j].label;
}

Status solve_axis(const AxisBounds& bounds, const TrajectorySpans& spans, std::span<Segment> segments,
                  TrajectoryReport& report, WarmStart* warm, std::span<Real> gradient) {
  AxisSolve solve(bounds, spans, bounds.problem->effort.most_cost - report.cost);
  const std::size_t axis = bounds.axis.axis;
  const Status status = solve.run(warm ? warm->labels[axis].first(warm->count[axis]) : std::span<QpLabel>{});
  report.qp_iterations += solve.solver().iterations();
  report.constraints_added += solve.rows_added();
  report.work += bounds.axis.segment_count() * (kWorkOfSetUp + solve.solver().iterations());
  if (status != Status::kOk) {
    const Violation& v = solve.last();
    report.blocking = {v.segment, static_cast<std::uint8_t>(axis), static_cast<BoundKind>(v.derivative), v.excess, 0};
    return status;
  }
  report.cost += solve.cost();
  report.active += static_cast<std::uint32_t>(solve.solver().active_count());
  report.residual = std::max(report.residual, solve.solver().residual());
  emit_axis(bounds, solve.solver().solution(), segments);
  if (warm) keep_labels(solve.solver(), warm->labels[axis], warm->count[axis]);
  if (!gradient.empty()) add_gradient(bounds, solve.solver(), gradient);
  return status;
}

}  // namespace

Status generate_trajectory(const TrajectoryProblem& problem, const TrajectorySpans& spans, std::span<Segment> segments,
                           TrajectoryReport& report, WarmStart* warm, std::span<Real> gradient) {
  if (!is_well_posed(problem, segments)) return Status::kBadRequest;
  if (problem.boxes.size() > spans.violations.size()) return Status::kCorridorCapacity;
  report = {};
  std::fill(gradient.begin(), gradient.end(), Real(0));
  const std::span<Real> scales = spans.scales.first(problem.gates.size());
  junction_scales(problem.durations, scales);
  const Margins& margins = problem.margins;
  const bool has_margins = margins.position > 0 || margins.velocity > 0 || margins.acceleration > 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Status status = solve_axis(axis_bounds(problem, scales, axis, margins), spans, segments, report, warm, gradient);
    if (status != Status::kOk && has_margins) {
      // Only without margins is every generated row necessary, and so infeasibility proven.
      status = solve_axis(axis_bounds(problem, scales, axis, Margins{}), spans, segments, report, warm, gradient);
    }
    if (status != Status::kOk) return status;
  }
  return Status::kOk;
}

Real smallest_stretch(const TrajectoryProblem& problem, const TrajectorySpans& spans, std::span<Segment> segments,
                      std::span<Real> durations) {
  TrajectoryProblem stretched = problem;
  stretched.durations = durations.first(problem.durations.size());
  const auto succeeds = [&](Real stretch) {
    for (std::size_t i = 0; i < problem.durations.size(); ++i) durations[i] = stretch * problem.durations[i];
    TrajectoryReport report;
    return generate_trajectory(stretched, spans, segments, report) == Status::kOk;
  };
  Real fails = 1;
  Real works = Real(1.25);
  while (!succeeds(works)) {
    fails = works;
    works *= Real(1.25);
    if (works > kLargestStretch) return 0;
  }
  while (works > Real(1.01) * fails) {
    const Real middle = (works + fails) / 2;
    (succeeds(middle) ? works : fails) = middle;
  }
  return works;
}

}  // namespace swiftlet
