#pragma once
#include <cstdint>
#include <optional>
#include <queue>
#include <vector>

#include "world/voxel_grid.hpp"

namespace swiftlet::tools {

/// Shortest 26-connected paths between voxel centres: the reference length of a query, by code that shares nothing with
/// the planner. A diagonal step is taken only when every voxel that it touches is free (no corner cutting).
class VoxelPathFinder {
 public:
  /// A voxel is blocked when its centre is nearer than `radius` [m] to an occupied cube. `grid` must outlive the
  /// finder.
  VoxelPathFinder(const VoxelGrid& grid, double radius);

  /// Length [m] by A* with the octile distance as heuristic; nothing when there is no path.
  std::optional<double> shortest(const Voxel& from, const Voxel& to);

 private:
  struct Open {
    std::int64_t priority;
    std::int64_t cost;
    std::size_t voxel;
  };
  /// Of equal priorities the one nearer to the goal goes first: open space holds many equal paths.
  struct Later {
    bool operator()(const Open& a, const Open& b) const {
      if (a.priority != b.priority) return a.priority > b.priority;
      return a.cost != b.cost ? a.cost < b.cost : a.voxel > b.voxel;
    }
  };

  /// Bit (z + 1) * 9 + (y + 1) * 3 + x + 1 says whether the neighbour at offset (x, y, z) is free.
  [[nodiscard]] std::uint32_t free_around(const Voxel& voxel) const;
  [[nodiscard]] static std::int64_t octile(const Voxel& a, const Voxel& b);

  const VoxelGrid& grid_;
  std::vector<std::uint8_t> free_;
  std::vector<std::int64_t> cost_;    ///< best so far in fixed point, so that equal paths compare equal; kUnreached
  std::vector<std::size_t> reached_;  ///< where cost_ is to be reset
};

/// The largest set of 6-connected voxels of `allowed`, as a mask. Of equal ones, that with the lowest index.
std::vector<std::uint8_t> largest_component(const VoxelGrid& grid, const std::vector<std::uint8_t>& allowed);

}  // namespace swiftlet::tools
