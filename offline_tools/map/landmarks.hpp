#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "map/bit_grid.hpp"
#include "swiftlet/box_graph_format.hpp"
#include "swiftlet/box_graph_view.hpp"

namespace swiftlet::tools {

/// Distances over window centres from a few windows, the landmarks, to every window of the largest component: what
/// CorridorSearch bounds the way to the goal with.
struct LandmarkTable {
  std::uint32_t count = 0;               ///< landmarks
  std::uint32_t shift = 0;               ///< distances are multiples of unit / 2^shift, to the nearest
  std::vector<std::uint16_t> distances;  ///< `count` for each window of component 0, in the order of the windows
  bool too_far = false;                  ///< none, because a distance passes 32,767 units
};

/// Chooses up to `count` landmarks: of 64 candidates, far from each other or behind what those before them bound badly,
/// the ones that together bound the distances of random pairs of windows best. Fewer when the component has fewer
/// windows, none when a distance passes 32,767 units. Deterministic.
///   windows  pairs (i, j), i < j, of cells, sorted
///   labels   component of each cell; 0 is the largest
LandmarkTable choose_landmarks(const std::vector<GridBox>& cells,
                               std::span<const std::pair<std::uint32_t, std::uint32_t>> windows,
                               const std::vector<std::uint16_t>& labels, std::uint32_t count);

/// The landmarks whose table stays below 60 % of `blob_bytes`, the blob's size without them and obstacles; at most 16.
std::uint32_t affordable_landmarks(std::size_t windows, std::size_t blob_bytes);

/// Where the default search should see windows: at their centres, where landmarks help, when on 128 random pairs of
/// places that expands at most two thirds of the windows and the taut paths are hardly longer (0.5 % on average, 5 % on
/// no more than one pair) than with points along the straight line, which suit large windows better.
SearchPoints measure_search_points(const BoxGraphView& view);

}  // namespace swiftlet::tools
