#pragma once
#include <array>
#include <cstdint>

#include "map/bit_grid.hpp"
#include "map/map_builder.hpp"

namespace swiftlet::tools {

/// Free configuration space on a grid of unit = resolution / 2^unit_shift: a cell is set only when every point of it is
/// free as contract.md has it.
struct FreeSpace {
  BitGrid free;
  std::uint32_t unit_shift = 0;
  std::array<double, 3> origin{};             ///< [m] low corner of the grid
  std::array<std::int32_t, 3> first_voxel{};  ///< the grid's low corner in voxels of the source map
  std::uint64_t lost_to_inflation = 0;        ///< [unit^3] known free, blocked by the inflation of obstacles
  std::uint64_t lost_to_unknown = 0;          ///< [unit^3] free under policy `free`, not under this one
  std::uint64_t lost_to_coarsening = 0;       ///< [unit^3]
};

/// Inflates by exact distances between cubes, in integers: a grid cell is blocked when its squared gap to an obstacle,
/// in units, is below (radius / unit)^2; a distance that equals the radius to twelve digits counts as the radius, since
/// both stand for decimal numbers that double rounds. Whole cells are judged, so a free point may be lost when it lies
/// closer to an obstacle than radius + sqrt(3) unit; the unit is halved until it is at most 0.6 of the radius.
Expected<FreeSpace> compute_free_space(const VoxelMap& map, const std::string& source, const MapBuildOptions& options,
                                       const Progress& progress);

}  // namespace swiftlet::tools
