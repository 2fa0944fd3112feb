#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "swiftlet/box_graph_view.hpp"

namespace swiftlet::tools {

/// A map blob in memory, validated. Movable: the view points into the vector's memory, which moves along.
struct MapFile {
  std::string path;
  std::vector<std::byte> bytes;
  BoxGraphView graph;
};

/// Throws Failure (kBadFile) when the file cannot be read or is no valid map.
MapFile load_map(const std::string& path);

/// The blob's checksum as the contract prints it: 8 lower-case hexadecimal digits.
std::string crc32_text(const BoxGraphView& graph);

/// The occupied voxels of a map, decoded when they are first asked for.
class Obstacles {
 public:
  /// `map` must outlive this object.
  explicit Obstacles(const MapFile& map) : map_(map) {}
  /// Disjoint boxes [unit]. Throws Failure when the blob's obstacles are damaged.
  const std::vector<IntBox>& boxes();

 private:
  const MapFile& map_;
  std::optional<std::vector<IntBox>> boxes_;
};

/// Why a point of the request is not free and where the nearest free point lies, in one line that begins with `which`
/// ("start" or "goal").
std::string explain_not_free(const MapFile& map, Obstacles& obstacles, const std::string& which, const Vector3& point);

/// Which components the two ends lie in, and how large those are.
std::string explain_no_path(const MapFile& map, const Vector3& start, const Vector3& goal);

}  // namespace swiftlet::tools
