#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "swiftlet/dual_active_set.hpp"
#include "swiftlet/knot_spline.hpp"
#include "swiftlet/status.hpp"
#include "swiftlet/trajectory.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// How far inside a bound a constraint point is placed (eq. 10): [m] [m/s] [m/s^2], >= 0.
struct Margins {
  Real position = 0;
  Real velocity = 0;
  Real acceleration = 0;
};

/// Excess that counts as no violation [m, m/s, m/s^2].
inline constexpr Real kFeasibility = sizeof(Real) == 8 ? Real(1e-8) : Real(2e-4);

/// How exactly a problem is solved; the default is what an emitted trajectory gets. The cap on the steps is derived
/// from measurement (`qp_bench --limits` of tests/bench/qp, 648 random corridors of 5 to 320 boxes at zero margins,
/// infeasible ones included): none met the cap; the three axes together took at most 131 sweeps and steps at 10 boxes,
/// 176 at 40 and 394 at 320.
struct SolveEffort {
  Real tolerance = kFeasibility;         ///< excess that counts as no violation [m, m/s, m/s^2]
  std::uint32_t steps_per_segment = 10;  ///< active-set steps on an axis: 100, and this many a segment
  std::uint32_t most_steps = std::numeric_limits<std::uint32_t>::max();  ///< and never more than this
  /// The solve gives up once it must cost more [m^2/s^5], summed over the axes.
  Real most_cost = std::numeric_limits<Real>::infinity();
};

/// The unit of work, in which budgets are counted: one active-set step of one axis, per segment. Setting up an axis,
/// its sweeps and its emission count as so many steps.
inline constexpr std::uint32_t kWorkOfSetUp = 8;
inline constexpr std::uint32_t kWorkOfSweep = 2;  ///< of block pivoting

/// One trajectory-generation problem: M boxes, M - 1 gates inside both neighbours, M durations; limits per axis,
/// infinity for none.
struct TrajectoryProblem {
  std::span<const Box> boxes;
  std::span<const Box> gates;
  std::span<const Real> durations;  ///< [s] > 0
  State start;
  State goal;
  Vector3 v_max;  ///< [m/s]
  Vector3 a_max;  ///< [m/s^2]
  Margins margins = {};
  SolveEffort effort = {};
};

enum class BoundKind : std::uint8_t { kPosition, kVelocity, kAcceleration };
enum class FallbackReason : std::uint8_t { kNone, kIterations, kDeadline, kNumerics, kStopAtGates };

/// The bound that an infeasible problem founders on.
struct Blocking {
  std::uint32_t box = 0;  ///< segment
  std::uint8_t axis = 0;  ///< 0 x, 1 y, 2 z
  BoundKind bound = BoundKind::kPosition;
  Real missing = 0;  ///< [m, m/s, m/s^2] by which the bound is missed at the solver's last point
  Real stretch = 0;  ///< smallest uniform stretch of the durations found to help; 0 when none was found
};

struct TrajectoryReport {
  std::uint32_t qp_iterations = 0;      ///< sweeps of pivoting and active-set steps, all axes, all solves
  std::uint32_t constraints_added = 0;  ///< rows ever generated
  std::uint32_t active = 0;             ///< rows active at the end, all axes
  Real residual = 0;                    ///< largest distance of an active row from its bound [m, m/s, m/s^2]
  std::uint64_t work = 0;               ///< units of work spent, all solves
  Real cost = 0;                        ///< [m^2/s^5] jerk cost, all axes
  Real time_scale = 1;                  ///< durations of the answer over those of the first allocation
  FallbackReason fallback_reason = FallbackReason::kNone;
  Blocking blocking;  ///< meaningful with kInfeasible
};

/// A bound that a segment exceeds at a point.
struct Violation {
  std::uint32_t segment = 0;
  std::uint8_t derivative = 0;  ///< 0 position, 1 velocity, 2 acceleration
  Real tau = 0;                 ///< normalised time
  Real sign = 1;                ///< +1 above the upper bound, -1 below the lower one
  Real bound = 0;               ///< [m, m/s, m/s^2]; positions relative to the first box
  Real excess = 0;              ///< [m, m/s, m/s^2] beyond the bound
};

/// Work space of the generator for up to M segments; see storage.hpp.
struct TrajectorySpans {
  PivotingSpans pivoting;           ///< may share its memory with `qp`: they are not used at the same time
  QpSpans qp;                       ///< M - 1 blocks
  std::span<Real> states;           ///< 3 M: p [m], v [m/s], a [m/s^2] at the junctions
  std::span<Real> scales;           ///< M - 1 [s]
  std::span<Violation> violations;  ///< M
  std::span<QpLabel> labels;        ///< Q: the set that one solver leaves to the other
};

/// What one solve leaves for the next one on the same boxes: the active rows of each axis. Storage for Q labels an
/// axis.
struct WarmStart {
  std::array<std::span<QpLabel>, 3> labels;
  std::array<std::size_t, 3> count{};
};

/// Minimum-jerk trajectory for the durations as given (Sec. IV-B to IV-D), each axis by block pivoting and, where that
/// leaves it open, by the dual active-set method; rows are generated lazily at violating extrema. With margins that
/// cannot be met both are repeated without. Bounds hold to the effort's tolerance at every t.
///   segments   receives M segments, in frame W
///   warm       nullptr, or the active rows of an earlier solve to start from; receives those of this one
///   gradient   empty, or receives M elements: the derivative of the summed optimal cost by each duration (envelope
///              theorem: that of the Lagrangian at fixed junction states) [m^2/s^6]
/// Errors: kBadRequest (counts, lo > hi, a gate outside a box, durations not > 0, non-finite numbers, limits not > 0),
/// kInfeasible (at zero margins; report.blocking says where), kIterationLimit (or the effort's cost),
/// kNumericalTrouble, kCorridorCapacity.
Status generate_trajectory(const TrajectoryProblem& problem, const TrajectorySpans& spans, std::span<Segment> segments,
                           TrajectoryReport& report, WarmStart* warm = nullptr, std::span<Real> gradient = {});

/// The smallest uniform stretch of the durations, to one percent and at most `kLargestStretch`, with which
/// generate_trajectory succeeds; 0 when none was found. `durations` is scratch of M elements.
inline constexpr Real kLargestStretch = 64;
Real smallest_stretch(const TrajectoryProblem& problem, const TrajectorySpans& spans, std::span<Segment> segments,
                      std::span<Real> durations);

}  // namespace swiftlet
