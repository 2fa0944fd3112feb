#pragma once
#include <cstddef>
#include <cstdint>
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

/// Relative gap to which a taut path is proven, and a cap of its Newton steps (25,000 random chains: 4 to 11 at the
/// median, at most 19).
inline constexpr Real kTautGap = Real(1e-3);
inline constexpr int kTautSteps = 60;

/// Work of `pull_taut` for one junction and the leg that leaves it.
struct TautNode {
  Vector3 tension;                  ///< dual of the leg, in the unit ball: its direction, at the optimum
  Vector3 step;                     ///< [m] Newton step of the junction
  Vector3 push_lo;                  ///< multipliers of the gate's lower faces
  Vector3 push_hi;                  ///< and of its upper faces
  Eigen::Matrix<Real, 3, 3> carry;  ///< how the junction follows the next one's step
};

struct TautReport {
  Real length = 0;       ///< [m] of the polyline in `points`
  Real lower_bound = 0;  ///< [m] no polyline through the gates is shorter
  int steps = 0;         ///< Newton steps taken
};

/// The shortest polyline from start to goal through the gates in order: length - lower_bound <= kTautGap * length,
/// unless the cap of steps was met (report.steps == kTautSteps).
///   gates    M - 1 boxes in frame W [m]; thin on an axis where lo equals hi
///   points   receives start, one point of each gate, goal: M + 1 elements [m]
///   nodes    at least M + 1 elements, contents irrelevant; when steps > 0, the tensions afterwards prove lower_bound
/// A primal-dual interior-point method for sums of Euclidean norms (Andersen, Christiansen, Conn and Overton, SIAM J.
/// Sci. Comput. 22, 2000): all junctions move together through a block-tridiagonal Newton system, and the tensions of
/// the legs give the bound. Cost O(M) a step.
TautReport pull_taut(const Vector3& start, const Vector3& goal, std::span<const Box> gates, std::span<Vector3> points,
                     std::span<TautNode> nodes);

/// Memory of a corridor of up to N boxes: N elements each, N + 1 points and nodes.
struct CorridorSpans {
  std::span<IntBox> int_boxes;  ///< [unit]
  std::span<Box> boxes;         ///< the same in frame W [m]
  std::span<Box> gates;         ///< gate i is the whole intersection of boxes i and i + 1
  std::span<Vector3> points;    ///< the taut path: start, a point in each gate, goal
  std::span<TautNode> nodes;    ///< scratch
};

struct CorridorReport {
  std::size_t box_count = 0;  ///< M; the spans hold M boxes, M - 1 gates, M + 1 points
  TautReport taut;            ///< of the points
};

/// From the cells of a path to boxes whose consecutive members share a passage (`is_passage`), the gates between them
/// and the taut path through them. kExtents pulls the path taut through the extents of all cells, then keeps the fewest
/// of them, going forward, that cover it within 0.5 % of its length, so a box goes only where the path can do without
/// it. (To drop whatever lies between two extents that share a passage gives fewer boxes and detours: up to 17 % on the
/// power-plant map.) kCells keeps the cells; `relax` applies the relaxation of Sec. IV-E to them
/// (window_relaxation.hpp).
///   start, goal  [m] frame W, inside the first and the last cell
///   cells        start cell ... goal cell, as find_cell_path returns them; at least one
/// Cost O(cells * M). Errors: kCorridorCapacity when the spans are too short. A path of more cells than they hold is
/// thinned out first.
Status build_corridor(const BoxGraphView& graph, const Vector3& start, const Vector3& goal,
                      std::span<const CellIndex> cells, CorridorKind kind, bool relax, const CorridorSpans& spans,
                      CorridorReport& report);

}  // namespace swiftlet
