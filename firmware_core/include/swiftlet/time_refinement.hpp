#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "swiftlet/flight_limits.hpp"
#include "swiftlet/status.hpp"
#include "swiftlet/trajectory_generator.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// Trials are compared, not flown: a rough solve will do.
inline constexpr SolveEffort kTrialEffort{.tolerance = sizeof(Real) == 8 ? Real(3e-4) : Real(5e-4),
                                          .steps_per_segment = 3};

/// How far the durations are pushed: the sum of jerk cost and `time_weight` times total duration is minimised.
struct RefinementOptions {
  Real time_weight = 1;      ///< [m^2/s^6]
  std::uint64_t work = 0;    ///< units to spend on trials (trajectory_generator.hpp); 0 leaves the durations alone
  MotionBounds bounds = {};  ///< rest to rest only: those of norms and jerk, which the QP does not know; trajectories
                             ///< are compared as they are when slowed down to keep them
  /// A step that improves the objective by less than this share of it, and does not pass its best, is the last one.
  Real least_gain = Real(5e-3);
  /// Units that the report may hold in the end, but for the set-up of one solve.
  std::uint64_t deadline = std::numeric_limits<std::uint64_t>::max();
  Real largest_step = 3;  ///< factor on a duration in one step
  std::size_t held = 0;   ///< so many of the first segments keep their durations
};

/// Memory of one refinement of M segments; see storage.hpp.
struct RefinementSpans {
  std::span<Real> trial;               ///< M
  std::span<Real> gradient;            ///< M
  std::span<std::uint8_t> overshoots;  ///< M
  WarmStart warm;                      ///< labels of as many rows as the solver can hold active
};

/// Improves segment durations by the gradient of the optimal cost (envelope theorem), beyond the implicit adjustment of
/// Sec. IV-E. Where a duration alone decides a cost c / T^5, T (5 c / w T^6)^(1/6) is its optimum; so each step
/// multiplies a duration by a root of (-gradient / w), all at once; one that the speed limits hardly leave room shrinks
/// only in part. A step that fails or does not pay halves the logarithms of those that follow; one that takes a
/// duration beyond its optimum halves that duration's alone. Never leaves the durations worse than it found them; stops
/// early when a step gains little.
///   problem    its durations are a view of `durations`; unless no work is allowed they are feasible and have just been
///              solved with kTrialEffort, which left its results in `segments`, `warm` and `gradient`
///   warm       active rows of an earlier solve, and then of the last one here
///   segments   receive the trajectory of the durations returned, solved with the problem's own effort
///   report     of the last solve; `work` and `qp_iterations` are added to what it holds
/// Cost: the work allowed and at most eleven exact trajectories, usually one. Errors: those of generate_trajectory for
/// the durations given.
Status refine_durations(const TrajectoryProblem& problem, const RefinementOptions& options,
                        const TrajectorySpans& trajectory, RefinementSpans& spans, std::span<Real> durations,
                        std::span<Segment> segments, TrajectoryReport& report);

}  // namespace swiftlet
