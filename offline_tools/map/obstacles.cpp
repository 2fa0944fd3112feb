#include "map/obstacles.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

#include "map/bit_grid.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kTwelveDigits = 1e-12;  // relative: such lengths count as equal

/// Depth of the tree whose root cube covers a box of this size.
int root_depth(std::int64_t longest_edge) {
  int depth = 1;
  while ((std::int64_t{1} << depth) < longest_edge) ++depth;
  return depth;
}

GridBox cube_at(const Index3& lo, int log2_edge) {
  const std::int32_t edge = std::int32_t{1} << log2_edge;
  return {lo, {lo[0] + edge, lo[1] + edge, lo[2] + edge}};
}

/// Appends the record of one inner node and of all below it; `boxes` are the obstacles that meet it, disjoint.
void write_node(const Index3& lo, int log2_edge, const std::vector<GridBox>& boxes, std::vector<std::byte>& stream) {
  const std::size_t record = stream.size();
  stream.resize(record + 2);
  unsigned codes = 0;
  for (unsigned child = 0; child < 8; ++child) {
    const std::int32_t half = std::int32_t{1} << (log2_edge - 1);
    Index3 corner = lo;
    for (std::size_t axis = 0; axis < 3; ++axis) corner[axis] += (child >> axis & 1U) != 0 ? half : 0;
    const GridBox cube = cube_at(corner, log2_edge - 1);
    std::vector<GridBox> inside;
    std::uint64_t filled = 0;
    for (const GridBox& box : boxes) {
      const std::uint64_t common = volume(intersection(box, cube));
      if (common == 0) continue;
      inside.push_back(box);
      filled += common;
    }
    const unsigned code = filled == 0 ? 0U : filled == volume(cube) ? 2U : 3U;
    codes |= code << (2 * child);
    if (code == 3) write_node(corner, log2_edge - 1, inside, stream);
  }
  stream[record] = static_cast<std::byte>(codes & 0xFFU);
  stream[record + 1] = static_cast<std::byte>(codes >> 8);
}

/// Joins boxes that follow each other along an axis with the same cross-section.
void join_along(std::size_t axis, std::vector<GridBox>& boxes) {
  const std::size_t u = (axis + 1) % 3;
  const std::size_t v = (axis + 2) % 3;
  const auto key = [&](const GridBox& box) {
    return std::tuple(box.lo[u], box.hi[u], box.lo[v], box.hi[v], box.lo[axis]);
  };
  std::sort(boxes.begin(), boxes.end(), [&](const GridBox& a, const GridBox& b) { return key(a) < key(b); });
  std::vector<GridBox> joined;
  for (const GridBox& box : boxes) {
    if (!joined.empty()) {
      GridBox& last = joined.back();
      if (last.lo[u] == box.lo[u] && last.hi[u] == box.hi[u] && last.lo[v] == box.lo[v] && last.hi[v] == box.hi[v] &&
          last.hi[axis] == box.lo[axis]) {
        last.hi[axis] = box.hi[axis];
        continue;
      }
    }
    joined.push_back(box);
  }
  boxes = std::move(joined);
}

/// [unit^2] between two closed boxes.
double squared_gap(const IntBox& a, const IntBox& b) {
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int gap = std::max({0, a.lo[axis] - b.hi[axis], b.lo[axis] - a.hi[axis]});
    sum += static_cast<double>(gap) * gap;
  }
  return sum;
}

}  // namespace

std::vector<std::byte> pack_obstacles(const VoxelMap& map, const std::array<std::int32_t, 3>& first_voxel,
                                      const std::array<std::int32_t, 3>& size) {
  std::vector<GridBox> boxes;
  for (const VoxelLeaf& leaf : map.leaves) {
    if (!leaf.occupied) continue;
    Index3 lo{};
    for (std::size_t axis = 0; axis < 3; ++axis) lo[axis] = leaf.lo[axis] - first_voxel[axis];
    const GridBox box = intersection(cube_at(lo, leaf.log2_edge), {{0, 0, 0}, size});
    if (volume(box) > 0) boxes.push_back(box);
  }
  std::vector<std::byte> stream;
  if (boxes.empty()) return stream;
  write_node({0, 0, 0}, root_depth(*std::max_element(size.begin(), size.end())), boxes, stream);
  return stream;
}

Expected<std::vector<IntBox>> obstacle_boxes(const BoxGraphView& view) {
  if (view.obstacles().empty()) return {};
  const BlobHeader& header = view.header();
  const std::uint32_t longest = *std::max_element(header.size.begin(), header.size.end());
  const std::uint32_t voxels = (longest + (1U << header.unit_shift) - 1) >> header.unit_shift;
  const auto leaves = decode_node_stream(view.obstacles(), root_depth(voxels));
  if (!leaves) return bad_file("the map's obstacle section " + leaves.error() + "; build the map again");

  const GridBox whole{{0, 0, 0},
                      {static_cast<std::int32_t>(header.size[0]), static_cast<std::int32_t>(header.size[1]),
                       static_cast<std::int32_t>(header.size[2])}};
  std::vector<GridBox> boxes;
  for (const VoxelLeaf& leaf : *leaves) {
    const int shift = static_cast<int>(header.unit_shift);
    const Index3 lo{leaf.lo[0] << shift, leaf.lo[1] << shift, leaf.lo[2] << shift};
    const GridBox box = intersection(cube_at(lo, leaf.log2_edge + shift), whole);
    if (leaf.occupied && volume(box) > 0) boxes.push_back(box);
  }
  for (const std::size_t axis : {0U, 1U, 2U}) join_along(axis, boxes);

  std::vector<IntBox> result;
  for (const GridBox& box : boxes) {
    IntBox narrow{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      narrow.lo[axis] = static_cast<std::uint16_t>(box.lo[axis]);
      narrow.hi[axis] = static_cast<std::uint16_t>(box.hi[axis]);
    }
    result.push_back(narrow);
  }
  return result;
}

const char* describe(NotFree reason) {
  switch (reason) {
    case NotFree::kOutside:
      return "outside the map";
    case NotFree::kOccupied:
      return "occupied";
    case NotFree::kTooClose:
      return "too close to an obstacle";
    case NotFree::kLostToGrid:
      return "lost to the map's grid near an obstacle";
    case NotFree::kUnknown:
      return "unknown space";
    case NotFree::kLeftOut:
      return "left out by --coarsen, --drop-slivers or --bounds";
    case NotFree::kUnknownOrLeftOut:
      return "unknown space, or left out by --coarsen or --drop-slivers";
  }
  return "?";
}

NotFreeReason why_not_free(const BoxGraphView& view, const std::vector<IntBox>& obstacles, const Vector3& p_W) {
  const BlobHeader& header = view.header();
  const double radius_units = header.radius / view.unit();
  IntBox cube{};  // the unit cube around the point; what the builder judges
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double units = (p_W[static_cast<Eigen::Index>(axis)] - header.origin[axis]) / view.unit();
    cube.lo[axis] = static_cast<std::uint16_t>(std::clamp(std::floor(units), 0.0, header.size[axis] - 1.0));
    cube.hi[axis] = static_cast<std::uint16_t>(cube.lo[axis] + 1);
  }
  double nearest = std::numeric_limits<double>::infinity();
  double cube_squared = nearest;  // [unit^2]
  for (const IntBox& obstacle : obstacles) {
    const Box box = view.to_world(obstacle);
    const Vector3 gap = (box.lo - p_W).cwiseMax(p_W - box.hi).cwiseMax(0);
    nearest = std::min(nearest, static_cast<double>(gap.norm()));
    cube_squared = std::min(cube_squared, squared_gap(cube, obstacle));
  }
  const auto size = [&](std::size_t axis) { return static_cast<std::uint16_t>(header.size[axis]); };
  const Box whole = view.to_world({{0, 0, 0}, {size(0), size(1), size(2)}});
  const bool inside = (p_W.array() >= whole.lo.array()).all() && (p_W.array() <= whole.hi.array()).all();
  if (!inside) return {NotFree::kOutside, nearest};
  if (nearest == 0) return {NotFree::kOccupied, nearest};
  if (nearest < header.radius * (1 - kTwelveDigits)) return {NotFree::kTooClose, nearest};
  if (cube_squared < radius_units * radius_units * (1 - 2 * kTwelveDigits)) return {NotFree::kLostToGrid, nearest};
  if (header.unknown_policy == static_cast<std::uint32_t>(UnknownPolicy::kFree)) return {NotFree::kLeftOut, nearest};
  const bool left_out = header.lost_to_coarsening + header.lost_to_slivers > 0;
  return {left_out ? NotFree::kUnknownOrLeftOut : NotFree::kUnknown, nearest};
}

}  // namespace swiftlet::tools
