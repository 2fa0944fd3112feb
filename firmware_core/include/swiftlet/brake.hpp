#pragma once
#include <limits>
#include <span>

#include "swiftlet/trajectory.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// What a brake must keep, besides the path itself: the limits that the trajectory's certificate was issued for.
/// Speeds need none, a brake only lowers them. Infinity stands for no limit.
struct BrakeLimits {
  Vector3 a_max = Vector3::Constant(std::numeric_limits<Real>::infinity());  ///< [m/s^2] per axis
  Real acceleration_norm_max = std::numeric_limits<Real>::infinity();        ///< [m/s^2] Euclidean
  Real jerk_norm_max = std::numeric_limits<Real>::infinity();                ///< [m/s^3] Euclidean
};

/// A slow-down of path time s: it runs at rate r = 1 for `delay`, then r falls to 0 over `duration` as 1 minus the
/// quintic smoothstep, so acceleration and jerk stay continuous; from then on s rests. Positions are those of the
/// trajectory, hence inside its corridor.
struct BrakeProfile {
  Real from = 0;      ///< [s] path time at the start
  Real delay = 0;     ///< [s] >= 0
  Real duration = 0;  ///< [s] >= 0; 0: r never falls, the trajectory is flown to its end
};

/// Path time and its derivatives by time: [s] [-] [1/s] [1/s^2].
struct PathTime {
  Real s = 0;
  Real rate = 1;
  Real rate1 = 0;
  Real rate2 = 0;
};

/// Path time `t` [s] >= 0 after the start of the brake.
PathTime path_time(const BrakeProfile& profile, Real t);

/// The sample of a trajectory at path time `time.s`, as seen at clock time: v = p' r, a = p'' r^2 + p' r1,
/// j = p''' r^3 + 3 p'' r r1 + p' r2.
Sample slowed(const Sample& sample, const PathTime& time);

/// True when the slowed trajectory is proven to keep `limits` to `tolerance` (relative) while r falls: interval bounds
/// of each derivative by Bernstein hulls on pieces of the way. `segments` is not empty and keeps the limits itself.
bool keeps_limits(std::span<const Segment> segments, const BrakeProfile& profile, const BrakeLimits& limits);

/// The brake from path time `from` that stops earliest among a fixed family (delays and durations in a ladder) and is
/// proven to keep `limits`. The last member, which needs no proof, is the trajectory itself: it ends at rest. A brake
/// with delay exists because a trajectory that already slows down at its limit cannot slow down more.
/// Cost: at most 128 profiles of kBrakePieces pieces each.
BrakeProfile find_brake(std::span<const Segment> segments, Real from, const BrakeLimits& limits);

inline constexpr int kBrakePieces = 24;

}  // namespace swiftlet
