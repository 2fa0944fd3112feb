#include "map/box_graph.hpp"

#include <algorithm>
#include <numeric>
#include <span>
#include <tuple>

#include "swiftlet/box_graph_format.hpp"

namespace swiftlet::tools {
namespace {

/// Lays cells out over the leaves of the implicit index tree.
class IndexOrder {
 public:
  IndexOrder(std::vector<GridBox> cells, std::vector<GridBox>& slots)
      : cells_(std::move(cells)),
        leaf_count_((cells_.size() + kCellsPerIndexLeaf - 1) / kCellsPerIndexLeaf),
        slots_(slots) {}

  void place_all() {
    if (leaf_count_ > 0) place(0, cells_);
  }

 private:
  /// How many cells the leaves below a node hold.
  [[nodiscard]] std::size_t capacity(std::size_t node) const {
    if (node + 1 >= leaf_count_) {
      const std::size_t first = (node + 1 - leaf_count_) * kCellsPerIndexLeaf;
      return std::min(kCellsPerIndexLeaf, cells_.size() - first);
    }
    return capacity(2 * node + 1) + capacity(2 * node + 2);
  }

  void place(std::size_t node, std::span<GridBox> part) {
    if (node + 1 >= leaf_count_) {
      std::copy(part.begin(), part.end(),
                slots_.begin() + static_cast<std::ptrdiff_t>((node + 1 - leaf_count_) * kCellsPerIndexLeaf));
      return;
    }
    const std::size_t left = capacity(2 * node + 1);
    const std::size_t axis = longest_axis(part);
    const auto key = [axis](const GridBox& box) { return std::tuple(box.lo[axis] + box.hi[axis], box.lo); };
    std::nth_element(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(left), part.end(),
                     [&](const GridBox& a, const GridBox& b) { return key(a) < key(b); });
    place(2 * node + 1, part.first(left));
    place(2 * node + 2, part.subspan(left));
  }

  static std::size_t longest_axis(std::span<const GridBox> part) {
    GridBox bounds = part.front();
    for (const GridBox& box : part) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        bounds.lo[axis] = std::min(bounds.lo[axis], box.lo[axis]);
        bounds.hi[axis] = std::max(bounds.hi[axis], box.hi[axis]);
      }
    }
    std::size_t longest = 0;
    for (std::size_t axis = 1; axis < 3; ++axis) {
      if (bounds.hi[axis] - bounds.lo[axis] > bounds.hi[longest] - bounds.lo[longest]) longest = axis;
    }
    return longest;
  }

  std::vector<GridBox> cells_;
  std::size_t leaf_count_;
  std::vector<GridBox>& slots_;
};

/// Windows across the planes normal to one axis.
void find_windows_along(std::size_t axis, const std::vector<GridBox>& cells,
                        std::vector<std::pair<std::uint32_t, std::uint32_t>>& windows) {
  const std::size_t u = (axis + 1) % 3;
  const std::size_t v = (axis + 2) % 3;
  struct Face {
    std::int32_t plane;
    std::int32_t start;  ///< low end along u, the direction of the sweep
    std::uint32_t cell;
    bool low;  ///< the cell lies above the plane
  };
  std::vector<Face> faces;
  faces.reserve(2 * cells.size());
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    faces.push_back({cells[i].lo[axis], cells[i].lo[u], i, true});
    faces.push_back({cells[i].hi[axis], cells[i].lo[u], i, false});
  }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return std::tuple(a.plane, a.start, a.cell) < std::tuple(b.plane, b.start, b.cell);
  });

  std::array<std::vector<std::uint32_t>, 2> active;  // cells below and above the plane that the sweep is inside of
  std::int32_t plane = -1;
  for (const Face& face : faces) {
    if (face.plane != plane) {
      plane = face.plane;
      for (auto& side : active) side.clear();
    }
    const GridBox& box = cells[face.cell];
    auto& opposite = active[face.low ? 0 : 1];
    std::erase_if(opposite, [&](std::uint32_t other) { return cells[other].hi[u] <= face.start; });
    for (const std::uint32_t other : opposite) {
      const bool overlap = cells[other].lo[v] < box.hi[v] && box.lo[v] < cells[other].hi[v];
      if (overlap) windows.emplace_back(std::min(face.cell, other), std::max(face.cell, other));
    }
    active[face.low ? 1 : 0].push_back(face.cell);
  }
}

}  // namespace

void order_for_index(std::vector<GridBox>& cells) {
  std::vector<GridBox> sorted = cells;
  std::sort(sorted.begin(), sorted.end(), [](const GridBox& a, const GridBox& b) { return a.lo < b.lo; });
  IndexOrder(std::move(sorted), cells).place_all();
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> find_windows(const std::vector<GridBox>& cells) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> windows;
  for (const std::size_t axis : {0U, 1U, 2U}) find_windows_along(axis, cells, windows);
  std::sort(windows.begin(), windows.end());
  return windows;
}

std::vector<std::uint16_t> label_components(const std::vector<GridBox>& cells,
                                            const std::vector<std::pair<std::uint32_t, std::uint32_t>>& windows,
                                            std::uint32_t& component_count) {
  std::vector<std::uint32_t> parent(cells.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&parent](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& [a, b] : windows) parent[std::max(root(a), root(b))] = std::min(root(a), root(b));

  std::vector<std::uint64_t> volumes(cells.size());
  std::vector<std::uint32_t> roots;
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    if (root(i) == i) roots.push_back(i);
    volumes[root(i)] += volume(cells[i]);
  }
  std::sort(roots.begin(), roots.end(), [&](std::uint32_t a, std::uint32_t b) {
    return volumes[a] != volumes[b] ? volumes[a] > volumes[b] : a < b;
  });
  std::vector<std::uint16_t> label_of_root(cells.size());
  for (std::size_t i = 0; i < roots.size(); ++i) {
    label_of_root[roots[i]] = static_cast<std::uint16_t>(std::min<std::size_t>(i, kMostComponentLabels - 1));
  }
  component_count = static_cast<std::uint32_t>(std::min<std::size_t>(roots.size(), kMostComponentLabels));
  std::vector<std::uint16_t> labels(cells.size());
  for (std::uint32_t i = 0; i < cells.size(); ++i) labels[i] = label_of_root[root(i)];
  return labels;
}

}  // namespace swiftlet::tools
