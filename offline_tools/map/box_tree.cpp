#include "map/box_tree.hpp"

#include <algorithm>
#include <numeric>

namespace swiftlet::tools {

std::int64_t squared_gap(const GridBox& a, const GridBox& b) {
  std::int64_t sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t gap = std::max({0, a.lo[axis] - b.hi[axis], b.lo[axis] - a.hi[axis]});
    sum += gap * gap;
  }
  return sum;
}

BoxTree::BoxTree(std::vector<GridBox> boxes) : boxes_(std::move(boxes)), original_(boxes_.size()) {
  std::iota(original_.begin(), original_.end(), std::size_t{0});
  if (boxes_.empty()) return;
  nodes_.push_back({{}, 0, boxes_.size(), 0});
  for (std::size_t node = 0; node < nodes_.size(); ++node) split(node);  // children are appended behind

  std::vector<GridBox> sorted;
  sorted.reserve(boxes_.size());
  for (const std::size_t i : original_) sorted.push_back(boxes_[i]);
  boxes_ = std::move(sorted);
}

void BoxTree::split(std::size_t node) {
  constexpr std::size_t kLeafSize = 8;
  const std::size_t first = nodes_[node].first;
  const std::size_t end = nodes_[node].end;
  GridBox bounds = boxes_[original_[first]];
  for (std::size_t i = first; i < end; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds.lo[axis] = std::min(bounds.lo[axis], boxes_[original_[i]].lo[axis]);
      bounds.hi[axis] = std::max(bounds.hi[axis], boxes_[original_[i]].hi[axis]);
    }
  }
  nodes_[node].bounds = bounds;
  if (end - first <= kLeafSize) return;

  std::size_t axis = 0;
  for (const std::size_t other : {1U, 2U}) {
    if (bounds.hi[other] - bounds.lo[other] > bounds.hi[axis] - bounds.lo[axis]) axis = other;
  }
  const std::size_t middle = (first + end) / 2;
  const auto at = [this](std::size_t i) { return original_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(first), at(middle), at(end), [&](std::size_t a, std::size_t b) {
    return boxes_[a].lo[axis] + boxes_[a].hi[axis] < boxes_[b].lo[axis] + boxes_[b].hi[axis];
  });
  nodes_[node].left = nodes_.size();
  nodes_.push_back({{}, first, middle, 0});
  nodes_.push_back({{}, middle, end, 0});
}

std::size_t BoxTree::find_closer(const GridBox& region, double limit, std::size_t hint) const {
  const auto is_closer = [&](const GridBox& box) { return static_cast<double>(squared_gap(region, box)) < limit; };
  if (hint < boxes_.size() && is_closer(boxes_[hint])) return hint;
  std::vector<std::size_t> stack;
  if (!nodes_.empty()) stack.push_back(0);
  while (!stack.empty()) {
    const Node& node = nodes_[stack.back()];
    stack.pop_back();
    if (!is_closer(node.bounds)) continue;
    if (node.left != 0) {
      stack.push_back(node.left);
      stack.push_back(node.left + 1);
      continue;
    }
    for (std::size_t i = node.first; i < node.end; ++i) {
      if (is_closer(boxes_[i])) return i;
    }
  }
  return kNone;
}

std::uint64_t BoxTree::common_volume(const GridBox& region) const {
  std::uint64_t sum = 0;
  for_each_touching(region, [&](std::size_t i) { sum += volume(intersection(boxes_[i], region)); });
  return sum;
}

}  // namespace swiftlet::tools
