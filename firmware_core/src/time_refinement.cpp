#include "swiftlet/time_refinement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace swiftlet {
namespace {

constexpr int kMostHalvings = 6;
constexpr std::uint8_t kMostOvershoots = 32;  // by then a step is none
// No segment is refined to less than this share of the mean: the cost's condition grows with the ratio's fifth power.
constexpr Real kShortestShare = Real(0.05);
// The best trial may be feasible only within a trial's tolerance; then its durations are stretched a little.
constexpr Real kRepairStretch = Real(1.002);
constexpr int kRepairs = 10;

Real sum(std::span<const Real> values) {
  Real total = 0;
  for (const Real value : values) total += value;
  return total;
}

/// Factor on one duration: the fourth root of -gradient / weight, at most `largest`, its logarithm halved `halvings`
/// times.
Real step_factor(Real gradient, Real weight, Real largest, int halvings) {
  Real factor = std::clamp(-gradient / weight, Real(1e-6), Real(1e6));
  factor = std::sqrt(std::sqrt(factor));
  for (int i = 0; i < halvings; ++i) {
    factor = std::sqrt(factor);
    largest = std::sqrt(largest);
  }
  return std::clamp(factor, 1 / largest, largest);
}

/// The least time from a speed over a way [m] >= 0, within limits.
Real least_time(Real way, Real speed, Real v_max, Real a_max) {
  const Real reached = std::sqrt(speed * speed + 2 * a_max * way);
  if (reached <= v_max) return 2 * way / std::max(reached + speed, std::numeric_limits<Real>::min());
  return (way + (v_max - speed) * (v_max - speed) / (2 * a_max)) / v_max;
}

class Refinement {
 public:
  Refinement(const TrajectoryProblem& problem, const RefinementOptions& options, const TrajectorySpans& trajectory,
             RefinementSpans& spans, std::span<Real> durations, std::span<Segment> segments, TrajectoryReport& report)
      : problem_(problem),
        options_(options),
        trajectory_(trajectory),
        warm_(spans.warm),
        durations_(durations),
        trial_(spans.trial.first(durations.size())),
        gradient_(spans.gradient.first(durations.size())),
        overshoots_(spans.overshoots.first(durations.size())),
        segments_(segments.first(durations.size())),
        report_(report),
        last_work_(kWorkOfSetUp * (3 * durations.size())) {}

  Status run() {
    if (options_.work > 0) improve();
    return finish();
  }

 private:
  Status solve(std::span<const Real> durations, const SolveEffort& effort) {
    TrajectoryProblem attempt = problem_;
    attempt.durations = durations;
    attempt.effort = effort;
    const std::uint64_t work = report_.work;
    const std::uint64_t left = options_.deadline > work ? options_.deadline - work : 0;
    const std::uint64_t steps = left / (3 * durations.size());  // for each of the three axes
    if (steps < attempt.effort.most_steps) attempt.effort.most_steps = static_cast<std::uint32_t>(steps);
    const std::uint32_t iterations = report_.qp_iterations;
    const Status status = generate_trajectory(attempt, trajectory_, segments_, report_, &warm_, gradient_);
    last_work_ = report_.work;
    report_.work += work;
    report_.qp_iterations += iterations;
    return status;
  }

  /// The factor by which the trajectory just solved must be slowed down as a whole.
  [[nodiscard]] Real whole_slow_down() const {
    Real factor = 1;
    if (!options_.bounds.exceed_axes()) return factor;
    for (const Segment& segment : segments_) factor = std::max(factor, slow_down(segment, options_.bounds));
    return factor;
  }

  /// Of the trajectory just solved, slowed down where it must be.
  Real objective(std::span<const Real> durations) {
    slow_down_ = whole_slow_down();
    const Real s5 = slow_down_ * slow_down_ * slow_down_ * slow_down_ * slow_down_;
    return (jerk_cost(segments_, 0) + jerk_cost(segments_, 1) + jerk_cost(segments_, 2)) / s5 +
           options_.time_weight * slow_down_ * sum(durations);
  }

  /// The least time that the way of a segment takes, at full speed but for the ends of the whole [s].
  [[nodiscard]] Real least_duration(std::size_t i) const {
    const Segment& segment = segments_[i];
    Real least = 0;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      Real way = 0;
      const auto& c = segment.coefficients[static_cast<std::size_t>(axis)];
      for (std::size_t j = kQuinticTerms; j-- > 1;) way = (way + c[j]) * segment.duration;
      const Real v_max = problem_.v_max[axis];
      const Real direction = way < 0 ? Real(-1) : Real(1);
      const auto from = [&](const State& end, Real part) {
        const Real speed = std::clamp(direction * end.velocity[axis], Real(0), v_max);
        return least_time(std::fabs(way) * part, speed, v_max, problem_.a_max[axis]);
      };
      const bool first = i == 0;
      const bool last = i + 1 == segments_.size();
      Real time = std::fabs(way) / v_max;
      if (first || last) {
        const Real part = first && last ? Real(0.5) : Real(1);
        time = (first ? from(problem_.start, part) : Real(0)) + (last ? from(problem_.goal, part) : Real(0));
      }
      least = std::max(least, time);
    }
    return std::min(least, segment.duration);
  }

  /// From the gradient at the durations, and slower where a bound of norm or jerk asks for it. A duration that has been
  /// beyond its optimum takes half the steps from then on.
  void propose(int halvings) {
    const Real shortest = kShortestShare * sum(durations_) / static_cast<Real>(durations_.size());
    for (std::size_t i = 0; i < durations_.size(); ++i) {
      Real factor = step_factor(gradient_[i], options_.time_weight, options_.largest_step, halvings + overshoots_[i]);
      if (factor < 1) {
        const Real least = least_duration(i);
        const Real held = std::max(4 * least / durations_[i] - 3, Real(0));
        factor = held + (1 - held) * factor;
      }
      // To first order no faster than the other bounds allow.
      if (options_.bounds.exceed_axes()) factor = std::max(factor, slow_down(segments_[i], options_.bounds));
      trial_[i] =
          i < options_.held ? durations_[i] : std::max(factor * durations_[i], std::min(shortest, durations_[i]));
    }
  }

  /// Takes the trial just solved for the durations. Returns whether the objective rises again where the step ended:
  /// then its best lies before.
  bool accept_trial() {
    Real rise = 0;
    for (std::size_t i = 0; i < trial_.size(); ++i) {
      const Real own = (gradient_[i] + options_.time_weight) * (trial_[i] - durations_[i]);
      if (own > 0 && overshoots_[i] < kMostOvershoots) ++overshoots_[i];
      rise += own;
      durations_[i] = trial_[i];
    }
    return rise > 0;
  }

  void improve() {
    std::fill(overshoots_.begin(), overshoots_.end(), std::uint8_t{0});
    const std::uint64_t limit = report_.work + options_.work;
    Real best = objective(durations_);
    Real best_slow_down = slow_down_;
    int halvings = 0;
    bool current = true;  // segments and gradient belong to `durations_`
    while (report_.work + last_work_ <= limit && halvings <= kMostHalvings) {
      if (current) {
        propose(halvings);
      } else {
        for (std::size_t i = 0; i < trial_.size(); ++i) trial_[i] = std::sqrt(trial_[i] * durations_[i]);
      }
      SolveEffort effort = kTrialEffort;
      if (!options_.bounds.exceed_axes()) effort.most_cost = best - options_.time_weight * sum(trial_);
      const Real reached = solve(trial_, effort) == Status::kOk ? objective(trial_) : kUnlimited;
      current = reached < best;
      halvings += current ? 0 : 1;
      if (!current) continue;
      const bool passed_the_best = accept_trial();
      best_slow_down = slow_down_;
      const bool gains_little = best - reached < options_.least_gain * best;
      best = reached;
      if (gains_little && !passed_the_best) break;
    }
    for (Real& duration : durations_) duration *= best_slow_down;
  }

  /// The trajectory of the durations, exactly.
  Status finish() {
    Status status = solve(durations_, problem_.effort);
    for (int repair = 0; repair < kRepairs && status != Status::kOk; ++repair) {
      if (report_.work >= options_.deadline) break;
      for (Real& duration : durations_) duration *= kRepairStretch;
      status = solve(durations_, problem_.effort);
    }
    return status;
  }

  const TrajectoryProblem& problem_;
  const RefinementOptions& options_;
  const TrajectorySpans& trajectory_;
  WarmStart& warm_;
  std::span<Real> durations_;
  std::span<Real> trial_;
  std::span<Real> gradient_;
  std::span<std::uint8_t> overshoots_;  // of each duration: steps beyond its optimum
  std::span<Segment> segments_;
  TrajectoryReport& report_;
  std::uint64_t last_work_;  ///< of the last solve, which the next one is taken to need as well
  Real slow_down_ = 1;
};

}  // namespace

Status refine_durations(const TrajectoryProblem& problem, const RefinementOptions& options,
                        const TrajectorySpans& trajectory, RefinementSpans& spans, std::span<Real> durations,
                        std::span<Segment> segments, TrajectoryReport& report) {
  return Refinement(problem, options, trajectory, spans, durations, segments, report).run();
}

}  // namespace swiftlet
