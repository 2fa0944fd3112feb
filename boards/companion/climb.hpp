#pragma once
#include <optional>

#include "swiftlet/box_graph_view.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet::companion {

/// Where a vertical take-off from `start` [m] leads: `height` [m] above it, or as high as the free space above the
/// start goes; where nothing is free at that height, the lowest free point. The map's radius keeps the ground and what
/// stands on it from being free, so the first piece of the way is not; nothing when that piece is longer than the
/// radius and two voxels: then something hangs over the start. At most kClimbSteps look-ups.
std::optional<Vector3> climb_target(const BoxGraphView& map, const Vector3& start, Real height);

inline constexpr int kClimbSteps = 4096;

}  // namespace swiftlet::companion
