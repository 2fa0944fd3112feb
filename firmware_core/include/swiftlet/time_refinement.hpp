#pragma once
#include <cstdint>
#include <span>

#include "swiftlet/status.hpp"
#include "swiftlet/trajectory_generator.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// How far the durations are pushed: the sum of jerk cost and `time_weight` times total duration is minimised.
struct RefinementOptions {
  Real time_weight = 1;            ///< [m^2/s^6]
  std::uint32_t solve_budget = 0;  ///< trajectories to try at most; 0 leaves the durations alone
};

/// Memory of one refinement of M segments; see storage.hpp.
struct RefinementSpans {
  std::span<Real> trial;     ///< M
  std::span<Real> gradient;  ///< M
  WarmStart warm;            ///< labels of as many rows as the solver can hold active
};

/// Improves segment durations by the gradient of the optimal cost (envelope theorem), beyond the implicit adjustment of
/// Sec. IV-E. Where a duration alone decides a cost c / T^5, T (5 c / w T^6)^(1/6) is its optimum; so each step
/// multiplies a duration by a root of (-gradient / w), all at once, and a step that fails or does not pay halves the
/// next one's logarithm. Never leaves the durations worse than it found them.
///   problem    feasible with its durations, which are a view of `durations`
///   segments   receive the trajectory of the durations returned
/// Cost: solve_budget + 1 rough trajectories and at most eleven exact ones, usually one. Errors: those of
/// generate_trajectory for the durations given.
Status refine_durations(const TrajectoryProblem& problem, const RefinementOptions& options,
                        const TrajectorySpans& trajectory, const RefinementSpans& spans, std::span<Real> durations,
                        std::span<Segment> segments, TrajectoryReport& report);

}  // namespace swiftlet
