#pragma once
#include <cstddef>
#include <span>

#include "swiftlet/box_graph_view.hpp"
#include "swiftlet/status.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// Which boxes a corridor is made of.
enum class CorridorKind : std::uint8_t {
  kExtents,  ///< each cell's extent, shortcut
  kCells,    ///< the paper's: cells and windows
};

/// From the cells of a path to boxes whose consecutive members share a passage (`is_passage`).
/// kExtents takes each cell's extent and drops a box when the extents before and after it share a passage.
/// kCells keeps the cells; `relax` applies the relaxation of Sec. IV-E to them (window_relaxation.hpp).
///   cells   start cell ... goal cell, as find_cell_path returns them; at least one
///   boxes   receives M boxes [unit]; box_count = M; the start lies in the first, the goal in the last
/// Errors: kCorridorCapacity when `boxes` is too short.
Status build_corridor(const BoxGraphView& graph, std::span<const CellIndex> cells, CorridorKind kind, bool relax,
                      std::span<IntBox> boxes, std::size_t& box_count);

/// The shortest polyline from start to goal through the gates in order, to a stated relative gap.
///   gates    M - 1 boxes in frame W [m]
///   points   receives start, one point of each gate, goal: M + 1 elements [m]
///   scratch  at least M + 1 elements, contents irrelevant
/// Each pass reweights the legs and pulls one exact taut string an axis, so all points move together; ends when the
/// dual bound proves the length to `kTautGap` or after `kTautPasses`. Returns the proven lower bound of the length [m].
inline constexpr Real kTautGap = Real(1e-3);
inline constexpr int kTautPasses = 60;
Real pull_taut(const Vector3& start, const Vector3& goal, std::span<const Box> gates, std::span<Vector3> points,
               std::span<Vector3> scratch);

}  // namespace swiftlet
