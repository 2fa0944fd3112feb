#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
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

  /// Length [m] by A* with the octile distance as heuristic; nothing when there is no path. Of many equally short paths
  /// only the one with its diagonals first is followed (the canonical order of Harabor and Grastien's jump points).
  std::optional<double> shortest(const Voxel& from, const Voxel& to);

 private:
  /// Sets of the 26 steps, and of the 27 voxels around one: bit (z + 1) * 9 + (y + 1) * 3 + x + 1 is offset (x, y, z).
  using Directions = std::uint32_t;

  struct Node {
    std::int64_t cost;    ///< best so far in fixed point, so that equal paths compare equal
    Directions arrivals;  ///< last steps of the paths of that cost
    Directions expanded;  ///< those of them that were followed on
  };
  struct Open {
    std::int64_t cost;
    std::int64_t priority;
    Voxel voxel;
  };
  enum class Space : std::uint8_t { kBlocked, kFree, kOpen };  ///< open: free with all of its 26 neighbours

  [[nodiscard]] std::size_t index(const Voxel& voxel) const {
    return terms_[0][static_cast<std::size_t>(voxel[0] + 1)] + terms_[1][static_cast<std::size_t>(voxel[1] + 1)] +
           terms_[2][static_cast<std::size_t>(voxel[2] + 1)];
  }
  [[nodiscard]] Directions free_around(const Voxel& voxel) const;
  Directions steps_on(const Voxel& voxel, Directions arrivals);
  Node& node(std::size_t index);
  void push(const Open& open);
  void relax(const Voxel& voxel, std::int64_t cost, Directions arrival, const Voxel& to);

  const VoxelGrid& grid_;
  /// A voxel's index is the sum of three terms, so that the voxels of a tile of 8 x 8 x 8 lie together; one voxel of
  /// border all around is blocked.
  std::array<std::vector<std::size_t>, 3> terms_;
  std::vector<Space> space_;
  std::vector<std::unique_ptr<Node[]>> tiles_;  ///< made when the search first reaches them
  std::vector<std::vector<Open>> buckets_;      ///< the open list by priority, in steps of 1/64 voxel edge
  std::unordered_map<std::uint64_t, Directions> known_steps_;  ///< canonical_steps by neighbourhood and arrival
};

/// The largest set of 6-connected voxels of `allowed`, as a mask. Of equal ones, that with the lowest index.
std::vector<std::uint8_t> largest_component(const VoxelGrid& grid, const std::vector<std::uint8_t>& allowed);

}  // namespace swiftlet::tools
