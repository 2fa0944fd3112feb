#include "swiftlet/time_allocation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace swiftlet {
namespace {

constexpr Real kShortestTotal = Real(1e-3);  // [s] a trajectory of no length still takes time
constexpr Real kShortestShare = Real(1e-3);  // of the mean duration: a leg of no length still has a segment

/// From rest over `length` to rest: both ramps alike, cruise between them.
class SpeedProfile {
 public:
  SpeedProfile(Real length, const SpeedLimits& limits)
      : length_(length), a_max_(limits.a_max), v_cruise_(std::min(limits.v_max, std::sqrt(limits.a_max * length))) {
    ramp_ = v_cruise_ * v_cruise_ / (2 * a_max_);
  }

  /// Time [s] from one place on the way to a later one. Phase by phase, so that a short leg far from the start keeps
  /// all its digits, which the difference of two times since the start would lose.
  [[nodiscard]] Real time_between(Real from, Real to) const {
    const Real cruise_end = length_ - ramp_;
    Real time = 0;
    if (from < ramp_) time += ramp_time(from, std::min(to, ramp_));
    const Real cruise_from = std::max(from, ramp_);
    const Real cruise_to = std::min(to, cruise_end);
    if (cruise_to > cruise_from) time += (cruise_to - cruise_from) / v_cruise_;
    if (to > cruise_end) time += ramp_time(std::max(length_ - to, Real(0)), length_ - std::max(from, cruise_end));
    return time;
  }

 private:
  /// Time [s] between two distances from the end of a ramp that is at rest; sqrt(b) - sqrt(a) without cancellation.
  [[nodiscard]] Real ramp_time(Real near, Real far) const {
    const Real v_sum = std::sqrt(2 * a_max_ * near) + std::sqrt(2 * a_max_ * far);
    return v_sum > 0 ? 2 * (far - near) / v_sum : Real(0);
  }

  Real length_;
  Real a_max_;
  Real v_cruise_;
  Real ramp_ = 0;
};

Real polyline_length(std::span<const Vector3> points) {
  Real length = 0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) length += (points[i + 1] - points[i]).norm();
  return length;
}

bool is_positive_finite(Real value) { return value > 0 && value < std::numeric_limits<Real>::infinity(); }

}  // namespace

Status allocate_durations(std::span<const Vector3> points, const SpeedLimits& limits, std::span<Real> durations,
                          Real start_speed) {
  if (!(start_speed >= 0) || points.size() < 2 || !is_positive_finite(limits.v_max) ||
      !is_positive_finite(limits.a_max)) {
    return Status::kBadRequest;
  }
  const Real length = polyline_length(points);
  if (!(length < std::numeric_limits<Real>::infinity())) return Status::kBadRequest;
  const std::size_t count = points.size() - 1;
  if (durations.size() < count) return Status::kBufferTooSmall;

  const Real run_up = start_speed * start_speed / (2 * limits.a_max);  // that would have led to the start's speed
  const SpeedProfile profile(length + run_up, limits);
  Real travelled = run_up;
  Real total = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Real next = travelled + (points[i + 1] - points[i]).norm();
    durations[i] = profile.time_between(travelled, next);
    total += durations[i];
    travelled = next;
  }
  const Real mean = std::max(total, kShortestTotal) / static_cast<Real>(count);
  const Real shortest = total > kShortestTotal ? kShortestShare * mean : mean;
  for (Real& duration : durations.first(count)) duration = std::max(duration, shortest);
  return Status::kOk;
}

}  // namespace swiftlet
