#include "swiftlet/brake.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace swiftlet {
namespace {

constexpr Real kEpsilon = std::numeric_limits<Real>::epsilon();
constexpr int kDelays = 16;
constexpr int kDurations = 8;
constexpr Real kDurationStep = Real(1.25);
constexpr Real kShortest = Real(0.05);         // [s]
constexpr Real kSmoothstepPeak = Real(1.875);  // largest slope of the quintic smoothstep on [0, 1]
constexpr Real kTolerance = sizeof(Real) == 8 ? Real(1e-6) : Real(1e-3);  // the certificate's, relative to the limit

struct Interval {
  Real lo;
  Real hi;
};

Interval operator*(const Interval& a, const Interval& b) {
  const std::array<Real, 4> products{a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi};
  return {*std::min_element(products.begin(), products.end()), *std::max_element(products.begin(), products.end())};
}
Interval operator+(const Interval& a, const Interval& b) { return {a.lo + b.lo, a.hi + b.hi}; }
Real magnitude(const Interval& a) { return std::max(std::fabs(a.lo), std::fabs(a.hi)); }
Interval hull(Real a, Real b) { return {std::min(a, b), std::max(a, b)}; }

/// 1 - smoothstep at x in [0, 1] and its derivatives by x.
Real falling(Real x) { return 1 - x * x * x * (10 + x * (6 * x - 15)); }
Real falling1(Real x) { return -30 * x * x * (1 - x) * (1 - x); }
Real falling2(Real x) { return -60 * x * (1 - x) * (1 - 2 * x); }
/// Its integral from 0.
Real falling_integral(Real x) {
  const Real x4 = x * x * x * x;
  return x - x4 * (Real(2.5) + x * (x - 3));
}

/// Derivatives 1 to 3 by path time on a piece of a segment.
using Derivatives = std::array<Interval, 3>;

/// Hull of sum_j c_j x^j on [0, 1] by its Bernstein points, rounded outward.
Interval hull_of(std::span<const Real> c) {
  constexpr std::array<std::array<Real, 5>, 5> kBinomial{
      {{1, 0, 0, 0, 0}, {1, 1, 0, 0, 0}, {1, 2, 1, 0, 0}, {1, 3, 3, 1, 0}, {1, 4, 6, 4, 1}}};
  const std::size_t degree = c.size() - 1;
  Real rounding = 0;
  for (const Real term : c) rounding += 16 * kEpsilon * std::fabs(term);
  Interval range{c[0], c[0]};
  for (std::size_t i = 1; i <= degree; ++i) {
    Real point = 0;
    for (std::size_t j = 0; j <= i; ++j) point += kBinomial[i][j] / kBinomial[degree][j] * c[j];
    range = {std::min(range.lo, point), std::max(range.hi, point)};
  }
  return {range.lo - rounding, range.hi + rounding};
}

/// Bounds of one axis over [t, t + h] of a segment: Taylor coefficients at t, scaled to [0, 1].
Derivatives bounds_on(const std::array<Real, kQuinticTerms>& c, Real t, Real h) {
  const Real v = (((5 * c[5] * t + 4 * c[4]) * t + 3 * c[3]) * t + 2 * c[2]) * t + c[1];
  const Real a = ((20 * c[5] * t + 12 * c[4]) * t + 6 * c[3]) * t + 2 * c[2];
  const Real j = (60 * c[5] * t + 24 * c[4]) * t + 6 * c[3];
  const Real s = 120 * c[5] * t + 24 * c[4];
  const Real k = 120 * c[5];
  const Real h2 = h * h;
  const std::array<Real, 5> v_terms{v, a * h, j * h2 / 2, s * h2 * h / 6, k * h2 * h2 / 24};
  const std::array<Real, 4> a_terms{a, j * h, s * h2 / 2, k * h2 * h / 6};
  const std::array<Real, 3> j_terms{j, s * h, k * h2 / 2};
  return {hull_of(v_terms), hull_of(a_terms), hull_of(j_terms)};
}

/// The range of r and its derivatives on a piece of the fall.
struct RateRange {
  Interval rate;
  Interval rate1;
  Interval rate2;
};

RateRange rate_range(Real x0, Real x1, Real duration) {
  RateRange range{hull(falling(x0), falling(x1)), hull(falling1(x0), falling1(x1)), hull(falling2(x0), falling2(x1))};
  if (x0 < Real(0.5) && Real(0.5) < x1) range.rate1.lo = falling1(Real(0.5));
  constexpr Real kBend = Real(0.211324865405187118);  // (3 - sqrt 3) / 6: extreme points of falling2
  if (x0 < kBend && kBend < x1) range.rate2.lo = falling2(kBend);
  if (x0 < 1 - kBend && 1 - kBend < x1) range.rate2.hi = falling2(1 - kBend);
  range.rate.lo = std::max(range.rate.lo, Real(0));
  range.rate1 = {range.rate1.lo / duration, range.rate1.hi / duration};
  range.rate2 = {range.rate2.lo / (duration * duration), range.rate2.hi / (duration * duration)};
  return range;
}

/// One piece of path time inside one segment, under a range of rates.
bool piece_keeps_limits(const Segment& segment, Real t, Real h, const RateRange& rates, const BrakeLimits& limits) {
  const Interval rate_2 = rates.rate * rates.rate;
  const Interval triple{3, 3};
  Real acceleration2 = 0;
  Real jerk2 = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Derivatives d = bounds_on(segment.coefficients[axis], t, h);
    const Real a = magnitude(d[1] * rate_2 + d[0] * rates.rate1);
    const Real j =
        magnitude(d[2] * rate_2 * rates.rate + triple * d[1] * rates.rate * rates.rate1 + d[0] * rates.rate2);
    if (!(a <= limits.a_max[static_cast<Eigen::Index>(axis)] * (1 + kTolerance))) return false;
    acceleration2 += a * a;
    jerk2 += j * j;
  }
  return std::sqrt(acceleration2) <= limits.acceleration_norm_max * (1 + kTolerance) &&
         std::sqrt(jerk2) <= limits.jerk_norm_max * (1 + kTolerance);
}

/// Walks a trajectory forward in path time.
class Cursor {
 public:
  Cursor(std::span<const Segment> segments, Real s) : segments_(segments), t_(std::max(s, Real(0))) { skip_finished(); }

  /// Checks the next `length` [s] of path time; what lies past the end is at rest.
  bool pass(Real length, const RateRange& rates, const BrakeLimits& limits) {
    while (length > 0 && !at_end()) {
      const Segment& segment = segments_[index_];
      const Real h = std::min(length, segment.duration - t_);
      if (!piece_keeps_limits(segment, t_, h, rates, limits)) return false;
      length -= h;
      t_ += h;
      skip_finished();
    }
    return true;
  }

 private:
  [[nodiscard]] bool at_end() const { return index_ == segments_.size(); }
  void skip_finished() {
    while (!at_end() && t_ >= segments_[index_].duration) t_ -= segments_[index_++].duration;
  }

  std::span<const Segment> segments_;
  std::size_t index_ = 0;
  Real t_;
};

/// The shortest fall worth trying: that of a straight flight at the present velocity.
Real shortest_duration(std::span<const Segment> segments, Real from, const BrakeLimits& limits) {
  const Sample now = sample_trajectory(segments, from);
  const Real norm = limits.acceleration_norm_max;
  Real duration = std::max(kShortest, kSmoothstepPeak * now.velocity.norm() / norm);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    duration = std::max(duration, kSmoothstepPeak * std::fabs(now.velocity[axis]) / limits.a_max[axis]);
  }
  return duration;
}

}  // namespace

PathTime path_time(const BrakeProfile& profile, Real t) {
  const Real fall = t - profile.delay;
  if (profile.duration <= 0 || fall <= 0) return {profile.from + t, 1, 0, 0};
  if (fall >= profile.duration) return {profile.from + profile.delay + profile.duration / 2, 0, 0, 0};
  const Real T = profile.duration;
  const Real x = fall / T;
  return {profile.from + profile.delay + T * falling_integral(x), falling(x), falling1(x) / T, falling2(x) / (T * T)};
}

Sample slowed(const Sample& sample, const PathTime& time) {
  const Real r = time.rate;
  return {sample.position, sample.velocity * r, sample.acceleration * (r * r) + sample.velocity * time.rate1,
          sample.jerk * (r * r * r) + sample.acceleration * (3 * r * time.rate1) + sample.velocity * time.rate2};
}

bool keeps_limits(std::span<const Segment> segments, const BrakeProfile& profile, const BrakeLimits& limits) {
  if (profile.duration <= 0) return true;
  const Real T = profile.duration;
  Cursor cursor(segments, profile.from + profile.delay);
  for (int k = 0; k < kBrakePieces; ++k) {
    const Real x0 = static_cast<Real>(k) / kBrakePieces;
    const Real x1 = static_cast<Real>(k + 1) / kBrakePieces;
    const Real length = T * (falling_integral(x1) - falling_integral(x0));
    if (!cursor.pass(length, rate_range(x0, x1, T), limits)) return false;
  }
  return true;
}

BrakeProfile find_brake(std::span<const Segment> segments, Real from, const BrakeLimits& limits) {
  const Real shortest = shortest_duration(segments, from, limits);
  const Real delay_step = shortest / 4;
  BrakeProfile best{from, 0, 0};
  Real best_stop = total_duration(segments) - from;  // [s] of path time until rest
  for (int i = 0; i < kDelays; ++i) {
    BrakeProfile profile{from, static_cast<Real>(i) * delay_step, shortest};
    for (int k = 0; k < kDurations; ++k, profile.duration *= kDurationStep) {
      const Real stop = profile.delay + profile.duration / 2;
      if (stop >= best_stop) break;
      if (!keeps_limits(segments, profile, limits)) continue;
      best = profile;
      best_stop = stop;
      break;
    }
  }
  return best;
}

}  // namespace swiftlet
