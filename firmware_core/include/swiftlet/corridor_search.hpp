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
  kDefault,    ///< kLandmarks where the map says that window centres serve it well and has landmarks for the start's
               ///< component; else a window stands for its point nearest to the straight line from start to goal
  kLandmarks,  ///< the paper's graph, same cost as kPlain, with the map's landmark distances as a further bound
  kPlain,      ///< the paper's graph, edge cost and heuristic (Sec. III-B, eq. 2): a window stands for its centre
};

struct SearchOptions {
  SearchMode mode = SearchMode::kDefault;
  Real weight = 1;  ///< 1 to 1e6; multiplies the heuristic: a path at most `weight` times the shortest
};

/// One reached window, 16 bytes. It leads from the cell that its parent leads into (the start cell without a parent).
struct SearchNode {
  std::uint32_t to;        ///< cell it leads into
  std::uint32_t parent;    ///< index of the previous node
  std::uint32_t position;  ///< in the open list; kClosed once it was taken from there
  float cost;              ///< [unit] from the start to this window's point; float on every machine, whatever Real is
};
static_assert(sizeof(SearchNode) == 16);

struct OpenEntry {
  float priority;      ///< [unit] cost + weight * heuristic
  std::uint32_t node;  ///< index into nodes
};

/// Storage of one search, owned by the caller; contents irrelevant, nothing is kept between calls. `open` holds at
/// least as many elements as `nodes`; `hash` holds a power of two of at least twice as many. 32 bytes a window in all.
struct SearchScratch {
  std::span<SearchNode> nodes;
  std::span<OpenEntry> open;
  std::span<std::uint32_t> hash;
};

struct SearchReport {
  std::uint32_t expanded = 0;  ///< windows taken from the open list, again ones counted again
  std::uint32_t reached = 0;   ///< windows put into the node table
  Real cost = 0;               ///< [m] of the path found, on the mode's own graph
};

/// A* with windows as vertices (paper Sec. III-B; eq. (2) prints w^y1 in the row of z, we use w^z1). A window is
/// expanded into the cell beyond it only: what lies on its near side is reached from its parent at no more cost.
///   start, goal   [m] frame W, inside the closed cells start_cell and goal_cell
///   path          receives start_cell ... goal_cell, consecutive cells sharing a window; path_length elements
/// Optimal on the mode's graph for weight 1, to the rounding of float costs (1e-6 of the cost); ties break by index, so
/// every machine returns the same path. Each node is expanded at most once, so a hostile map cannot hold the search up.
/// Landmark distances are rounded, so their bound may drop by a step from one window to the next, and a window may be
/// reached at less cost after it was expanded: then it takes a second node, which is rare. The time follows the windows
/// reached, not the capacity.
/// Errors: kNoPath, kSearchCapacity (node table full), kCorridorCapacity (`path` too short), kBadRequest (weight out of
/// range).
Status find_cell_path(const BoxGraphView& graph, CellIndex start_cell, const Vector3& start, CellIndex goal_cell,
                      const Vector3& goal, const SearchOptions& options, const SearchScratch& scratch,
                      std::span<CellIndex> path, std::size_t& path_length, SearchReport& report);

}  // namespace swiftlet
