#pragma once
#include <array>
#include <cstddef>
#include <span>

#include "swiftlet/types.hpp"

namespace swiftlet {

inline constexpr std::size_t kQuinticTerms = 6;

/// One polynomial piece: p(t) = sum_j coefficients[axis][j] t^j [m], 0 <= t <= duration [s] (eq. 5 with N = 5).
struct Segment {
  Real duration = 0;
  std::array<std::array<Real, kQuinticTerms>, 3> coefficients{};
};

/// A point of a trajectory in frame W: [m] [m/s] [m/s^2] [m/s^3].
struct Sample {
  Vector3 position;
  Vector3 velocity;
  Vector3 acceleration;
  Vector3 jerk;
};

/// State of one segment at local time t [s], by Horner's rule on the coefficients as they stand.
Sample sample_segment(const Segment& segment, Real t);

/// State at time t [s] from the start; clamped to the ends. `segments` must not be empty. Cost O(M).
Sample sample_trajectory(std::span<const Segment> segments, Real t);

/// Sum of the segment durations, first to last [s].
Real total_duration(std::span<const Segment> segments);

/// Integral of squared jerk of one axis over the whole trajectory [m^2/s^5] (eq. 6), exact in the coefficients.
Real jerk_cost(std::span<const Segment> segments, std::size_t axis);

/// Arc length [m], to 1e-4 of itself: Gauss-Legendre on 16 pieces a segment. Cost O(M).
Real arc_length(std::span<const Segment> segments);

}  // namespace swiftlet
