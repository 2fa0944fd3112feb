#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "map/error.hpp"
#include "map/map_builder.hpp"
#include "map/voxel_map.hpp"
#include "swiftlet/box_graph_view.hpp"

namespace swiftlet::tools {

/// What an audit found wrong; nothing when the map keeps all its promises.
struct AuditReport {
  std::size_t defects = 0;
  std::vector<std::string> findings;  ///< the first few, one line each: what is wrong and where [m]
};

/// Checks a blob against the map that it claims to be made of, by code and data structures apart from the builder's:
/// the source and the mapped box; cells disjoint; no obstacle closer to a cell than the radius and no forbidden space
/// in it; every unit cube of free space in a cell (up to the stated loss by coarsening); extents inside the union of
/// cells; windows complete, symmetric and no other; component labels; landmark distances; point location; the packed
/// obstacles. Cost: about
/// that of building the map.
AuditReport audit_map(const BoxGraphView& view, const VoxelMap& map, const Progress& progress);

}  // namespace swiftlet::tools
