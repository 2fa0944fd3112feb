#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "swiftlet/braking.hpp"
#include "swiftlet/certificate.hpp"
#include "swiftlet/flight_limits.hpp"
#include "swiftlet/interior_knots.hpp"
#include "swiftlet/status.hpp"
#include "swiftlet/time_refinement.hpp"
#include "swiftlet/trajectory.hpp"
#include "swiftlet/trajectory_generator.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// What a trajectory may cost, in units of work (trajectory_generator.hpp): counts, so that the same request gives the
/// same bits everywhere. A caller with a clock converts by its board's constant (board_config.hpp).
struct WorkBudget {
  /// For the refinement of times; 0 leaves the paper's implicit adjustment alone.
  std::uint64_t refinement = 60'000;
  /// For everything before the certificate. Used up, the answer is the best one so far, the stop at every gate if
  /// there is no better.
  std::uint64_t deadline = std::numeric_limits<std::uint64_t>::max();
};

struct TrajectoryRequest {
  State start;
  State goal;
  FlightLimits limits;
  WorkBudget budget;
};

/// What a fit found; spans point into the caller's corridor and the planner's storage.
struct FittedTrajectory {
  Status status = Status::kBadRequest;
  std::size_t box_count = 0;           ///< boxes in use by now: knots repeat some
  std::span<const Segment> segments;   ///< one a box; empty without an answer
  Vector3 qp_v_max = Vector3::Zero();  ///< [m/s] per-axis limits that the QP was given; its margins are zero
  Vector3 qp_a_max = Vector3::Zero();  ///< [m/s^2]
  Certificate certificate;
  TrajectoryReport report;
};

/// Memory of one trajectory planner of up to M segments; see storage.hpp.
struct TrajectoryPlannerSpans {
  std::span<Vector3> stop_points;  ///< M + 1
  std::span<Real> profile;         ///< M
  std::span<Real> durations;       ///< M
  std::span<Real> stop_durations;  ///< M
  std::span<Segment> segments;     ///< M
  TrajectorySpans trajectory;
  RefinementSpans refinement;
};

/// Corridor in, certified trajectory out: knots, times, QP, refinement, fallback, certificate.
class TrajectoryPlanner {
 public:
  explicit TrajectoryPlanner(const TrajectoryPlannerSpans& spans) : spans_(spans) {}

  /// `corridor`: `count` boxes, count - 1 gates, and count + 1 points of a path through them, in buffers that may grow
  /// to their full size. Errors: kFallback (certified, but not the optimum), kInfeasible (from motion only: the report
  /// says which axis of which box lacks how many metres; its stretch stays 0, for durations are the planner's own and
  /// one that helps is taken), kBadRequest (limits that are out of range),
  /// kNumericalTrouble (nothing passed its certificate).
  const FittedTrajectory& fit(const KnottedCorridor& corridor, std::size_t count, const TrajectoryRequest& request);

 private:
  [[nodiscard]] std::size_t count() const { return fitted_.box_count; }
  [[nodiscard]] std::span<Real> durations() const { return spans_.durations.first(count()); }
  [[nodiscard]] bool is_from_rest() const;
  [[nodiscard]] std::uint64_t work_left() const;
  [[nodiscard]] TrajectoryProblem problem(const SolveEffort& effort) const;
  [[nodiscard]] Real path_length() const;
  [[nodiscard]] Real time_weight() const;

  bool ends_keep_limits();
  void find_ramps();
  void keep_ramps();
  void add_knots();
  void plan_braking();
  bool add_braking();
  bool drop_first_box();
  [[nodiscard]] bool corridor_has_room() const;
  void stop_at_every_gate();
  Status allocate_profile();
  void fit_first_box(std::span<Real> times) const;
  Status try_durations();
  Status stretch_from_rest();
  void stretch_profile(Real stretch);
  void scatter_durations(std::size_t scatter, std::size_t held);
  Status stretch_from_motion();
  Status tighten_limits(Real weight, std::size_t held);
  Status refine(std::uint64_t work);
  Status complete(Status found);
  Status optimise();
  Status optimise_from_motion();
  Status optimise_by_tightening();
  Status optimise_braking();
  Status slow_down_to_bounds();
  bool certify_segments();
  Status fall_back(Status optimised);

  TrajectoryPlannerSpans spans_;
  KnottedCorridor corridor_;
  TrajectoryRequest request_;
  MotionBounds bounds_;
  Braking braking_;
  Real ramp_acceleration_ = 0;   // [m/s^2]
  Real longest_leg_ = 0;         // [m] of the path, before knots
  std::size_t brake_count_ = 0;  // leading segments that only brake
  FittedTrajectory fitted_;
};

}  // namespace swiftlet
