#include "companion/climb.hpp"

#include <algorithm>

namespace swiftlet::companion {
namespace {

std::optional<Vector3> lowest_free(const BoxGraphView& map, const Vector3& start) {
  const Real unit = static_cast<Real>(map.unit());
  const Real reach = static_cast<Real>(map.header().radius + 2 * map.header().resolution);
  for (int i = 0; i < kClimbSteps && unit * static_cast<Real>(i) <= reach; ++i) {
    const Vector3 point = start + Vector3{0, 0, unit * static_cast<Real>(i)};
    if (map.locate(point)) return point;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Vector3> climb_target(const BoxGraphView& map, const Vector3& start, Real height) {
  std::optional<Vector3> top = lowest_free(map, start);
  const Real wanted = start.z() + height;
  const Real unit = static_cast<Real>(map.unit());
  for (int i = 0; top && top->z() < wanted && i < kClimbSteps; ++i) {
    // From cell to cell: half a unit above a cell's ceiling lies the next one, or nothing.
    const Vector3 above{top->x(), top->y(), top->z() + unit / 2};
    const std::optional<CellIndex> cell = map.locate(above);
    if (!cell) break;
    top->z() = std::min(wanted, map.to_world(map.cell(*cell)).hi.z());
  }
  return top;
}

}  // namespace swiftlet::companion
