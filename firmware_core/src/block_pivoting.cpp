#include "swiftlet/block_pivoting.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

// Changes close to each other depend on each other, so of gates violated within this many junctions the worst is held,
// and of gates on neighbouring knots, or rows of neighbouring segments, that pull the strongest lets go. A row waits
// while a gate pulls within this many knots: the gate is nearly always the one that the row has replaced. Measured over
// 5 to 320 segments.
constexpr std::size_t kHoldRadius = 2;
constexpr std::size_t kReleaseRadius = 1;
constexpr std::size_t kRowRadius = 4;

std::uint32_t segment_of(const KnotRow& row) { return static_cast<std::uint32_t>(to_place(row.label).place); }

/// values[i] where it exists.
Real at_or_zero(std::span<const Real> values, std::size_t i) { return i < values.size() ? values[i] : Real(0); }

/// No other value within the radius is as far from zero; the first of equals counts.
bool is_worst(std::span<const Real> values, std::size_t i, std::size_t radius) {
  const Real own = std::fabs(values[i]);
  for (std::size_t d = 1; d <= radius; ++d) {
    if (std::fabs(at_or_zero(values, i - d)) >= own || std::fabs(at_or_zero(values, i + d)) > own) return false;
  }
  return true;
}

/// How far p is above the interval, or (negative) below it.
Real excess_over(Real p, Real lo, Real hi) { return std::max(p - hi, Real(0)) + std::min(p - lo, Real(0)); }

Real position(const Quintic& c, Real tau) {
  return c[0] + tau * (c[1] + tau * (c[2] + tau * (c[3] + tau * (c[4] + tau * c[5]))));
}

Real fifth_power(Real x) {
  const Real x2 = x * x;
  return x2 * x2 * x;
}

/// The jerk cost of all spans.
Real spline_cost(const KnotSpline& spline) {
  Real sum = 0;
  for (std::size_t k = 0; k < spline.spans.size(); ++k) {
    const Quintic c = quintic_from_ends(span_ends(spline, k));
    const Real integral = 36 * c[3] * c[3] + 144 * c[3] * c[4] + 192 * c[4] * c[4] + 240 * c[3] * c[5] +
                          720 * c[4] * c[5] + 720 * c[5] * c[5];
    sum += integral * fifth_power(spline.spans[k].rate);
  }
  return sum;
}

}  // namespace

BlockPivoting::BlockPivoting(const AxisBounds& bounds, const TrajectorySpans& spans, std::uint32_t most_sweeps,
                             Real most_cost)
    : bounds_(bounds),
      spans_(spans.pivoting),
      states_(spans.states),
      violations_(spans.violations),
      spline_{bounds.axis.start, bounds.axis.goal,   {}, {}, {}, spans_.knot_states,
              spans_.coupling,   spans_.carried_rows},
      junctions_(bounds.axis.segment_count() - 1),
      most_sweeps_(most_sweeps),
      most_cost_(most_cost) {
  for (std::size_t j = 0; j < junctions_; ++j) {
    spans_.lo[j] = bounds.axis.gate_lo(j);
    spans_.hi[j] = bounds.axis.gate_hi(j);
    spans_.hold[j] = is_pinned(bounds.axis, j) ? Hold::kPinned : Hold::kNone;
  }
}

std::optional<Status> BlockPivoting::run(std::span<const QpLabel> labels) {
  start_from(labels);
  while (sweeps_ < most_sweeps_) {
    ++sweeps_;
    if (!collect_knots() || !solve_knot_spline(spline_)) return {};
    read_junctions();
    const bool released = release();
    if (hold_gates() || released) continue;
    const Real settled_cost = spline_cost(spline_);
    if (!(settled_cost > cost_)) return {};
    cost_ = settled_cost;
    if (cost_ > most_cost_) return Status::kIterationLimit;
    read_states();
    const std::size_t before = row_count_;
    const std::optional<std::uint32_t> added = add_rows();
    if (!added) return {};
    if (*added == 0) return Status::kOk;
    if (row_count_ < before + *added) cost_ = -1;  // one row in place of two may cost less
  }
  return {};
}

void BlockPivoting::start_from(std::span<const QpLabel> labels) {
  for (const QpLabel& label : labels) {
    const RowPlace at = to_place(label);
    if (at.what != kGate) {
      if (row_count_ < spans_.rows.size()) insert_row(label);
    } else if (spans_.hold[at.place] == Hold::kNone) {
      spans_.hold[at.place] = at.sign > 0 ? Hold::kHigh : Hold::kLow;
    }
  }
}

Real BlockPivoting::held_position(std::size_t junction) const {
  const Real lo = spans_.lo[junction];
  const Real hi = spans_.hi[junction];
  return spans_.hold[junction] == Hold::kPinned ? (lo + hi) / 2 : spans_.hold[junction] == Hold::kHigh ? hi : lo;
}

/// Rows stay in the order of their segments.
void BlockPivoting::insert_row(const QpLabel& label) {
  KnotRow row;
  row.label = label;
  write_row(row);
  std::size_t place = row_count_++;
  for (; place > 0 && segment_of(spans_.rows[place - 1]) > segment_of(row); --place) {
    spans_.rows[place] = spans_.rows[place - 1];
  }
  spans_.rows[place] = row;
}

void BlockPivoting::remove_row(std::size_t row) {
  --row_count_;
  for (; row < row_count_; ++row) spans_.rows[row] = spans_.rows[row + 1];
}

/// Eq. 9, 10, 14, 15 over the end states of the row's segment.
void BlockPivoting::write_row(KnotRow& row) const {
  const RowPlace at = to_place(row.label);
  const Real T = bounds_.axis.durations[at.place];
  const QuinticEnds basis = quintic_basis(static_cast<int>(at.what), at.tau);
  Real unit = at.sign;
  for (std::uint32_t d = 0; d < at.what; ++d) unit /= T;
  for (std::size_t i = 0; i < kBlockSize; ++i) {
    row.n[i] = unit * basis[i];
    row.n[kBlockSize + i] = unit * basis[kBlockSize + i];
    unit *= T;
  }
  row.bound = at.sign * bounds_.target(at);
}

/// Knots where a junction is held or its segment has a row. False when a segment has more rows than a span may.
bool BlockPivoting::collect_knots() {
  std::uint32_t row = 0;
  const auto row_segment = [&] { return row < row_count_ ? segment_of(spans_.rows[row]) : ~std::uint32_t{0}; };
  std::uint32_t next_segment = row_segment();
  Real duration = 0;
  std::size_t count = 0;
  for (std::uint32_t j = 0; j <= junctions_; ++j) {
    duration += bounds_.axis.durations[j];
    const std::uint32_t first = row;
    for (; next_segment == j; next_segment = row_segment()) ++row;
    if (row - first > kMostSpanRows) return false;
    if (j < junctions_) {
      const bool held = spans_.hold[j] != Hold::kNone;
      if (!held && row == first && next_segment != j + 1) continue;
      spans_.knots[count] = {held ? held_position(j) : Real(0), j, held};
    }
    spans_.spans[count++] = {duration, 1 / duration, first, row - first};
    duration = 0;
  }
  spline_.knots = spans_.knots.first(count - 1);
  spline_.spans = spans_.spans.first(count);
  spline_.rows = spans_.rows.first(row_count_);
  return true;
}

/// Excess of each junction over its gate, 0 where it is held; and of each knot on a gate how hard it pulls away from
/// it, as its multiplier where that is negative. The derivative of half the cost by its position is the jump of the
/// fifth derivative there; the rows beside it add their part.
void BlockPivoting::read_junctions() {
  std::size_t j = 0;
  Real before = 0;
  const std::size_t count = spline_.knots.size();
  for (std::size_t k = 0; k <= count; ++k) {
    const Quintic c = quintic_from_ends(span_ends(spline_, k));
    const Real rate = spline_.spans[k].rate;
    const Real crackle = 120 * c[5] * fifth_power(rate);
    if (k > 0) {
      const std::size_t q = spline_.knots[k - 1].junction;
      const Real slope = before - crackle + pull_of_rows(k - 1);
      spans_.pull[k - 1] = std::min(spans_.hold[q] == Hold::kHigh  ? -slope
                                    : spans_.hold[q] == Hold::kLow ? slope
                                                                   : Real(0),
                                    Real(0));
    }
    before = crackle;
    const std::size_t end = k < count ? spline_.knots[k].junction : junctions_;
    Real t = 0;
    for (; j < end; ++j) {
      t += bounds_.axis.durations[j];
      const Real p = position(c, t * rate);
      spans_.excess[j] = excess_over(p, spans_.lo[j], spans_.hi[j]);
    }
    if (k == count) break;
    spans_.excess[j] =
        spline_.knots[k].held ? Real(0) : excess_over(spline_.states[kBlockSize * k], spans_.lo[j], spans_.hi[j]);
    ++j;
  }
}

/// The derivative of the rows beside a knot, weighted, by its position.
Real BlockPivoting::pull_of_rows(std::size_t knot) const {
  Real pull = 0;
  for (std::size_t side = 0; side < 2; ++side) {
    const KnotSpan& span = spline_.spans[knot + side];
    for (const KnotRow& row : spline_.rows.subspan(span.first_row, span.row_count)) {
      pull += row.multiplier * row.n[side == 0 ? kBlockSize : 0];
    }
  }
  return pull;
}

/// Lets go of the gates and rows that pull. True when there were any.
bool BlockPivoting::release() {
  bool changed = false;
  const std::span<const Real> pull = spans_.pull.first(spline_.knots.size());
  for (std::size_t i = 0; i < row_count_; ++i) {
    KnotRow& row = spans_.rows[i];
    row.released = row.multiplier < 0 && !waits_for_a_gate(row, pull) && !waits_for_a_row(i);
    changed = changed || row.multiplier < 0;
  }
  for (std::size_t i = row_count_; i-- > 0;) {
    if (spans_.rows[i].released) remove_row(i);
  }
  for (std::size_t k = 0; k < pull.size(); ++k) {
    if (!(pull[k] < 0) || !is_worst(pull, k, kReleaseRadius)) continue;
    spans_.hold[spline_.knots[k].junction] = Hold::kNone;
    changed = true;
  }
  return changed;
}

/// A gate near the row pulls.
bool BlockPivoting::waits_for_a_gate(const KnotRow& row, std::span<const Real> pull) const {
  std::size_t right = 0;  // knot at the right end of the row's segment
  while (right < pull.size() && spline_.knots[right].junction < segment_of(row)) ++right;
  for (std::size_t k = right - kRowRadius; k != right + kRowRadius; ++k) {
    if (at_or_zero(pull, k) < 0) return true;
  }
  return false;
}

/// A row of the same segment or a neighbouring one pulls harder.
bool BlockPivoting::waits_for_a_row(std::size_t row) const {
  const std::uint32_t segment = segment_of(spans_.rows[row]);
  const Real own = scaled_multiplier(spans_.rows[row]);
  for (const KnotRow& other : spans_.rows.first(row_count_)) {
    const std::uint32_t at = segment_of(other);
    if (at + 1 >= segment && at <= segment + 1 && scaled_multiplier(other) < own) return true;
  }
  return false;
}

/// The multiplier over bounds as parts of their own size.
Real BlockPivoting::scaled_multiplier(const KnotRow& row) const {
  const RowPlace at = to_place(row.label);
  return at.what == 0 ? row.multiplier : row.multiplier * bounds_.upper(at.place, static_cast<int>(at.what));
}

/// Holds the gates that are violated. True when there were any.
bool BlockPivoting::hold_gates() {
  bool changed = false;
  const std::span<const Real> excess = spans_.excess.first(junctions_);
  for (std::size_t j = 0; j < junctions_; ++j) {
    if (std::fabs(excess[j]) <= bounds_.tolerance() || !is_worst(excess, j, kHoldRadius)) continue;
    spans_.hold[j] = excess[j] > 0 ? Hold::kHigh : Hold::kLow;
    ++rows_added_;
    changed = true;
  }
  return changed;
}

/// The states at all junctions, from those at the knots.
void BlockPivoting::read_states() {
  std::size_t j = 0;
  const std::size_t count = spline_.knots.size();
  for (std::size_t k = 0; k <= count; ++k) {
    const Quintic c = quintic_from_ends(span_ends(spline_, k));
    const Real rate = spline_.spans[k].rate;
    const std::size_t end = k < count ? spline_.knots[k].junction : junctions_;
    Real t = 0;
    for (; j < end; ++j) {
      t += bounds_.axis.durations[j];
      const Real tau = t * rate;
      states_[kBlockSize * j] = position(c, tau);
      states_[kBlockSize * j + 1] =
          rate * (c[1] + tau * (2 * c[2] + tau * (3 * c[3] + tau * (4 * c[4] + tau * 5 * c[5]))));
      states_[kBlockSize * j + 2] = rate * rate * (2 * c[2] + tau * (6 * c[3] + tau * (12 * c[4] + tau * 20 * c[5])));
    }
    if (k == count) break;
    std::copy_n(&spline_.states[kBlockSize * k], kBlockSize, &states_[kBlockSize * j]);
    ++j;
  }
}

/// Rows at the violating extrema of segments worse than their neighbours; how many, or nothing when there is no room.
std::optional<std::uint32_t> BlockPivoting::add_rows() {
  const SegmentSweep sweep(bounds_);
  std::size_t count = 0;
  for (std::size_t i = 0; i <= junctions_; ++i) {
    if (sweep.find_worst(i, state_ends(bounds_.axis, i, states_), violations_[count])) ++count;
  }
  std::uint32_t added = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Violation& own = violations_[i];
    if (i > 0 && violations_[i - 1].segment + 1 == own.segment && violations_[i - 1].excess >= own.excess) continue;
    if (i + 1 < count && violations_[i + 1].segment == own.segment + 1 && violations_[i + 1].excess > own.excess)
      continue;
    ++added;
    if (!add_row(own)) return {};
  }
  rows_added_ += added;
  return added;
}

/// A row at the extremum, or one that stands for it and the two that hold it already. False when there is no room.
bool BlockPivoting::add_row(const Violation& violation) {
  const QpLabel label = to_label({violation.segment, violation.derivative, violation.sign, violation.tau});
  std::size_t count = 0;
  std::array<std::size_t, 2> same{};
  for (std::size_t i = 0; i < row_count_; ++i) {
    if (!holds_same_extremum(spans_.rows[i].label, label)) continue;
    if (count < same.size()) same[count] = i;
    ++count;
  }
  if (count < 2) {
    if (row_count_ == spans_.rows.size()) return false;
    insert_row(label);
    if (violation.derivative == 0) release_beside(violation);
    return true;
  }
  KnotRow& kept = spans_.rows[same[0]];
  const KnotRow& other = spans_.rows[same[1]];
  const Real weight = kept.multiplier + other.multiplier;
  kept.label.where =
      weight > 0 ? (kept.multiplier * kept.label.where + other.multiplier * other.label.where) / weight : label.where;
  write_row(kept);
  remove_row(same[1]);
  return true;
}

/// A curve that runs into a bound at a gate leaves it beside the gate: the row there replaces the gate.
void BlockPivoting::release_beside(const Violation& violation) {
  const Hold side = violation.sign > 0 ? Hold::kHigh : Hold::kLow;
  for (const std::size_t junction : {std::size_t{violation.segment} - 1, std::size_t{violation.segment}}) {
    if (junction < junctions_ && spans_.hold[junction] == side) spans_.hold[junction] = Hold::kNone;
  }
}

std::size_t BlockPivoting::active_count() const {
  std::size_t count = row_count_;
  for (std::size_t j = 0; j < junctions_; ++j) count += is_on_bound(j) ? 1 : 0;
  return count;
}

Real BlockPivoting::residual() const {
  Real largest = 0;
  for (const KnotRow& row : spline_.rows) {
    const QuinticEnds ends = state_ends(bounds_.axis, segment_of(row), states());
    const Real T = bounds_.axis.durations[segment_of(row)];
    Real value = -row.bound;
    Real unit = 1;
    for (std::size_t i = 0; i < kBlockSize; ++i) {
      value += unit * (row.n[i] * ends[i] + row.n[kBlockSize + i] * ends[kBlockSize + i]);
      unit /= T;
    }
    largest = std::max(largest, std::fabs(value));
  }
  return largest;
}

}  // namespace swiftlet
