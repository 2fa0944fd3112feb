#include "swiftlet/min_jerk.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

constexpr Real kSqrt3 = Real(1.7320508075688772935);
constexpr Real kSqrt5 = Real(2.2360679774997896964);

// The jerk of a quintic in orthonormal Legendre polynomials over [0, 1], as rows over the end states: the integral of
// squared jerk is the sum of squares of these three numbers, over T^5.
constexpr std::array<std::array<Real, 6>, 3> kJerkRows{{
    {0, 0, -1, 0, 0, 1},
    {0, 2 * kSqrt3, kSqrt3, 0, -2 * kSqrt3, kSqrt3},
    {-12 * kSqrt5, -6 * kSqrt5, -kSqrt5, 12 * kSqrt5, -6 * kSqrt5, kSqrt5},
}};

// In float, the long floppy chains of relaxed corridors need a hold: each junction is drawn to the middle of its gate
// with this share of the stiffness that its two segments give it. Without it 10 of the 60 reference cases are lost in
// float; with it all are solved, the cost within 0.06 % of double. A tenth loses two cases, ten times as much costs 13
// %.
constexpr Real kHold = sizeof(Real) == 8 ? Real(0) : Real(4e-4);

Real gate_middle(const AxisProblem& problem, std::size_t junction) {
  return (problem.gate_lo(junction) + problem.gate_hi(junction)) / 2;
}

/// Constant end states of the whole trajectory, normalised by the duration of the segment they belong to.
std::array<Real, 3> normalised(const std::array<Real, 3>& state, Real T) {
  return {state[0], state[1] * T, state[2] * T * T};
}

/// Factors that turn the unknowns of a junction into normalised end states of a segment of duration T.
std::array<Real, 3> end_scales(const AxisProblem& problem, std::size_t junction, Real T) {
  const Real ratio = T / problem.scales[junction];
  return {1, ratio, ratio * ratio};
}

constexpr std::size_t kColumns = 2 * kBlockSize + 1;  // outer block, inner block, right-hand side
constexpr std::size_t kRhs = 2 * kBlockSize;
using Row = std::array<Real, kColumns>;

/// Rows over two neighbouring blocks, the inner one nearer to the middle of the chain: three carried over from the
/// outside, the three of the segment between the blocks and, in float, the hold of the outer one. The counts are fixed
/// so that the compiler can unroll.
constexpr std::size_t kCarried = kBlockSize;
constexpr std::size_t kHoldRow = kCarried + kBlockSize;
constexpr std::size_t kRows = kHoldRow + (kHold > 0 ? 1 : 0);
using Rows = std::array<Row, kRows>;

/// Householder reflection of rows kPivot to kRows that clears kColumn under kPivot and turns the columns up to kEnd and
/// the right-hand side.
template <std::size_t kPivot, std::size_t kColumn, std::size_t kEnd>
inline void reflect(Rows& rows) {
  std::array<Real, kRows> v{};
  Real norm2 = 0;
#pragma GCC unroll 8
  for (std::size_t i = kPivot; i < kRows; ++i) {
    v[i] = rows[i][kColumn];
    norm2 += v[i] * v[i];
  }
  if (!(norm2 > 0)) return;
  const Real head = v[kPivot];
  const Real alpha = head > 0 ? -std::sqrt(norm2) : std::sqrt(norm2);
  const Real scale = 1 / (norm2 - alpha * head);  // 2 / |v|^2 once the head is shifted
  v[kPivot] -= alpha;
  rows[kPivot][kColumn] = alpha;
#pragma GCC unroll 8
  for (std::size_t j = kColumn + 1; j < kColumns; ++j) {
    if (j >= kEnd && j < kRhs) continue;
    Real dot = 0;
#pragma GCC unroll 8
    for (std::size_t i = kPivot; i < kRows; ++i) dot += v[i] * rows[i][j];
    dot *= scale;
#pragma GCC unroll 8
    for (std::size_t i = kPivot; i < kRows; ++i) rows[i][j] -= dot * v[i];
  }
}

/// Makes the outer position a constant: its part moves to the right-hand side.
void substitute_position(Rows& rows, Real value) {
  for (Row& row : rows) {
    row[kRhs] -= row[0] * value;
    row[0] = 0;
  }
}

/// From which end of the chain the elimination comes.
enum class Side : std::uint8_t { kLeft, kRight };

/// Writes the three jerk rows of a segment over (outer junction, inner junction) behind the carried ones; a missing
/// junction is a constant.
void put_segment(const AxisProblem& problem, std::size_t segment, Side side, Rows& rows) {
  const Real T = problem.durations[segment];
  const Real weight = 1 / (T * T * std::sqrt(T));
  const bool first = segment == 0;
  const bool last = segment + 1 == problem.segment_count();
  const std::array<Real, 3> left = first ? normalised(problem.start, T) : end_scales(problem, segment - 1, T);
  const std::array<Real, 3> right = last ? normalised(problem.goal, T) : end_scales(problem, segment, T);
  const std::size_t left_at = side == Side::kLeft ? 0 : kBlockSize;
  const std::size_t right_at = kBlockSize - left_at;
  for (std::size_t i = 0; i < kBlockSize; ++i) {
    Row& row = rows[kCarried + i];
    row = {};
    for (std::size_t j = 0; j < kBlockSize; ++j) {
      const Real at_left = weight * kJerkRows[i][j] * left[j];
      const Real at_right = weight * kJerkRows[i][kBlockSize + j] * right[j];
      row[first ? kRhs : left_at + j] += first ? -at_left : at_left;
      row[last ? kRhs : right_at + j] += last ? -at_right : at_right;
    }
  }
}

/// Inverse of an upper triangle (row-major: 00 01 02 11 12 22).
std::array<Real, 6> inverse_triangle(const std::array<Real, 6>& d) {
  const Real i0 = 1 / d[0];
  const Real i1 = 1 / d[3];
  const Real i2 = 1 / d[5];
  const Real i01 = -d[1] * i0 * i1;
  return {i0, i01, -(d[2] * i0 + d[4] * i01) * i2, i1, -d[4] * i1 * i2, i2};
}

/// y = (upper triangle) x.
std::array<Real, 3> multiply(const std::array<Real, 6>& d, const std::array<Real, 3>& x) {
  return {d[0] * x[0] + d[1] * x[1] + d[2] * x[2], d[3] * x[1] + d[4] * x[2], d[5] * x[2]};
}

/// Row block k of the factor, [D | D E] and D c, from its rows (the first three): stores D^-1, E and c.
void store_block(const std::array<Row, kBlockSize>& rows, FactorBlock& block, Real* c) {
  block.inverse_diagonal = inverse_triangle({rows[0][0], rows[0][1], rows[0][2], rows[1][1], rows[1][2], rows[2][2]});
  for (std::size_t column = kBlockSize; column < kColumns; ++column) {
    const std::array<Real, 3> solved =
        multiply(block.inverse_diagonal, {rows[0][column], rows[1][column], rows[2][column]});
    for (std::size_t i = 0; i < kBlockSize; ++i) {
      (column == kRhs ? c[i] : block.coupling[kBlockSize * i + column - kBlockSize]) = solved[i];
    }
  }
}

/// The rows from kFirst on constrain the inner block alone: carries them over to its elimination.
template <std::size_t kFirst>
inline void carry_over(Rows& rows) {
  for (std::size_t i = 0; i < kCarried; ++i) {
    const Row& from = rows[kFirst + i];
    rows[i] = {from[3], from[4], from[5], 0, 0, 0, from[kRhs]};
  }
}

Real square(Real x) { return x * x; }

/// The same after kDone rows were used up: at most three of those left matter, the rest is residual, whose square is
/// returned.
template <std::size_t kDone>
inline Real reduce_and_carry_over(Rows& rows) {
  Real residual = 0;
  if constexpr (kRows - kDone > kCarried) {
    reflect<kDone, kBlockSize, kRhs>(rows);
    reflect<kDone + 1, kBlockSize + 1, kRhs>(rows);
    reflect<kDone + 2, kBlockSize + 2, kRhs>(rows);
    rows[kDone + 1][kBlockSize] = rows[kDone + 2][kBlockSize] = rows[kDone + 2][kBlockSize + 1] = 0;
    for (std::size_t i = kDone + kCarried; i < kRows; ++i) residual += square(rows[i][kRhs]);
  }
  carry_over<kDone>(rows);
  return residual;
}

/// The row that holds a junction near the middle of its gate.
[[maybe_unused]] Row hold_row(const AxisProblem& problem, std::size_t junction) {
  Real stiffness = 0;  // of a position between segments: 720 / T^5 each
  for (const std::size_t segment : {junction, junction + 1}) {
    const Real T = problem.durations[segment];
    stiffness += 720 / (T * T * T * T * T);
  }
  Row row{kHold * std::sqrt(stiffness)};
  row[kRhs] = row[0] * gate_middle(problem, junction);
  return row;
}

/// Eliminates a junction from the rows, whose outer block it is. A pinned position takes a row of its own, x =
/// constant, and none of theirs. Returns the cost that no junction can change any more.
Real eliminate_junction(const AxisProblem& problem, std::size_t k, Rows& rows, FactorBlock& block, Real* c) {
  if constexpr (kHold > 0) rows[kHoldRow] = hold_row(problem, k);
  if (is_pinned(problem, k)) {
    const Real position = gate_middle(problem, k);
    substitute_position(rows, position);
    reflect<0, 1, kRhs>(rows);
    reflect<1, 2, kRhs>(rows);
    store_block({Row{1, 0, 0, 0, 0, 0, position}, rows[0], rows[1]}, block, c);
    return reduce_and_carry_over<2>(rows);
  } else {
    reflect<0, 0, kRhs>(rows);
    reflect<1, 1, kRhs>(rows);
    reflect<2, 2, kRhs>(rows);
    store_block({rows[0], rows[1], rows[2]}, block, c);
    return reduce_and_carry_over<3>(rows);
  }
}

/// The rows that the segment at an end of the chain carries over to the junction next to it.
Rows end_rows(const AxisProblem& problem, std::size_t segment, Side side) {
  Rows rows{};
  put_segment(problem, segment, side, rows);
  carry_over<kCarried>(rows);
  return rows;
}

/// The cost of carried rows in which no unknown is left.
Real residual_of(const Rows& rows) {
  Real residual = 0;
  for (std::size_t i = 0; i < kCarried; ++i) residual += square(rows[i][kRhs]);
  return residual;
}

/// Turns c of junction k into its optimum, the inner neighbour's being known.
void settle_junction(const AxisProblem& problem, std::size_t k, std::size_t inner, std::span<FactorBlock> factor,
                     std::span<Real> optimum) {
  Real* x = &optimum[kBlockSize * k];
  const Real* y = &optimum[kBlockSize * inner];
  std::array<Real, 9>& e = factor[k].coupling;
  for (std::size_t i = 0; i < kBlockSize; ++i) x[i] -= e[3 * i] * y[0] + e[3 * i + 1] * y[1] + e[3 * i + 2] * y[2];
  // A pinned neighbour is a constant: it has shaped the optimum, but no step moves it.
  if (is_pinned(problem, inner)) e[0] = e[3] = e[6] = 0;
}

}  // namespace

void junction_scales(std::span<const Real> durations, std::span<Real> scales) {
  for (std::size_t k = 0; k + 1 < durations.size(); ++k) scales[k] = std::sqrt(durations[k] * durations[k + 1]);
}

Real factor_jerk_cost(const AxisProblem& problem, std::span<FactorBlock> factor, std::span<Real> optimum) {
  const std::size_t segments = problem.segment_count();
  const std::size_t junctions = segments - 1;
  Rows left = end_rows(problem, 0, Side::kLeft);
  if (junctions == 0) return residual_of(left);
  const std::size_t middle = middle_block(junctions);
  const auto unknowns = [&](std::size_t k) { return &optimum[kBlockSize * k]; };
  Real cost = 0;
  Rows right = end_rows(problem, segments - 1, Side::kRight);
  // In step, so that a processor may work on both halves at once; the left one is never the shorter.
  for (std::size_t k = 0; k < middle; ++k) {
    put_segment(problem, k + 1, Side::kLeft, left);
    cost += eliminate_junction(problem, k, left, factor[k], unknowns(k));
    const std::size_t r = junctions - 1 - k;
    if (r <= middle) continue;
    put_segment(problem, r, Side::kRight, right);
    cost += eliminate_junction(problem, r, right, factor[r], unknowns(r));
  }
  for (std::size_t i = 0; i < kCarried; ++i) left[kCarried + i] = right[i];
  cost += eliminate_junction(problem, middle, left, factor[middle], unknowns(middle));
  for (std::size_t distance = 1; distance <= middle; ++distance) {
    settle_junction(problem, middle - distance, middle - distance + 1, factor, optimum);
    if (middle + distance < junctions) {
      settle_junction(problem, middle + distance, middle + distance - 1, factor, optimum);
    }
  }
  return cost + residual_of(left);
}

QuinticEnds segment_ends(const AxisProblem& problem, std::size_t segment, std::span<const Real> unknowns) {
  const Real T = problem.durations[segment];
  QuinticEnds ends{};
  for (std::size_t side = 0; side < 2; ++side) {
    const bool constant = side == 0 ? segment == 0 : segment + 1 == problem.segment_count();
    const std::size_t junction = segment + side - 1;  // unused where constant
    const std::array<Real, 3> scale =
        constant ? normalised(side == 0 ? problem.start : problem.goal, T) : end_scales(problem, junction, T);
    for (std::size_t j = 0; j < kBlockSize; ++j) {
      ends[kBlockSize * side + j] = constant ? scale[j] : scale[j] * unknowns[kBlockSize * junction + j];
    }
  }
  return ends;
}

void unscale(const AxisProblem& problem, std::span<const Real> unknowns, std::span<Real> states) {
  for (std::size_t k = 0; k < problem.scales.size(); ++k) {
    const Real h = problem.scales[k];
    states[kBlockSize * k] = unknowns[kBlockSize * k];
    states[kBlockSize * k + 1] = unknowns[kBlockSize * k + 1] / h;
    states[kBlockSize * k + 2] = unknowns[kBlockSize * k + 2] / (h * h);
  }
}

QpRow extremum_row(const AxisProblem& problem, std::size_t segment, int derivative, Real tau, Real sign, Real bound) {
  const Real T = problem.durations[segment];
  Real unit = sign;
  for (int d = 0; d < derivative; ++d) unit /= T;
  const QuinticEnds basis = quintic_basis(derivative, tau);
  QpRow row;
  row.block = static_cast<std::uint32_t>(segment == 0 ? 0 : segment - 1);
  row.bound = sign * bound;
  for (std::size_t side = 0; side < 2; ++side) {
    const bool constant = side == 0 ? segment == 0 : segment + 1 == problem.segment_count();
    const std::size_t junction = segment + side - 1;
    const std::array<Real, 3> scale =
        constant ? normalised(side == 0 ? problem.start : problem.goal, T) : end_scales(problem, junction, T);
    for (std::size_t j = 0; j < kBlockSize; ++j) {
      const Real weight = unit * basis[kBlockSize * side + j] * scale[j];
      if (constant) {
        row.bound -= weight;
      } else if (j == 0 && is_pinned(problem, junction)) {
        row.bound -= weight * gate_middle(problem, junction);
      } else {
        row.coefficients[kBlockSize * (junction - row.block) + j] = weight;
      }
    }
  }
  return row;
}

QpRow gate_row(std::size_t junction, Real sign, Real bound) {
  QpRow row;
  row.block = static_cast<std::uint32_t>(junction);
  row.coefficients[0] = sign;
  row.bound = sign * bound;
  return row;
}

}  // namespace swiftlet
