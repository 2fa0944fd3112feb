#include "swiftlet/planner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "swiftlet/blocked_space.hpp"
#include "swiftlet/interior_knots.hpp"
#include "swiftlet/time_allocation.hpp"

namespace swiftlet {
namespace {

constexpr Real kInfinity = std::numeric_limits<Real>::infinity();
// An axis-wise speed limit that keeps the Euclidean one: 1 / sqrt(3), rounded down.
constexpr Real kNormShare = Real(0.57735);
// No segment is shorter than this share of the mean: where the taut path touches two gates in one point its profile
// gives no time at all, and the cost grows with T^-5.
constexpr Real kShortestShare = Real(0.05);
constexpr Real kShortestDuration = Real(1e-3);  // [s]
// Longest leg without a knot, in units of the way to the speed limit and back.
constexpr Real kLongestLeg = 2;
constexpr Real kStretchStep = Real(1.25);
constexpr int kStretchSteps = 20;
// Jerk cost that a second is worth, in units of a^4 / v^2: more flies faster, less smoother.
constexpr Real kTimeWeight = 10;

bool is_finite(const State& state) {
  return (state.position.array().abs() < kInfinity).all() && (state.velocity.array().abs() < kInfinity).all() &&
         (state.acceleration.array().abs() < kInfinity).all();
}

bool is_usable(Real limit) { return limit >= kLeastLimit && limit <= kLargestLimit; }

bool is_at_rest(const State& state) { return state.velocity.isZero(0) && state.acceleration.isZero(0); }

/// The cell of a state's position; moves the position to the nearest free point within `snap`.
std::optional<CellIndex> locate_or_snap(const BoxGraphView& graph, Real snap, State& state) {
  const std::optional<CellIndex> cell = graph.locate(state.position);
  if (cell || !(snap > 0)) return cell;
  const std::optional<BoxGraphView::NearestFree> nearest = graph.nearest_free(state.position);
  if (!nearest || nearest->distance > snap) return std::nullopt;
  state.position = nearest->point;
  return nearest->cell;
}

/// Why a solve that ended with `status` left the plan to its fallback.
FallbackReason reason_for_fallback(Status status) {
  switch (status) {
    case Status::kIterationLimit:
      return FallbackReason::kIterations;
    case Status::kInfeasible:
      return FallbackReason::kStopAtGates;
    default:
      return FallbackReason::kNumerics;  // kOk: solved, but its certificate did not pass
  }
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
  if (!is_usable(request.v_max) || !is_usable(request.a_max) || !(request.snap_distance >= 0)) {
    return Status::kBadRequest;
  }
  const std::optional<CellIndex> start_cell = locate_or_snap(graph, request.snap_distance, plan_.start);
  if (!start_cell) return Status::kStartNotFree;
  const std::optional<CellIndex> goal_cell = locate_or_snap(graph, request.snap_distance, plan_.goal);
  if (!goal_cell) return Status::kGoalNotFree;
  if (graph.component(*start_cell) != graph.component(*goal_cell)) return Status::kNoPath;

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
  const Real share = request.norm == LimitNorm::kEuclidean ? kNormShare : Real(1);
  plan_.qp_v_max = Vector3::Constant(share * request.v_max);
  plan_.qp_a_max = Vector3::Constant(share * request.a_max);
  add_knots();
  // The answer that always exists, before anything that could run out (design: section 6).
  stop_at_every_gate();
  for (std::size_t i = 0; i < plan_.boxes.size(); ++i) spans_.stop_durations[i] = spans_.segments[i].duration;

  plan_.status = optimise(request);
  if (plan_.status == Status::kOk && certify_plan(request)) return plan_.status;
  if (!is_at_rest(plan_.start) || !is_at_rest(plan_.goal)) return plan_.status = Status::kInfeasible;
  plan_.trajectory.fallback_reason = reason_for_fallback(plan_.status);
  stop_at_every_gate();
  plan_.status = certify_plan(request) ? Status::kFallback : Status::kNumericalTrouble;
  return plan_.status;
}

/// Interior knots where one quintic would be too stiff for its leg.
void Planner::add_knots() {
  const Real ramps = plan_.qp_v_max[0] * plan_.qp_v_max[0] / plan_.qp_a_max[0];  // [m] to the speed limit and back
  const std::size_t count = insert_knots({spans_.int_boxes, spans_.boxes, spans_.gates, spans_.points},
                                         plan_.boxes.size(), kLongestLeg * ramps);
  plan_.int_boxes = spans_.int_boxes.first(count);
  plan_.boxes = spans_.boxes.first(count);
  plan_.gates = spans_.gates.first(count - 1);
}

/// Straight legs from gate to gate; one that passes knots is split at them, from the back so that nothing is
/// overwritten.
void Planner::stop_at_every_gate() {
  const std::size_t count = plan_.boxes.size();
  std::size_t legs = 0;
  spans_.stop_points[0] = spans_.points[0];
  for (std::size_t i = 0; i < count; ++i) {
    if (i + 1 < count && is_knot(plan_.int_boxes, i)) continue;
    spans_.stop_points[++legs] = spans_.points[i + 1];
  }
  stop_at_gates(spans_.stop_points.first(legs + 1), plan_.qp_v_max, plan_.qp_a_max, spans_.segments);
  for (std::size_t end = count; end > 0;) {
    std::size_t first = end - 1;
    while (first > 0 && is_knot(plan_.int_boxes, first - 1)) --first;
    split_segment(spans_.segments[--legs], spans_.segments.subspan(first, end - first));
    end = first;
  }
}

/// Segment durations along the taut path; junctions that coincide get a share of the mean.
Status Planner::allocate_profile() {
  const std::size_t count = plan_.boxes.size();
  const std::span<Real> profile = spans_.profile.first(count);
  const SpeedLimits limits{plan_.qp_v_max[0], plan_.qp_a_max[0]};
  const Status status = allocate_durations(spans_.points.first(count + 1), limits, profile);
  if (status != Status::kOk) return status;
  Real total = 0;
  for (const Real duration : profile) total += duration;
  const Real shortest = std::max(kShortestShare * total / static_cast<Real>(count), kShortestDuration);
  for (Real& duration : profile) duration = std::max(duration, shortest);
  return Status::kOk;
}

TrajectoryProblem Planner::problem() const {
  return {plan_.boxes,    plan_.gates, spans_.durations.first(plan_.boxes.size()),
          plan_.start,    plan_.goal,  plan_.qp_v_max,
          plan_.qp_a_max, Margins{}};
}

/// Stretches the profile until the QP can follow it, each segment at most to its stopping time where the plan is from
/// rest to rest: at full stretch every segment has that time, which is always feasible.
Status Planner::stretch_until_feasible() {
  const std::size_t count = plan_.boxes.size();
  const bool from_rest = is_at_rest(plan_.start) && is_at_rest(plan_.goal);
  Status first = Status::kOk;
  Blocking blocking;
  Real stretch = 1;
  for (int step = 0; step < kStretchSteps; ++step, stretch *= kStretchStep) {
    for (std::size_t i = 0; i < count; ++i) {
      const Real longest = from_rest ? std::max(spans_.stop_durations[i], spans_.profile[i]) : kInfinity;
      spans_.durations[i] = std::min(stretch * spans_.profile[i], longest);
    }
    const std::uint32_t spent = plan_.trajectory.qp_iterations;
    const Status status =
        generate_trajectory(problem(), spans_.trajectory, spans_.segments.first(count), plan_.trajectory);
    plan_.trajectory.qp_iterations += spent;
    if (status == Status::kOk) return status;
    if (step > 0) continue;
    first = status;
    blocking = plan_.trajectory.blocking;
  }
  plan_.trajectory.blocking = blocking;
  return first;
}

/// Times and QP: profile, stretch, refinement.
Status Planner::optimise(const PlanRequest& request) {
  const std::size_t count = plan_.boxes.size();
  Status status = allocate_profile();
  if (status == Status::kOk) status = stretch_until_feasible();
  if (status != Status::kOk) return status;
  const Real a2 = plan_.qp_a_max[0] * plan_.qp_a_max[0];
  const Real v2 = plan_.qp_v_max[0] * plan_.qp_v_max[0];
  status = refine_durations(problem(), {kTimeWeight * a2 * a2 / v2, request.refinement_solves}, spans_.trajectory,
                            spans_.refinement, spans_.durations.first(count), spans_.segments.first(count),
                            plan_.trajectory);
  const auto total = [&](std::span<const Real> durations) {
    Real sum = 0;
    for (const Real duration : durations.first(count)) sum += duration;
    return sum;
  };
  plan_.trajectory.time_scale = total(spans_.durations) / total(spans_.profile);
  return status;
}

/// Certifies the segments against the request and, when they pass, makes them the plan's.
bool Planner::certify_plan(const PlanRequest& request) {
  const std::span<const Segment> segments = spans_.segments.first(plan_.boxes.size());
  const bool per_axis = request.norm == LimitNorm::kAxis;
  const Vector3 unlimited = Vector3::Constant(kInfinity);
  plan_.certificate = certify(segments, {plan_.boxes, plan_.gates, plan_.start, plan_.goal,
                                         per_axis ? Vector3::Constant(request.v_max) : unlimited,
                                         per_axis ? Vector3::Constant(request.a_max) : unlimited,
                                         per_axis ? kInfinity : request.v_max, per_axis ? kInfinity : request.a_max});
  if (plan_.certificate.pass) plan_.segments = segments;
  return plan_.certificate.pass;
}

}  // namespace swiftlet
