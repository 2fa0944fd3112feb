#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "map/error.hpp"
#include "map/voxel_map.hpp"
#include "swiftlet/box_graph_view.hpp"

namespace swiftlet::tools {

/// The occupied voxels of a box of the source map as a .bt node stream (decode_node_stream) of codes 0, 2 and 3, whose
/// root is the smallest cube of 2^d voxels, d >= 1, from the box's low corner on that covers it; empty without any.
std::vector<std::byte> pack_obstacles(const VoxelMap& map, const std::array<std::int32_t, 3>& first_voxel,
                                      const std::array<std::int32_t, 3>& size);

/// The obstacles of a blob as disjoint boxes [unit], few: neighbours that make a box are joined. The section lies under
/// the blob's checksum but outside BoxGraphView's validation, so it is checked here; error: exit status 3.
Expected<std::vector<IntBox>> obstacle_boxes(const BoxGraphView& view);

/// Why a point is in no cell.
enum class NotFree : std::uint8_t {
  kOutside,           ///< outside the mapped box
  kOccupied,          ///< in an occupied voxel
  kTooClose,          ///< closer to one than the radius
  kLostToGrid,        ///< farther away, but its whole unit cube is not
  kUnknown,           ///< never observed, or too close to such space under policy `occupied`
  kLeftOut,           ///< by coarsening, as a sliver, or too close to an obstacle beyond the map's bounds
  kUnknownOrLeftOut,  ///< one of the two: the blob does not tell
};
/// "outside the map", "occupied", "too close to an obstacle", "unknown space" and so on.
const char* describe(NotFree reason);

struct NotFreeReason {
  NotFree reason;
  double obstacle_distance;  ///< [m] to the nearest occupied voxel; infinity without any
};
NotFreeReason why_not_free(const BoxGraphView& view, const std::vector<IntBox>& obstacles, const Vector3& p_W);

}  // namespace swiftlet::tools
