#include "sim/clearance_meter.hpp"

#include <algorithm>

#include "map/obstacles.hpp"

namespace swiftlet::tools {
namespace {

double distance(const Box& box, const Vector3& p_W) { return (p_W - p_W.cwiseMax(box.lo).cwiseMin(box.hi)).norm(); }

}  // namespace

std::vector<Box> occupied_boxes(const VoxelMap& map) {
  std::vector<Box> boxes;
  for (const VoxelLeaf& leaf : map.leaves) {
    if (!leaf.occupied) continue;
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<Eigen::Index>(axis);
      box.lo[i] = map.origin[axis] + map.resolution * leaf.lo[axis];
      box.hi[i] = map.origin[axis] + map.resolution * (leaf.lo[axis] + (1 << leaf.log2_edge));
    }
    boxes.push_back(box);
  }
  return boxes;
}

Expected<std::vector<Box>> occupied_boxes(const BoxGraphView& view) {
  const Expected<std::vector<IntBox>> obstacles = obstacle_boxes(view);
  if (!obstacles) return tl::unexpected(obstacles.error());
  std::vector<Box> boxes;
  for (const IntBox& obstacle : *obstacles) boxes.push_back(view.to_world(obstacle));
  return boxes;
}

void ClearanceMeter::visit(const Vector3& p_W) {
  if (!((p_W - centre_).norm() <= reach_)) gather(p_W);
  for (const Box& box : near_) least_ = std::min(least_, distance(box, p_W));
}

/// Within `reach_` of the centre no point is farther than d + reach from its nearest box, so that box is at most
/// d + 2 reach from the centre.
void ClearanceMeter::gather(const Vector3& p_W) {
  constexpr double kReach = 0.25;  // [m] a quarter of a second at 1 m/s
  double nearest = std::numeric_limits<double>::infinity();
  for (const Box& box : boxes_) nearest = std::min(nearest, distance(box, p_W));
  near_.clear();
  for (const Box& box : boxes_) {
    if (distance(box, p_W) <= nearest + 2 * kReach) near_.push_back(box);
  }
  centre_ = p_W;
  reach_ = kReach;
}

}  // namespace swiftlet::tools
