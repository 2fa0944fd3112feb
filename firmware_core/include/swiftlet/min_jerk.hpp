#pragma once
#include <array>
#include <cstddef>
#include <span>

#include "swiftlet/dual_active_set.hpp"
#include "swiftlet/quintic.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// One axis of the minimum-jerk problem (eq. 6) in end-derivative form (eq. 8) with continuity built in: the unknowns
/// are the states at the M - 1 junctions, scaled to lengths, x_k = (p, h v, h^2 a) with h_k the geometric mean of the
/// two adjacent durations. Start and goal states are constants, and so are positions in thin gates.
struct AxisProblem {
  std::size_t axis = 0;
  std::span<const Real> durations;  ///< M [s]
  std::span<const Real> scales;     ///< M - 1 [s]: h_k, as junction_scales fills them
  std::span<const Box> gates;       ///< M - 1 [m], frame W
  std::array<Real, 3> start{};      ///< p - reference [m], v [m/s], a [m/s^2]
  std::array<Real, 3> goal{};
  Real reference = 0;  ///< [m] subtracted from every position, so that float keeps its digits

  [[nodiscard]] std::size_t segment_count() const { return durations.size(); }
  [[nodiscard]] Real gate_lo(std::size_t k) const { return gates[k].lo[static_cast<Eigen::Index>(axis)] - reference; }
  [[nodiscard]] Real gate_hi(std::size_t k) const { return gates[k].hi[static_cast<Eigen::Index>(axis)] - reference; }
};

/// h_k = sqrt(T_k T_{k+1}) for the M - 1 junctions between M durations.
void junction_scales(std::span<const Real> durations, std::span<Real> scales);

/// A gate this thin on an axis pins the junction to its middle [m].
inline constexpr Real kThinGate = Real(1e-9);
inline bool is_pinned(const AxisProblem& problem, std::size_t junction) {
  return problem.gate_hi(junction) - problem.gate_lo(junction) <= kThinGate;
}

/// Factors the jerk cost as |R x - c|^2 by orthogonal elimination over the chain of segments, from both ends to the
/// middle: the three Legendre coefficients of each segment's jerk are its rows, so R carries the square root of the
/// Hessian's condition. In
/// float a weak hold draws each junction to the middle of its gate (kHold in the source says what it costs). Cost O(M).
///   factor   receives M - 1 blocks of R = D U
///   optimum  receives the 3 (M - 1) unknowns of the unconstrained optimum
/// Returns the cost there [m^2/s^5].
Real factor_jerk_cost(const AxisProblem& problem, std::span<FactorBlock> factor, std::span<Real> optimum);

/// End states of one segment (normalised by its duration), read from the unknowns.
QuinticEnds segment_ends(const AxisProblem& problem, std::size_t segment, std::span<const Real> unknowns);

/// The same, read from the states (p, v [m/s], a [m/s^2]) at the junctions.
inline QuinticEnds state_ends(const AxisProblem& problem, std::size_t segment, std::span<const Real> states) {
  const Real T = problem.durations[segment];
  const Real* left = segment == 0 ? problem.start.data() : &states[kBlockSize * (segment - 1)];
  const Real* right = segment + 1 == problem.segment_count() ? problem.goal.data() : &states[kBlockSize * segment];
  return {left[0], left[1] * T, left[2] * T * T, right[0], right[1] * T, right[2] * T * T};
}

/// States of the junctions from the unknowns.
void unscale(const AxisProblem& problem, std::span<const Real> unknowns, std::span<Real> states);

/// The row sign * (derivative 0 to 2 of segment `segment` at normalised time `tau`) <= sign * bound (eq. 10).
/// `bound` is relative to the reference for positions.
QpRow extremum_row(const AxisProblem& problem, std::size_t segment, int derivative, Real tau, Real sign, Real bound);

/// The row sign * (position of junction `junction`) <= sign * bound (eq. 9, 14, 15).
QpRow gate_row(std::size_t junction, Real sign, Real bound);

}  // namespace swiftlet
