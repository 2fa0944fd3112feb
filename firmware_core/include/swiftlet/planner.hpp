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
#include "swiftlet/time_refinement.hpp"
#include "swiftlet/trajectory.hpp"
#include "swiftlet/trajectory_generator.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// Speed [m/s] and acceleration [m/s^2] limits outside this range are no request of a multirotor: kBadRequest.
inline constexpr Real kLeastLimit = Real(1e-3);
inline constexpr Real kLargestLimit = Real(1e3);

enum class LimitNorm : std::uint8_t { kAxis, kEuclidean };

struct PlanRequest {
  State start;
  State goal;
  Real v_max = 0;  ///< [m/s]
  Real a_max = 0;  ///< [m/s^2]
  LimitNorm norm = LimitNorm::kAxis;
  CorridorKind corridor = CorridorKind::kExtents;
  bool relax = true;  ///< kCells only
  SearchOptions search;
  std::uint32_t refinement_solves = 12;  ///< trajectories that the refinement of times may try
  Real snap_distance = 0;  ///< [m] move a start or goal that is not free to the nearest free point within this distance
};

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
  std::span<Vector3> stop_points;
  std::span<Real> profile;
  std::span<Real> durations;
  std::span<Real> stop_durations;
  std::span<Segment> segments;
  TrajectorySpans trajectory;
  RefinementSpans refinement;
};

/// Goal in, certified trajectory out: locate, search, corridor, times, QP, certificate. No call keeps anything from an
/// earlier one; same request, same bits.
class Planner {
 public:
  explicit Planner(const PlannerSpans& spans) : spans_(spans) {}

  /// Both stages below, one after the other.
  const Plan& plan(const BoxGraphView& graph, const PlanRequest& request);

  /// Stage one: checks the request, locates both ends, searches, builds boxes, gates and the taut path.
  /// Errors: kBadRequest, kStartNotFree, kGoalNotFree, kNoPath, kSearchCapacity, kCorridorCapacity.
  Status find_corridor(const BoxGraphView& graph, const PlanRequest& request);

  /// Stage two, after a find_corridor that returned kOk for the same request: times, QP, fallback, certificate.
  /// Errors: kFallback (certified, but not the optimum), kInfeasible (from motion only), kNumericalTrouble (nothing
  /// passed its certificate).
  Status fit_trajectory(const PlanRequest& request);

  [[nodiscard]] const Plan& result() const { return plan_; }

 private:
  Status search_corridor(const BoxGraphView& graph, const PlanRequest& request);
  void add_knots();
  void stop_at_every_gate();
  Status allocate_profile();
  [[nodiscard]] TrajectoryProblem problem() const;
  Status stretch_until_feasible();
  Status optimise(const PlanRequest& request);
  bool certify_plan(const PlanRequest& request);

  PlannerSpans spans_;
  Plan plan_;
};

}  // namespace swiftlet
