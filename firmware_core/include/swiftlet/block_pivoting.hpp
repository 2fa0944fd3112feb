#pragma once
#include <cstdint>
#include <optional>
#include <span>

#include "swiftlet/axis_bounds.hpp"
#include "swiftlet/knot_spline.hpp"

namespace swiftlet {

/// Finds the active set of one axis by block pivoting: solve with the set as equalities, let go what pulls, hold what
/// is violated, and again. Each sweep solves a spline through its knots alone (knot_spline.hpp), O(active set), and
/// evaluates the junctions, O(M). Gates pivot first; once they are settled, segments are searched for violating extrema
/// (Sec. IV-C). Changes of one neighbourhood depend on each other, so in each only the worst changes. A settled set has
/// no negative multiplier, so its cost is a lower bound of the optimum; it must rise from one settled set to the next,
/// which rules out cycles.
///
/// It proves nothing but its own answer: a set that no longer changes satisfies the optimality conditions. When it does
/// not get there, the dual active-set method decides, from the last set.
class BlockPivoting {
 public:
  /// At most `most_sweeps` sweeps; more cost than `most_cost` [m^2/s^5] ends the search.
  BlockPivoting(const AxisBounds& bounds, const TrajectorySpans& spans, std::uint32_t most_sweeps, Real most_cost);

  /// `labels`: rows to start from. kOk: optimal. kIterationLimit: it costs more than `most_cost`. Nothing: undecided.
  std::optional<Status> run(std::span<const QpLabel> labels);

  [[nodiscard]] Real cost() const { return cost_; }  ///< [m^2/s^5]
  [[nodiscard]] std::uint32_t sweeps() const { return sweeps_; }
  [[nodiscard]] std::uint32_t rows_added() const { return rows_added_; }
  [[nodiscard]] std::size_t active_count() const;
  /// Largest distance of an active row from its bound.
  [[nodiscard]] Real residual() const;
  /// States (p [m], v [m/s], a [m/s^2]) at the M - 1 junctions.
  [[nodiscard]] std::span<const Real> states() const { return states_.first(kBlockSize * junctions_); }
  /// `visit(label, multiplier)` for each active row.
  template <class Visit>
  void for_each_active(const Visit& visit) const {
    for (std::uint32_t j = 0; j < junctions_; ++j) {
      if (is_on_bound(j)) visit(to_label({j, kGate, spans_.hold[j] == Hold::kHigh ? Real(1) : Real(-1), 0}), Real(0));
    }
    for (const KnotRow& row : spans_.rows.first(row_count_)) visit(row.label, row.multiplier);
  }

 private:
  bool is_on_bound(std::size_t junction) const {
    return spans_.hold[junction] == Hold::kLow || spans_.hold[junction] == Hold::kHigh;
  }
  [[nodiscard]] Real held_position(std::size_t junction) const;
  void start_from(std::span<const QpLabel> labels);
  void insert_row(const QpLabel& label);
  void remove_row(std::size_t row);
  void write_row(KnotRow& row) const;
  bool collect_knots();
  void read_junctions();
  [[nodiscard]] Real pull_of_rows(std::size_t knot) const;
  bool release();
  [[nodiscard]] bool waits_for_a_gate(const KnotRow& row, std::span<const Real> pull) const;
  [[nodiscard]] bool waits_for_a_row(std::size_t row) const;
  [[nodiscard]] Real scaled_multiplier(const KnotRow& row) const;
  bool hold_gates();
  void read_states();
  std::optional<std::uint32_t> add_rows();
  bool add_row(const Violation& violation);
  void release_beside(const Violation& violation);

  const AxisBounds& bounds_;
  PivotingSpans spans_;
  std::span<Real> states_;
  std::span<Violation> violations_;
  KnotSpline spline_;
  std::size_t junctions_;
  std::size_t row_count_ = 0;
  std::uint32_t most_sweeps_;
  std::uint32_t sweeps_ = 0;
  std::uint32_t rows_added_ = 0;
  Real most_cost_;
  Real cost_ = -1;  // of the last settled set
};

}  // namespace swiftlet
