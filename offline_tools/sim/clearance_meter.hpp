#pragma once
#include <limits>
#include <vector>

#include "map/voxel_map.hpp"
#include "swiftlet/box_graph_view.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet::tools {

/// The occupied voxels of a source map as boxes, frame W.
std::vector<Box> occupied_boxes(const VoxelMap& map);
/// The same from a map blob. Error: exit status 3, the blob's obstacles are damaged.
Expected<std::vector<Box>> occupied_boxes(const BoxGraphView& view);

/// Least distance [m] of a moving point to a set of boxes. Exact, and cheap while the point moves little between calls:
/// boxes that cannot be the nearest are not looked at.
class ClearanceMeter {
 public:
  explicit ClearanceMeter(std::vector<Box> boxes) : boxes_(std::move(boxes)) {}

  void visit(const Vector3& p_W);
  /// Over all visits so far; 0 inside a box, infinity without any.
  [[nodiscard]] double least() const { return least_; }

 private:
  void gather(const Vector3& p_W);

  std::vector<Box> boxes_;
  std::vector<Box> near_;  ///< hold the nearest box of every point in reach of `centre_`
  Vector3 centre_ = Vector3::Zero();
  double reach_ = -1;  ///< [m] negative: nothing gathered yet
  double least_ = std::numeric_limits<double>::infinity();
};

}  // namespace swiftlet::tools
