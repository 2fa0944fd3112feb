#include "report/merge_boxes.hpp"

#include <algorithm>
#include <cstddef>
#include <tuple>

namespace swiftlet::tools {
namespace {

/// Everything of a box but its reach along `axis`, then where it begins: boxes that may merge come to lie in a row.
auto row_key(const IntBox& box, std::size_t axis) {
  const std::size_t u = (axis + 1) % 3;
  const std::size_t v = (axis + 2) % 3;
  return std::make_tuple(box.lo[v], box.hi[v], box.lo[u], box.hi[u], box.lo[axis]);
}

bool continues(const IntBox& box, const IntBox& next, std::size_t axis) {
  const std::size_t u = (axis + 1) % 3;
  const std::size_t v = (axis + 2) % 3;
  return box.hi[axis] == next.lo[axis] && box.lo[u] == next.lo[u] && box.hi[u] == next.hi[u] &&
         box.lo[v] == next.lo[v] && box.hi[v] == next.hi[v];
}

void merge_along(std::vector<IntBox>& boxes, std::size_t axis) {
  std::sort(boxes.begin(), boxes.end(),
            [axis](const IntBox& a, const IntBox& b) { return row_key(a, axis) < row_key(b, axis); });
  std::size_t kept = 0;
  for (std::size_t i = 1; i < boxes.size(); ++i) {
    if (continues(boxes[kept], boxes[i], axis)) {
      boxes[kept].hi[axis] = boxes[i].hi[axis];
    } else {
      boxes[++kept] = boxes[i];
    }
  }
  if (!boxes.empty()) boxes.resize(kept + 1);
}

}  // namespace

std::vector<IntBox> merge_boxes(std::span<const IntBox> boxes) {
  std::vector<IntBox> merged(boxes.begin(), boxes.end());
  for (std::size_t axis = 0; axis < 3; ++axis) merge_along(merged, axis);
  return merged;
}

}  // namespace swiftlet::tools
