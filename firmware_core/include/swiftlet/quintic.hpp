#pragma once
#include <array>
#include <cstddef>

#include "swiftlet/types.hpp"

namespace swiftlet {

/// One axis of one segment in normalised time tau = t / T, 0 <= tau <= 1 (eq. 5 with N = 5, in the end-derivative form
/// of eq. 8).

/// End states (p0, v0 T, a0 T^2, p1, v1 T, a1 T^2), all in metres.
using QuinticEnds = std::array<Real, 6>;
/// Coefficients of tau^0 ... tau^5 [m].
using Quintic = std::array<Real, 6>;

/// The quintic with the given end states.
inline Quintic quintic_from_ends(const QuinticEnds& ends) {
  const Real dp = ends[3] - ends[0] - ends[1] - ends[2] / 2;
  const Real dv = ends[4] - ends[1] - ends[2];
  const Real da = ends[5] - ends[2];
  return {ends[0], ends[1], ends[2] / 2, 10 * dp - 4 * dv + da / 2, -15 * dp + 7 * dv - da, 6 * dp - 3 * dv + da / 2};
}

/// Weights w such that the `derivative`-th tau-derivative (0 to 2) at `tau` is sum_k w[k] ends[k].
QuinticEnds quintic_basis(int derivative, Real tau);

/// Bernstein control points: the quintic lies in their hull.
inline std::array<Real, 6> quintic_control_points(const QuinticEnds& ends) {
  constexpr Real kFifth = Real(0.2);
  constexpr Real kTwentieth = Real(0.05);
  const Real left = kFifth * ends[1];
  const Real right = kFifth * ends[4];
  return {ends[0],
          ends[0] + left,
          ends[0] + 2 * left + kTwentieth * ends[2],
          ends[3] - 2 * right + kTwentieth * ends[5],
          ends[3] - right,
          ends[3]};
}

/// The `derivative`-th tau-derivative at `tau`.
Real quintic_value(const Quintic& quintic, int derivative, Real tau);

/// Points where the `derivative`-th derivative (0 to 2) may take its extreme values inside the segment: the roots of
/// the next derivative in [0, 1], ascending; `count` of them, at most four.
struct CriticalPoints {
  std::array<Real, 4> tau{};
  std::size_t count = 0;
};
CriticalPoints critical_points(const Quintic& quintic, int derivative);

}  // namespace swiftlet
