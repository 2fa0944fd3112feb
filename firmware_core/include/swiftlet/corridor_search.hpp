#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "swiftlet/box_graph_view.hpp"
#include "swiftlet/status.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// Which graph the search runs on.
enum class SearchMode : std::uint8_t {
  kDefault,    ///< representative points closer to the final path than window centres
  kLandmarks,  ///< the paper's graph with landmark lower bounds (same cost as kPlain)
  kPlain,      ///< the paper's graph, edge cost and heuristic (Sec. III-B, eq. 2)
};

struct SearchOptions {
  SearchMode mode = SearchMode::kDefault;
  Real weight = 1;  ///< >= 1; multiplies the heuristic: a path at most `weight` times the shortest
};

/// One reached window. The whole search state of a window is this record.
struct SearchNode {
  std::uint32_t from;    ///< cell the window was entered from
  std::uint32_t to;      ///< cell it leads into
  std::uint32_t parent;  ///< index of the previous node
  Real cost;             ///< [m] from the start to this window's representative point
};

/// Storage of one search, owned by the caller. `open` holds at least as many elements as `nodes`; `hash` holds a power
/// of two of at least twice as many.
struct OpenEntry {
  Real priority;       ///< cost + weight * heuristic [m]
  std::uint32_t node;  ///< index into nodes
};
struct SearchScratch {
  std::span<SearchNode> nodes;
  std::span<OpenEntry> open;
  std::span<std::uint32_t> hash;
};

struct SearchReport {
  std::uint32_t expanded = 0;  ///< windows taken from the open list
  std::uint32_t reached = 0;   ///< windows put into the node table
  Real cost = 0;               ///< [m] of the path found, on the mode's own graph
};

/// A* with windows as vertices (paper Sec. III-B; eq. (2) prints w^y1 in the row of z, we use w^z1).
///   start, goal   [m] frame W, inside the closed cells start_cell and goal_cell
///   path          receives start_cell ... goal_cell, consecutive cells sharing a window; path_length elements
/// Optimal on the mode's graph for weight 1; ties break by index, so every machine returns the same path.
/// Errors: kNoPath, kSearchCapacity (node table full), kCorridorCapacity (`path` too short), kBadRequest (weight < 1 or
/// not finite).
Status find_cell_path(const BoxGraphView& graph, CellIndex start_cell, const Vector3& start, CellIndex goal_cell,
                      const Vector3& goal, const SearchOptions& options, const SearchScratch& scratch,
                      std::span<CellIndex> path, std::size_t& path_length, SearchReport& report);

}  // namespace swiftlet
