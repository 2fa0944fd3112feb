#pragma once
#include <span>

#include "swiftlet/flight_limits.hpp"
#include "swiftlet/trajectory.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// The stop-at-every-gate trajectory through `points` (M + 1, one in each gate, start and goal at the ends): straight
/// rest-to-rest quintics within the bounds. Always inside convex boxes that hold both ends of each leg.
void stop_at_gates(std::span<const Vector3> points, const MotionBounds& bounds, std::span<Segment> segments);

/// The same for bounds of speed and acceleration of each axis.
void stop_at_gates(std::span<const Vector3> points, const Vector3& v_max, const Vector3& a_max,
                   std::span<Segment> segments);

}  // namespace swiftlet
