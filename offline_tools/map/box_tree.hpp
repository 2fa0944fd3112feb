#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "map/bit_grid.hpp"

namespace swiftlet::tools {

/// A static tree of bounding boxes over a set of boxes, for the audit: split at medians, eight boxes a leaf.
class BoxTree {
 public:
  explicit BoxTree(std::vector<GridBox> boxes);

  [[nodiscard]] const std::vector<GridBox>& boxes() const { return boxes_; }  ///< in the tree's own order
  /// Where the box at `i` of boxes() stood in the vector that the tree was made of.
  [[nodiscard]] std::size_t original(std::size_t i) const { return original_[i]; }

  /// Calls `visit(i)` for every box that meets `region`, both closed, so that touching counts.
  template <typename Visit>
  void for_each_touching(const GridBox& region, const Visit& visit) const {
    std::vector<std::size_t> stack;
    if (!nodes_.empty()) stack.push_back(0);
    while (!stack.empty()) {
      const Node& node = nodes_[stack.back()];
      stack.pop_back();
      if (!touches(node.bounds, region)) continue;
      if (node.left != 0) {
        stack.push_back(node.left);
        stack.push_back(node.left + 1);
        continue;
      }
      for (std::size_t i = node.first; i < node.end; ++i) {
        if (touches(boxes_[i], region)) visit(i);
      }
    }
  }

  /// A box whose squared distance to `region` is below `limit`, or kNone. `hint` is tried first.
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  [[nodiscard]] std::size_t find_closer(const GridBox& region, double limit, std::size_t hint) const;

  /// Volume that the boxes have in common with `region`; with disjoint boxes, how much of it they cover.
  [[nodiscard]] std::uint64_t common_volume(const GridBox& region) const;

 private:
  struct Node {
    GridBox bounds;
    std::size_t first;
    std::size_t end;
    std::size_t left;  ///< the right child follows; 0 for a leaf
  };
  static bool touches(const GridBox& a, const GridBox& b) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (a.lo[axis] > b.hi[axis] || b.lo[axis] > a.hi[axis]) return false;
    }
    return true;
  }
  void split(std::size_t node);

  std::vector<GridBox> boxes_;
  std::vector<std::size_t> original_;
  std::vector<Node> nodes_;
};

/// Squared distance between two closed boxes.
std::int64_t squared_gap(const GridBox& a, const GridBox& b);

}  // namespace swiftlet::tools
