#include "swiftlet/planner.hpp"

#include <algorithm>
#include <limits>

#include "swiftlet/blocked_space.hpp"

namespace swiftlet {
namespace {

constexpr Real kInfinity = std::numeric_limits<Real>::infinity();

bool is_finite(const State& state) {
  return (state.position.array().abs() < kInfinity).all() && (state.velocity.array().abs() < kInfinity).all() &&
         (state.acceleration.array().abs() < kInfinity).all();
}

/// The cell of a state's position; moves the position to the nearest free point within `snap`, of one component where
/// one is named.
std::optional<CellIndex> locate_or_snap(const BoxGraphView& graph, Real snap, std::optional<std::uint16_t> component,
                                        State& state) {
  const std::optional<CellIndex> cell = graph.locate(state.position);
  if (cell || !(snap > 0)) return cell;
  const std::optional<BoxGraphView::NearestFree> nearest = graph.nearest_free(state.position, component);
  if (!nearest || nearest->distance > snap) return std::nullopt;
  state.position = nearest->point;
  return nearest->cell;
}

/// Where the ends, as located or moved, are not connected: the goal, or else the start, follows into the component of
/// the other, unless it is free where it is.
bool snap_together(const BoxGraphView& graph, const PlanRequest& request, State& start, CellIndex& start_cell,
                   State& goal, CellIndex& goal_cell) {
  const auto follow = [&](const State& asked, CellIndex other, State& state, CellIndex& cell) {
    State moved = asked;
    const std::uint16_t component = graph.component(other);
    const std::optional<CellIndex> found = locate_or_snap(graph, request.snap_distance, component, moved);
    if (!found || graph.component(*found) != component) return false;
    state = moved;
    cell = *found;
    return true;
  };
  return follow(request.goal, start_cell, goal, goal_cell) || follow(request.start, goal_cell, start, start_cell);
}

std::uint64_t volume(const IntBox& box) {
  std::uint64_t product = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) product *= static_cast<std::uint64_t>(box.hi[axis] - box.lo[axis]);
  return product;
}

/// Every box lies in an extent of the path's cells, or is covered by cells, and meets nothing blocked: apart from how
/// the corridor was made.
bool corridor_is_free(const BoxGraphView& graph, std::span<const CellIndex> cells, std::span<const IntBox> boxes) {
  std::size_t next = 0;
  for (const IntBox& box : boxes) {
    if (graph.blocked() != nullptr && graph.blocked()->meets(box)) return false;
    std::size_t k = next;
    while (k < cells.size() && !contains(graph.extent(cells[k]), box)) ++k;
    if (k < cells.size()) {
      next = k;
    } else if (graph.covered_volume(box) != volume(box)) {
      return false;
    }
  }
  return true;
}

}  // namespace

FlightLimits flight_limits(const PlanRequest& request) {
  return {request.v_max, request.a_max, request.j_max, request.norm, request.vehicle};
}

const Plan& Planner::plan(const BoxGraphView& graph, const PlanRequest& request) {
  if (find_corridor(graph, request) == Status::kOk) (void)fit_trajectory(request);
  return plan_;
}

Status Planner::find_corridor(const BoxGraphView& graph, const PlanRequest& request) {
  plan_ = {};
  plan_.start = request.start;
  plan_.goal = request.goal;
  plan_.status = search_corridor(graph, request);
  return plan_.status;
}

Status Planner::search_corridor(const BoxGraphView& graph, const PlanRequest& request) {
  if (!is_finite(request.start) || !is_finite(request.goal)) return Status::kBadRequest;
  if (!is_usable(flight_limits(request)) || !(request.snap_distance >= 0)) return Status::kBadRequest;
  std::optional<CellIndex> start_cell = locate_or_snap(graph, request.snap_distance, {}, plan_.start);
  if (!start_cell) return Status::kStartNotFree;
  std::optional<CellIndex> goal_cell = locate_or_snap(graph, request.snap_distance, {}, plan_.goal);
  if (!goal_cell) return Status::kGoalNotFree;
  if (graph.component(*start_cell) != graph.component(*goal_cell) &&
      !snap_together(graph, request, plan_.start, *start_cell, plan_.goal, *goal_cell)) {
    return Status::kNoPath;
  }

  std::size_t cell_count = 0;
  Status status = find_cell_path(graph, *start_cell, plan_.start.position, *goal_cell, plan_.goal.position,
                                 request.search, spans_.search, spans_.cell_path, cell_count, plan_.search);
  if (status != Status::kOk) return status;
  const std::span<const CellIndex> cells = spans_.cell_path.first(cell_count);
  CorridorReport corridor;
  status = build_corridor(graph, plan_.start.position, plan_.goal.position, cells, request.corridor, request.relax,
                          {spans_.int_boxes, spans_.boxes, spans_.gates, spans_.points, spans_.taut_nodes}, corridor);
  if (status != Status::kOk) return status;
  plan_.int_boxes = spans_.int_boxes.first(corridor.box_count);
  if (!corridor_is_free(graph, cells, plan_.int_boxes)) return Status::kBlobInconsistent;
  plan_.boxes = spans_.boxes.first(corridor.box_count);
  plan_.gates = spans_.gates.first(corridor.box_count - 1);
  return Status::kOk;
}

Status Planner::fit_trajectory(const PlanRequest& request) {
  TrajectoryRequest posed{plan_.start, plan_.goal, flight_limits(request), request.budget};
  const std::uint64_t searched = kWorkOfExpansion * plan_.search.expanded;
  posed.budget.deadline -= std::min(posed.budget.deadline, searched);
  const FittedTrajectory& fitted =
      trajectory_planner_.fit({spans_.int_boxes, spans_.boxes, spans_.gates, spans_.points}, plan_.boxes.size(), posed);
  plan_.int_boxes = spans_.int_boxes.first(fitted.box_count);
  plan_.boxes = spans_.boxes.first(fitted.box_count);
  plan_.gates = spans_.gates.first(fitted.box_count - 1);
  plan_.segments = fitted.segments;
  plan_.qp_v_max = fitted.qp_v_max;
  plan_.qp_a_max = fitted.qp_a_max;
  plan_.certificate = fitted.certificate;
  plan_.trajectory = fitted.report;
  return plan_.status = fitted.status;
}

}  // namespace swiftlet
