#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "swiftlet/box_graph_view.hpp"
#include "swiftlet/certificate.hpp"
#include "swiftlet/corridor.hpp"
#include "swiftlet/corridor_search.hpp"
#include "swiftlet/status.hpp"
#include "swiftlet/trajectory.hpp"
#include "swiftlet/trajectory_planner.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

struct PlanRequest {
  State start;
  State goal;
  Real v_max = 0;           ///< [m/s]
  Real a_max = 0;           ///< [m/s^2]
  Real j_max = kUnlimited;  ///< [m/s^3]
  LimitNorm norm = LimitNorm::kAxis;
  std::optional<Vehicle> vehicle = {};
  CorridorKind corridor = CorridorKind::kExtents;
  bool relax = true;  ///< kCells only
  SearchOptions search;
  WorkBudget budget;  ///< the search counts towards its deadline
  /// [m] Move a start or goal that is not free to the nearest free point within this distance; where the ends are then
  /// not connected, to the nearest one that is.
  Real snap_distance = 0;
};

/// The limits of a request, as the trajectory stage and the certificate take them.
FlightLimits flight_limits(const PlanRequest& request);

/// Units of work (trajectory_generator.hpp) that one expansion of the search stands for in a deadline.
inline constexpr std::uint64_t kWorkOfExpansion = 12;

/// Where a plan's answer lies; spans point into the planner's storage and live until its next call.
struct Plan {
  Status status = Status::kBadRequest;
  std::span<const IntBox> int_boxes;  ///< [unit] the corridor in the blob's own integers
  std::span<const Box> boxes;         ///< M boxes [m] frame W
  std::span<const Box> gates;         ///< M - 1 gates
  std::span<const Segment> segments;  ///< M segments; empty without a trajectory
  State start;                        ///< the states that were planned between: the request's, or the snapped ones
  State goal;
  Vector3 qp_v_max = Vector3::Zero();  ///< [m/s] per-axis limits that the QP was given; its margins are zero
  Vector3 qp_a_max = Vector3::Zero();  ///< [m/s^2]
  Certificate certificate;
  SearchReport search;
  TrajectoryReport trajectory;
};

/// Memory of one planner; PlannerStorage (storage.hpp) owns it.
struct PlannerSpans {
  SearchScratch search;
  std::span<CellIndex> cell_path;
  std::span<IntBox> int_boxes;
  std::span<Box> boxes;
  std::span<Box> gates;
  std::span<Vector3> points;
  std::span<TautNode> taut_nodes;
  TrajectoryPlannerSpans trajectory;
};

/// Goal in, certified trajectory out: locate, search, corridor, times, QP, certificate. No call keeps anything from an
/// earlier one; same request, same bits.
class Planner {
 public:
  explicit Planner(const PlannerSpans& spans) : spans_(spans), trajectory_planner_(spans.trajectory) {}

  /// Both stages below, one after the other.
  const Plan& plan(const BoxGraphView& graph, const PlanRequest& request);

  /// Stage one: checks the request, locates both ends, searches, builds boxes, gates and the taut path.
  /// Errors: kBadRequest, kStartNotFree, kGoalNotFree, kNoPath, kSearchCapacity, kCorridorCapacity.
  Status find_corridor(const BoxGraphView& graph, const PlanRequest& request);

  /// Stage two, after a find_corridor that returned kOk for the same request: times, QP, fallback, certificate.
  /// Errors: kFallback (certified, but not the optimum), kInfeasible (from motion only), kCorridorCapacity (from motion
  /// only: no segments left for the braking), kNumericalTrouble (nothing passed its certificate).
  Status fit_trajectory(const PlanRequest& request);

  [[nodiscard]] const Plan& result() const { return plan_; }

 private:
  Status search_corridor(const BoxGraphView& graph, const PlanRequest& request);

  PlannerSpans spans_;
  TrajectoryPlanner trajectory_planner_;
  Plan plan_;
};

}  // namespace swiftlet
