#include "swiftlet/trajectory_generator.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/axis_bounds.hpp"
#include "swiftlet/block_pivoting.hpp"
#include "swiftlet/min_jerk.hpp"
#include "swiftlet/quintic.hpp"

namespace swiftlet {
namespace {

constexpr std::uint32_t kSweepLimit = 60;  // sweeps over all segments
// Two rows that hold one extremum are merged when a third comes (holds_same_extremum). Sweeps beyond kMergingSweeps
// keep all rows, in case two points of one kind are needed side by side.
constexpr std::uint32_t kMergingSweeps = 20;
constexpr std::uint32_t kJointRounds = 40;  // of gates together; the longest corridors measured take 25
constexpr Real kGateTolerance = Real(1e-6);

/// Sweeps of block pivoting. The longest search that settled took 14 at 10 segments, 42 at 40, 48 at 80 and 55 at 320
/// with durations to spare (throw-away count over 560 corridors like those of tests/bench/qp); at the edge of
/// feasibility some take 150, where the dual method is as fast.
std::uint32_t sweep_limit(const AxisBounds& bounds) {
  const auto segments = static_cast<std::uint32_t>(bounds.axis.segment_count());
  return std::min(60 + segments / 4, bounds.problem->effort.most_steps / kWorkOfSweep);
}

/// Rows that the dual method may add and drop on one axis, when the search before it was worth `used` steps.
std::uint32_t step_limit(const AxisBounds& bounds, std::uint32_t used) {
  const auto segments = static_cast<std::uint32_t>(bounds.axis.segment_count());
  const SolveEffort& effort = bounds.problem->effort;
  return std::min(effort.steps_per_segment * segments + 100, effort.most_steps - std::min(used, effort.most_steps));
}

/// The row of a bound at a point (eq. 9, 10, 14, 15).
QpRow bound_row(const AxisBounds& bounds, const RowPlace& at) {
  QpRow row;
  if (at.what == kGate) {
    row = gate_row(at.place, at.sign, at.sign > 0 ? bounds.axis.gate_hi(at.place) : bounds.axis.gate_lo(at.place));
  } else {
    row = extremum_row(bounds.axis, at.place, static_cast<int>(at.what), at.tau, at.sign, bounds.target(at));
  }
  row.label = to_label(at);
  return row;
}

AxisBounds axis_bounds(const TrajectoryProblem& problem, const TrajectorySpans& spans, std::size_t axis,
                       const Margins& margins) {
  const auto row = static_cast<Eigen::Index>(axis);
  const Real reference = problem.boxes[0].lo[row];
  AxisBounds bounds{&problem, {}, margins};
  bounds.axis = {
      axis,
      problem.durations,
      spans.scales.first(problem.gates.size()),
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

/// Eq. 10 without its margin: how far the point of a violation is beyond the bound by now.
Real remaining_excess(const AxisBounds& bounds, const Violation& violation, std::span<const Real> unknowns) {
  const QpRow row = extremum_row(bounds.axis, violation.segment, violation.derivative, violation.tau, violation.sign,
                                 violation.bound);
  return row_value(row, unknowns) - row.bound;
}

/// Start and goal states are constants: no row can help where one is beyond its bound, which this returns.
Violation end_violation(const AxisBounds& bounds) {
  const auto last = static_cast<std::uint32_t>(bounds.axis.segment_count() - 1);
  for (std::uint8_t derivative = 0; derivative <= 2; ++derivative) {
    for (const bool at_goal : {false, true}) {
      const std::uint32_t segment = at_goal ? last : 0;
      const Real value = (at_goal ? bounds.axis.goal : bounds.axis.start)[derivative];
      const Real above = value - bounds.upper(segment, derivative);
      const Real below = bounds.lower(segment, derivative) - value;
      if (std::max(above, below) <= bounds.tolerance()) continue;
      return {segment,
              derivative,
              at_goal ? Real(1) : Real(0),
              above > below ? Real(1) : Real(-1),
              value,
              std::max(above, below)};
    }
  }
  return {};
}

/// The dual active-set solve of one axis: gates first, then extrema, until no bound is exceeded.
class DualSolve {
 public:
  /// `most_cost`: when the axis must cost more than this, the solve ends with kIterationLimit.
  DualSolve(const AxisBounds& bounds, const TrajectorySpans& spans, std::uint32_t most_steps, Real most_cost)
      : bounds_(bounds),
        violations_(spans.violations),
        states_(spans.states),
        most_cost_(most_cost),
        unconstrained_cost_(factor_jerk_cost(bounds.axis, spans.qp.factor, spans.qp.optimum)),
        solver_(spans.qp, bounds.axis.segment_count() - 1, most_steps) {}

  /// `labels`: rows to start from.
  Status run(std::span<const QpLabel> labels) {
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

  [[nodiscard]] std::uint32_t iterations() const { return solver_.iterations(); }
  [[nodiscard]] std::size_t active_count() const { return solver_.active_count(); }
  [[nodiscard]] Real residual() const { return solver_.residual(); }
  [[nodiscard]] const Violation& last() const { return last_; }
  [[nodiscard]] std::uint32_t rows_added() const { return rows_added_; }
  /// Of the solution; under way a lower bound, since more rows only cost more [m^2/s^5].
  [[nodiscard]] Real cost() const { return unconstrained_cost_ + solver_.distance2(); }
  [[nodiscard]] std::span<const Real> states() const { return states_; }
  template <class Visit>
  void for_each_active(const Visit& visit) const {
    for (std::size_t j = 0; j < solver_.active_count(); ++j) {
      visit(solver_.active_rows()[j].label, solver_.multipliers()[j]);
    }
  }

 private:
  [[nodiscard]] Real tolerance() const { return bounds_.tolerance(); }

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
      if (!holds_same_extremum(active[j].label, label)) continue;
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
    unscale(bounds_.axis, solver_.solution(), states_);
    const SegmentSweep sweep(bounds_);
    std::size_t count = 0;
    for (std::size_t i = 0; i < bounds_.axis.segment_count(); ++i) {
      Violation violation;
      if (!sweep.find_worst(i, state_ends(bounds_.axis, i, states_), violation)) continue;
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
  std::span<Real> states_;  // of the solution when violations were last sought
  Real most_cost_;
  Real unconstrained_cost_;
  DualActiveSet solver_;
  Violation last_;
  std::uint32_t rows_added_ = 0;
  bool merging_ = false;
};

void emit_axis(const AxisBounds& bounds, std::span<const Real> states, std::span<Segment> segments) {
  for (std::size_t i = 0; i < bounds.axis.segment_count(); ++i) {
    const Quintic quintic = quintic_from_ends(state_ends(bounds.axis, i, states));
    const Real rate = 1 / bounds.axis.durations[i];
    std::array<Real, kQuinticTerms>& c = segments[i].coefficients[bounds.axis.axis];
    Real unit = 1;
    for (std::size_t j = 0; j < kQuinticTerms; ++j) {
      c[j] = quintic[j] * unit;
      unit *= rate;
    }
    c[0] += bounds.axis.reference;
    segments[i].duration = bounds.axis.durations[i];
  }
}

/// Adds the derivative of the optimal cost by each duration: that of a minimum-jerk arc between fixed states, which is
/// minus its conserved quantity jerk^2 - 2 acceleration snap + 2 velocity crackle, and that of each active row times
/// its multiplier.
template <class Solver>
void add_gradient(const AxisBounds& bounds, const Solver& solver, std::span<Real> gradient) {
  const std::span<const Real> states = solver.states();
  for (std::size_t i = 0; i < bounds.axis.segment_count(); ++i) {
    const Real T = bounds.axis.durations[i];
    const Quintic c = quintic_from_ends(state_ends(bounds.axis, i, states));
    gradient[i] -= (36 * c[3] * c[3] - 96 * c[2] * c[4] + 240 * c[1] * c[5]) / (T * T * T * T * T * T);
  }
  solver.for_each_active([&](const QpLabel& label, Real multiplier) {
    const RowPlace at = to_place(label);
    if (at.what == kGate) return;
    const Real T = bounds.axis.durations[at.place];
    const QuinticEnds ends = state_ends(bounds.axis, at.place, states);
    const QuinticEnds basis = quintic_basis(static_cast<int>(at.what), at.tau);
    Real slope = 0;
    for (std::size_t k = 0; k < ends.size(); ++k) {
      slope += (static_cast<Real>(k % kBlockSize) - static_cast<Real>(at.what)) * basis[k] * ends[k];
    }
    for (std::uint32_t d = 0; d <= at.what; ++d) slope /= T;
    // The solvers minimise half the cost.
    gradient[at.place] += 2 * multiplier * at.sign * slope;
  });
}

/// Fills `labels` with the active rows, as far as there is room; returns those filled.
template <class Solver>
std::span<const QpLabel> keep_labels(const Solver& solver, std::span<QpLabel> labels) {
  std::size_t count = 0;
  solver.for_each_active([&](const QpLabel& label, Real) {
    if (count < labels.size()) labels[count++] = label;
  });
  return labels.first(count);
}

void report_blocking(const AxisBounds& bounds, const Violation& v, TrajectoryReport& report) {
  report.blocking = {v.segment, static_cast<std::uint8_t>(bounds.axis.axis), static_cast<BoundKind>(v.derivative),
                     v.excess, 0};
}

/// Where the results of an axis go.
struct Output {
  std::span<Segment> segments;
  TrajectoryReport& report;
  WarmStart* warm;
  std::span<Real> gradient;
};

/// What an axis leaves when it is solved: polynomials, figures, the rows for a warm start, the gradient.
template <class Solver>
void emit(const AxisBounds& bounds, const Solver& solver, const Output& out) {
  out.report.cost += solver.cost();
  out.report.active += static_cast<std::uint32_t>(solver.active_count());
  out.report.residual = std::max(out.report.residual, solver.residual());
  emit_axis(bounds, solver.states(), out.segments);
  if (out.warm) {
    const std::size_t axis = bounds.axis.axis;
    out.warm->count[axis] = keep_labels(solver, out.warm->labels[axis]).size();
  }
  if (!out.gradient.empty()) add_gradient(bounds, solver, out.gradient);
}

/// What block pivoting leaves open, decided by the dual active-set method from the last set.
Status solve_dually(const AxisBounds& bounds, const TrajectorySpans& spans, const BlockPivoting& pivoting,
                    Real most_cost, const Output& out) {
  const std::span<const QpLabel> last_set = keep_labels(pivoting, spans.labels);
  junction_scales(bounds.axis.durations, spans.scales);
  const std::uint32_t used = kWorkOfSweep * pivoting.sweeps() + kWorkOfSetUp;
  DualSolve dual(bounds, spans, step_limit(bounds, used), most_cost);
  const Status status = dual.run(last_set);
  out.report.qp_iterations += dual.iterations();
  out.report.constraints_added += dual.rows_added();
  out.report.work += bounds.axis.segment_count() * (kWorkOfSetUp + dual.iterations());
  if (status == Status::kOk) {
    emit(bounds, dual, out);
  } else {
    report_blocking(bounds, dual.last(), out.report);
  }
  return status;
}

Status solve_axis(const AxisBounds& bounds, const TrajectorySpans& spans, const Output& out) {
  const std::size_t count = bounds.axis.segment_count();
  const std::size_t axis = bounds.axis.axis;
  const Real most_cost = bounds.problem->effort.most_cost - out.report.cost;
  out.report.work += count * kWorkOfSetUp;
  if (const Violation beyond = end_violation(bounds); beyond.excess > 0) {
    report_blocking(bounds, beyond, out.report);
    return Status::kInfeasible;
  }
  BlockPivoting pivoting(bounds, spans, sweep_limit(bounds), most_cost);
  const std::optional<Status> status =
      pivoting.run(out.warm ? out.warm->labels[axis].first(out.warm->count[axis]) : std::span<QpLabel>{});
  out.report.qp_iterations += pivoting.sweeps();
  out.report.constraints_added += pivoting.rows_added();
  out.report.work += count * kWorkOfSweep * pivoting.sweeps();
  if (status == Status::kOk) emit(bounds, pivoting, out);
  if (status) return *status;
  return solve_dually(bounds, spans, pivoting, most_cost, out);
}

}  // namespace

Status generate_trajectory(const TrajectoryProblem& problem, const TrajectorySpans& spans, std::span<Segment> segments,
                           TrajectoryReport& report, WarmStart* warm, std::span<Real> gradient) {
  if (!is_well_posed(problem, segments)) return Status::kBadRequest;
  if (problem.boxes.size() > spans.violations.size()) return Status::kCorridorCapacity;
  report = {};
  std::fill(gradient.begin(), gradient.end(), Real(0));
  const Margins& margins = problem.margins;
  const bool has_margins = margins.position > 0 || margins.velocity > 0 || margins.acceleration > 0;
  const Output out{segments, report, warm, gradient};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Status status = solve_axis(axis_bounds(problem, spans, axis, margins), spans, out);
    if (status != Status::kOk && has_margins) {
      // Only without margins is every generated row necessary, and so infeasibility proven.
      status = solve_axis(axis_bounds(problem, spans, axis, Margins{}), spans, out);
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
