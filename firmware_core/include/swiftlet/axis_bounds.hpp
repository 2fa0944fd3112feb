#pragma once
#include <cstdint>

#include "swiftlet/min_jerk.hpp"
#include "swiftlet/trajectory_generator.hpp"

namespace swiftlet {

/// Where a row comes from; its label carries it through a solver.
struct RowPlace {
  std::size_t place;   ///< segment, or junction of a gate
  std::uint32_t what;  ///< derivative, or kGate
  Real sign;
  Real tau;
};
inline constexpr std::uint32_t kGate = 3;

inline QpLabel to_label(const RowPlace& at) {
  return {static_cast<std::uint32_t>(at.place) << 3U | at.what << 1U | (at.sign > 0 ? 1U : 0U), at.tau};
}

inline RowPlace to_place(const QpLabel& label) {
  return {label.kind >> 3U, label.kind >> 1U & 3U, (label.kind & 1U) != 0 ? Real(1) : Real(-1), label.where};
}

/// Two rows of one kind on one segment this close together (in normalised time) hold one extremum between them. Adding
/// a third there would only halve the gap; the one row that stands for both lies at their multipliers' centre of
/// gravity, to second order in the gap.
inline constexpr Real kSameExtremum = Real(0.2);
inline bool holds_same_extremum(const QpLabel& a, const QpLabel& b) {
  return a.kind == b.kind && (a.where > b.where ? a.where - b.where : b.where - a.where) <= kSameExtremum;
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
  /// Where a row places its point: its margin inside the bound (eq. 10).
  [[nodiscard]] Real target(const RowPlace& at) const {
    const int derivative = static_cast<int>(at.what);
    return (at.sign > 0 ? upper(at.place, derivative) : lower(at.place, derivative)) - at.sign * margin(derivative);
  }
  [[nodiscard]] Real tolerance() const { return problem->effort.tolerance; }
};

/// Searches segments of one axis for violated bounds (Sec. IV-C).
class SegmentSweep {
 public:
  explicit SegmentSweep(const AxisBounds& bounds);

  /// True when a segment with the given end states exceeds a bound; `violation` receives the one that it exceeds most,
  /// relative to the bound's own scale. Junctions count once, with the segment on their right.
  bool find_worst(std::size_t segment, const QuinticEnds& ends, Violation& violation) const {
    const std::array<bool, 3> suspect = suspects(segment, ends);
    return (suspect[0] || suspect[1] || suspect[2]) && find_worst_of(suspect, segment, ends, violation);
  }

 private:
  /// The derivatives whose Bernstein control points leave their bounds; the others surely keep them, as most do.
  [[nodiscard]] std::array<bool, 3> suspects(std::size_t segment, const QuinticEnds& ends) const;
  bool find_worst_of(const std::array<bool, 3>& suspect, std::size_t segment, const QuinticEnds& ends,
                     Violation& violation) const;

  const AxisBounds& bounds_;
  std::array<Real, 2> largest_difference_;  // of control points of v and a, in a segment of one second
};

}  // namespace swiftlet
