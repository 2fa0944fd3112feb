#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "world/voxel_grid.hpp"

namespace swiftlet::tools {

/// A generated world with the vehicle it is meant for and the query that everybody quotes.
struct World {
  VoxelGrid grid;
  double radius;     ///< [m] of the vehicle
  Voxel main_start;  ///< both ends lie in the largest component of `roomy_voxels`
  Voxel main_goal;
};

/// Connected voxel centres with reference lengths [m].
struct WorldQuery {
  Voxel start;
  Voxel goal;
  double euclid;
  double astar;  ///< VoxelPathFinder
};

/// Rooms joined by doors in three dimensions, after the paper's maze (Sec. VI): 32 x 32 x 32 voxels of 0.32 m, 6,774
/// occupied, the main query from corner to opposite corner, about 34 m of voxel path, up and down on the way.
World make_maze(std::uint64_t seed);

/// A screen, pillars, a table and a shelf in the paper's flight space (Sec. VI-D): 13 x 10 x 5 voxels of 0.32 m, 54
/// occupied.
World make_classroom(std::uint64_t seed);

/// A building after the paper's office (Sec. VI): 390 x 250 x 100 voxels of 0.20 m, 259,237 occupied. Three floors, the
/// highest over the west wing alone, around an atrium; rooms with doors on both long sides, two stair shafts, desks.
/// The main query climbs from the ground floor by a voxel path of about 42 m. `scale` (1, 2, 4 or 8) is
/// how many such buildings stand wall to wall, with doors between them.
World make_office(std::uint64_t seed, std::size_t scale = 1);

/// 240 trunks of 0.2 to 1 m on 40 x 40 m, 5 m high, in voxels of 0.20 m; the main query runs from corner to corner.
World make_forest(std::uint64_t seed);

/// The largest set of voxels whose centres have room: free and connected for the vehicle even after a conservative
/// rounding of free space to half a voxel, a quarter where the radius is smaller than a voxel.
std::vector<std::uint8_t> roomy_voxels(const VoxelGrid& grid, double radius);

/// `count` queries between roomy voxels at least a quarter of the world's diagonal apart, the main one first.
/// `progress` is told how much of them is done, 0 to 1.
std::vector<WorldQuery> make_queries(
    const World& world, std::uint64_t seed, std::size_t count,
    const std::function<void(double)>& progress = [](double) {});

/// CSV with the header x0,y0,z0,x1,y1,z1,euclid_m,astar_m; metres with three decimals.
std::string queries_csv(const World& world, const std::vector<WorldQuery>& queries);

}  // namespace swiftlet::tools
