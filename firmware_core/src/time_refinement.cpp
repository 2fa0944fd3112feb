#include "swiftlet/time_refinement.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

constexpr int kMostHalvings = 6;
constexpr Real kLargestStep = Real(1.5);  // factor on a duration in one step
// No segment is refined to less than this share of the mean: the cost's condition grows with the ratio's fifth power.
constexpr Real kShortestShare = Real(0.05);

// Trials are compared, not flown: a rough solve will do.
constexpr SolveEffort kTrialEffort{.tolerance = sizeof(Real) == 8 ? Real(1e-4) : Real(5e-4), .steps_per_segment = 3};
// The best trial may be feasible only within a trial's tolerance; then its durations are stretched a little.
constexpr Real kRepairStretch = Real(1.002);
constexpr int kRepairs = 10;

Real sum(std::span<const Real> values) {
  Real total = 0;
  for (const Real value : values) total += value;
  return total;
}

/// Factor on one duration: the fourth root of -gradient / weight, its logarithm halved `halvings` times.
Real step_factor(Real gradient, Real weight, int halvings) {
  Real factor = std::clamp(-gradient / weight, Real(1e-6), Real(1e6));
  Real largest = kLargestStep;
  factor = std::sqrt(std::sqrt(factor));
  for (int i = 0; i < halvings; ++i) {
    factor = std::sqrt(factor);
    largest = std::sqrt(largest);
  }
  return std::clamp(factor, 1 / largest, largest);
}

}  // namespace

Status refine_durations(const TrajectoryProblem& problem, const RefinementOptions& options,
                        const TrajectorySpans& trajectory, const RefinementSpans& spans, std::span<Real> durations,
                        std::span<Segment> segments, TrajectoryReport& report) {
  const std::size_t count = durations.size();
  const std::span<Real> trial = spans.trial.first(count);
  const std::span<Real> gradient = spans.gradient.first(count);
  WarmStart warm = spans.warm;
  TrajectoryProblem attempt = problem;
  attempt.effort = kTrialEffort;
  std::uint32_t iterations = report.qp_iterations;
  const auto solve = [&](std::span<const Real> times) {
    attempt.durations = times;
    const Status status = generate_trajectory(attempt, trajectory, segments, report, &warm, gradient);
    iterations += report.qp_iterations;
    report.qp_iterations = iterations;
    return status;
  };
  const auto objective = [&](std::span<const Real> times) {
    return jerk_cost(segments, 0) + jerk_cost(segments, 1) + jerk_cost(segments, 2) + options.time_weight * sum(times);
  };

  Status status = solve(durations);
  if (status != Status::kOk) return status;
  Real best = objective(durations);
  int halvings = 0;
  bool current = true;  // segments and gradient belong to `durations`
  for (std::uint32_t solves = 0; solves < options.solve_budget && halvings <= kMostHalvings; ++solves) {
    if (!current) {
      for (std::size_t i = 0; i < count; ++i) trial[i] = std::sqrt(trial[i] * durations[i]);
    } else {
      const Real shortest = kShortestShare * sum(durations) / static_cast<Real>(count);
      for (std::size_t i = 0; i < count; ++i) {
        const Real factor = step_factor(gradient[i], options.time_weight, halvings);
        trial[i] = std::max(factor * durations[i], std::min(shortest, durations[i]));
      }
    }
    current = solve(trial) == Status::kOk && objective(trial) < best;
    if (current) {
      best = objective(trial);
      std::copy(trial.begin(), trial.end(), durations.begin());
    } else {
      ++halvings;
    }
  }
  attempt.effort = problem.effort;
  status = solve(durations);
  for (int repair = 0; repair < kRepairs && status != Status::kOk; ++repair) {
    for (Real& duration : durations) duration *= kRepairStretch;
    status = solve(durations);
  }
  return status;
}

}  // namespace swiftlet
