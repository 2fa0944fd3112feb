#pragma once
#include <string>
#include <vector>

#include "map/bit_grid.hpp"
#include "map/map_builder.hpp"

namespace swiftlet::tools {

inline constexpr double kGoodShare = 0.9;  ///< of the free space in the largest component: no need of others

/// The share of the set cells in the largest set of cells connected by faces; 0 without any.
double largest_share(const BitGrid& free);

/// Tries, least change first, what could join a map's pieces: no coarsening, the more permissive policies for unknown
/// space, half the radius. Ends with the first that reaches kGoodShare; otherwise none does. Each trial costs one
/// inflation of the map.
std::vector<Alternative> try_alternatives(const VoxelMap& map, const std::string& source,
                                          const MapBuildOptions& options, const Progress& progress);

}  // namespace swiftlet::tools
