#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "map/bit_grid.hpp"

namespace swiftlet::tools {

/// Puts the cells into the order of the blob's index: every leaf of the implicit tree (box_graph_format.hpp) holds
/// cells that lie close together, split at medians along the longest side. Deterministic whatever the order on entry.
void order_for_index(std::vector<GridBox>& cells);

/// All pairs (i, j), i < j, of disjoint boxes that share a window: touching on one axis, positive extent on the other
/// two. Sorted. By a sweep over each plane that holds faces.
std::vector<std::pair<std::uint32_t, std::uint32_t>> find_windows(const std::vector<GridBox>& cells);

/// Component label of each cell; components are numbered by falling volume, ties by their first cell. From 65,535
/// on all the rest share the last label, so unequal labels always mean unconnected.
std::vector<std::uint16_t> label_components(const std::vector<GridBox>& cells,
                                            const std::vector<std::pair<std::uint32_t, std::uint32_t>>& windows,
                                            std::uint32_t& component_count);

}  // namespace swiftlet::tools
