#pragma once
#include <span>

#include "swiftlet/status.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// Bounds of the rest-to-rest speed profile; both must be > 0.
struct SpeedLimits {
  Real v_max;  ///< [m/s]
  Real a_max;  ///< [m/s^2]
};

/// Segment durations from one accelerate-cruise-decelerate profile over the whole polyline (Sec. IV-E): duration i is
/// the time between points i and i + 1 on it.
///   start_speed  [m/s] >= 0, along the polyline: the profile is entered where it has this speed
///   points     M + 1 >= 2 finite points [m], frame W
///   durations  receives M elements [s], each at least a thousandth of the mean, together at least 1 ms
/// Cost O(M). Errors, found before the first write: kBadRequest (fewer than two points, a length or limit that is not
/// finite, a limit that is not > 0, a speed that is not >= 0), kBufferTooSmall (`durations` shorter than M).
Status allocate_durations(std::span<const Vector3> points, const SpeedLimits& limits, std::span<Real> durations,
                          Real start_speed = 0);

}  // namespace swiftlet
