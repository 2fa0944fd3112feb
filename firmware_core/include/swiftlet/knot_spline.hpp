#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "swiftlet/dual_active_set.hpp"
#include "swiftlet/quintic.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// The minimum-jerk curve of one axis (eq. 6) through knots: junctions that are held, or at the ends of a segment in
/// which a row is active. At every other junction nothing acts, so the optimum runs through it as the same quintic, and
/// it is no unknown: what is left of the chain of M segments is as long as the active set. Between two knots the cost
/// is that of eq. 8; position, velocity and acceleration are continuous.

struct Knot {
  Real position = 0;  ///< [m] where held
  std::uint32_t junction = 0;
  bool held = false;  ///< at `position`; otherwise the position is an unknown
};

/// What lies between a knot and the next one, or an end of the trajectory.
struct KnotSpan {
  Real duration = 0;            ///< [s]
  Real rate = 0;                ///< 1 / duration
  std::uint32_t first_row = 0;  ///< rows act on spans of one segment alone
  std::uint32_t row_count = 0;  ///< at most kMostSpanRows
};
inline constexpr std::size_t kMostSpanRows = 4;

/// n' (left state, right state) = bound over the states (p [m], v [m/s], a [m/s^2]) at the two ends of one span.
struct KnotRow {
  QpLabel label;
  Real multiplier = 0;
  bool released = false;  ///< block_pivoting.hpp is about to remove it
  std::array<Real, 2 * kBlockSize> n{};
  Real bound = 0;
  // What the elimination leaves for the way back: the part of the outer knot's state that follows the multiplier, and
  // the multiplier as a function of the inner knot's state and of the multipliers of the next span inwards.
  std::array<Real, kBlockSize> follows{};
  Real multiplier_alone = 0;
  std::array<Real, kBlockSize> by_state{};
  std::array<Real, kMostSpanRows> by_row{};
};

/// Rows that the elimination carries to the next knot inwards: N x - W u = b, u their multipliers.
struct CarriedRows {
  static constexpr std::size_t kMost = 2 * kMostSpanRows;  // where both halves meet
  std::size_t count;
  std::array<std::size_t, kMost> row;
  std::array<std::array<Real, kBlockSize>, kMost> n;
  std::array<std::array<Real, kMost>, kMost> w;
  std::array<Real, kMost> b;
  std::array<Real, kMost> length2;  ///< of the part over knots that are eliminated, in the metric of the inverse cost
};

/// Row-major: what an outer knot's state takes from its inner neighbour's.
using KnotCoupling = std::array<Real, kBlockSize * kBlockSize>;

struct KnotSpline {
  std::array<Real, kBlockSize> start;  ///< p [m], v [m/s], a [m/s^2]
  std::array<Real, kBlockSize> goal;
  std::span<const Knot> knots;      ///< K, in order of time
  std::span<const KnotSpan> spans;  ///< K + 1
  std::span<KnotRow> rows;          ///< in order of time; receive their multipliers (of half the cost)
  std::span<Real> states;           ///< 3 K: receives p, v, a at each knot
  // work space
  std::span<KnotCoupling> coupling;     ///< K
  std::span<CarriedRows> carried_rows;  ///< 2: of either half
};

/// Solves the equality-constrained problem by block elimination from both ends to the middle, O(K): each knot is taken
/// out of the normal equations together with the multipliers of the rows on its outer side, whose pivots are negative
/// definite by then. False when rows depend on each other, or nearly.
[[nodiscard]] bool solve_knot_spline(const KnotSpline& spline);

/// What keeps a junction's position where it is.
enum class Hold : std::uint8_t { kNone, kLow, kHigh, kPinned };

/// Work space of block_pivoting.hpp for up to M segments and R rows.
struct PivotingSpans {
  std::span<Hold> hold;                 ///< M
  std::span<Real> lo;                   ///< M [m]: the gates
  std::span<Real> hi;                   ///< M [m]
  std::span<Real> excess;               ///< M [m] over the gates
  std::span<Real> pull;                 ///< M, of the knots
  std::span<Knot> knots;                ///< M
  std::span<KnotSpan> spans;            ///< M
  std::span<KnotRow> rows;              ///< R
  std::span<Real> knot_states;          ///< 3 M
  std::span<KnotCoupling> coupling;     ///< M
  std::span<CarriedRows> carried_rows;  ///< 2
};

/// End states of span `k`, normalised by its duration.
inline QuinticEnds span_ends(const KnotSpline& spline, std::size_t k) {
  const Real T = spline.spans[k].duration;
  const Real* left = k == 0 ? spline.start.data() : &spline.states[kBlockSize * (k - 1)];
  const Real* right = k == spline.knots.size() ? spline.goal.data() : &spline.states[kBlockSize * k];
  return {left[0], left[1] * T, left[2] * T * T, right[0], right[1] * T, right[2] * T * T};
}

}  // namespace swiftlet
