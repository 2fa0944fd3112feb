#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "map/bit_grid.hpp"

namespace swiftlet::tools {

/// The aligned power-of-two cubes that make up the set cells, each as large as possible, as an octree would have them.
/// `key` is the grid's low corner in the octree's own coordinates. Cubes cut by the grid's end are split further.
/// In order of (z, y, x) of the low corner within each size, largest first.
std::vector<GridBox> octree_leaves(const BitGrid& free, const std::array<std::int64_t, 3>& key);

/// Disjoint boxes that cover exactly the set cells, few and large: always the largest box that grows from one of the
/// remaining leaves is taken next. Deterministic.
std::vector<GridBox> merged_boxes(const BitGrid& free, const std::array<std::int64_t, 3>& key,
                                  const std::function<void(double)>& done);

/// A box around `seed` of set cells that can grow in no direction; the largest of a few ways to grow.
GridBox grow(const BitGrid& free, const GridBox& seed);

}  // namespace swiftlet::tools
