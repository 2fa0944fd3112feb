#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "map/error.hpp"
#include "map/map_report.hpp"
#include "map/voxel_map.hpp"
#include "swiftlet/box_graph_format.hpp"

namespace swiftlet::tools {

enum class Partition { kBoxes, kOctree };

struct MapBuildOptions {
  double radius = 0;  ///< [m] of the vehicle, >= 0
  UnknownPolicy unknown = UnknownPolicy::kAvoid;
  Partition partition = Partition::kBoxes;
  std::optional<std::array<double, 6>> bounds;  ///< [m] x0 y0 z0 x1 y1 z1: only what lies inside is mapped
  std::optional<std::uint32_t> landmarks;       ///< of the search; as many as stay below 60 % of the rest unless given
  std::optional<double> sliver_tolerance;  ///< [m] drop thin cells that lengthen no way past them by more (slivers.hpp)
  int coarsen = 1;  ///< keep only whole blocks of this many voxels an edge that are free after inflation
};

/// Told of each stage and how much of it is done (0 to 1).
using Progress = std::function<void(std::string_view stage, double done)>;

struct BuiltMap {
  std::vector<std::byte> blob;
  MapReport report;
};

/// Flattens a voxel map into a blob (docs/map_format.md): inflate, partition, extend, connect, measure, pack. Same
/// input and options, same bytes. `source` names the map in the report and in errors. Errors: too large for the blob's
/// integers or for memory (exit status 3); bounds that hold nothing of the map, a radius over 64 voxels (2). The rest
/// of the options is the caller's to check (finite, radius >= 0, coarsen >= 1).
Expected<BuiltMap> build_map(const VoxelMap& map, const std::string& source, const MapBuildOptions& options,
                             const Progress& progress);

}  // namespace swiftlet::tools
