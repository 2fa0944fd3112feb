#include "swiftlet/axis_bounds.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/quintic.hpp"

namespace swiftlet {
namespace {

using ControlPoints = std::array<Real, 6>;

struct Range {
  Real least;
  Real most;
  void add(Real value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
  [[nodiscard]] bool lies_in(const Range& outer) const { return least >= outer.least && most <= outer.most; }
};

/// The positions that a segment may take, tolerance included.
Range allowed_positions(const AxisBounds& bounds, std::size_t segment) {
  return {bounds.lower(segment, 0) - bounds.tolerance(), bounds.upper(segment, 0) + bounds.tolerance()};
}

/// Control points of the next derivative, but for its unit.
void differentiate(ControlPoints& points) {
  for (std::size_t i = 0; i + 1 < points.size(); ++i) points[i] = points[i + 1] - points[i];
}

/// Range of the first `count` control points of each of the two halves (de Casteljau).
Range hull_of_halves(ControlPoints points, std::size_t count) {
  Range range{points[0], points[0]};
  for (; count > 0; --count) {
    range.add(points[0]);
    range.add(points[count - 1]);
    for (std::size_t i = 0; i + 1 < count; ++i) points[i] = (points[i] + points[i + 1]) / 2;
  }
  return range;
}

/// The worst violation of one segment while its derivatives are searched.
class WorstViolation {
 public:
  WorstViolation(const AxisBounds& bounds, std::size_t segment, Violation& worst)
      : bounds_(bounds), segment_(segment), worst_(worst) {}

  void check_extrema(const Quintic& quintic, int derivative) {
    const CriticalPoints inner = critical_points(quintic, derivative);
    for (std::size_t i = 0; i < inner.count; ++i) check_point(quintic, derivative, inner.tau[i]);
    // Junctions: once, from the segment on their right; the two ends of the trajectory belong to their only segment.
    check_point(quintic, derivative, 0);
    if (segment_ + 1 == bounds_.axis.segment_count()) check_point(quintic, derivative, 1);
  }

  [[nodiscard]] bool exists() const { return worst_ratio_ > 0; }

 private:
  void check_point(const Quintic& quintic, int derivative, Real tau) {
    Real value = quintic_value(quintic, derivative, tau);
    for (int d = 0; d < derivative; ++d) value /= bounds_.axis.durations[segment_];
    const Real lo = bounds_.lower(segment_, derivative);
    const Real hi = bounds_.upper(segment_, derivative);
    const Real excess = std::max(value - hi, lo - value);
    const Real scale = derivative == 0 ? Real(1) : hi;
    if (!(excess > bounds_.tolerance()) || excess / scale <= worst_ratio_) return;
    worst_ratio_ = excess / scale;
    const bool above = value - hi >= lo - value;
    worst_ = {static_cast<std::uint32_t>(segment_),
              static_cast<std::uint8_t>(derivative),
              tau,
              above ? Real(1) : Real(-1),
              above ? hi : lo,
              excess};
  }

  const AxisBounds& bounds_;
  std::size_t segment_;
  Violation& worst_;
  Real worst_ratio_ = 0;
};

}  // namespace

SegmentSweep::SegmentSweep(const AxisBounds& bounds)
    : bounds_(bounds),
      largest_difference_{(bounds.upper(0, 1) + bounds.tolerance()) / 5,
                          (bounds.upper(0, 2) + bounds.tolerance()) / 20} {}

std::array<bool, 3> SegmentSweep::suspects(std::size_t segment, const QuinticEnds& ends) const {
  // Of the quintic, its differences and theirs; in scalars, where the compiler would pair them badly.
  const auto [p0, p1, p2, p3, p4, p5] = quintic_control_points(ends);
  const Real v0 = p1 - p0, v1 = p2 - p1, v2 = p3 - p2, v3 = p4 - p3, v4 = p5 - p4;
  const Real least = std::min(std::min(std::min(p0, p1), std::min(p2, p3)), std::min(p4, p5));
  const Real most = std::max(std::max(std::max(p0, p1), std::max(p2, p3)), std::max(p4, p5));
  const Real speed =
      std::max(std::max(std::max(std::fabs(v0), std::fabs(v1)), std::max(std::fabs(v2), std::fabs(v3))), std::fabs(v4));
  const Real acceleration =
      std::max(std::max(std::fabs(v1 - v0), std::fabs(v2 - v1)), std::max(std::fabs(v3 - v2), std::fabs(v4 - v3)));
  const Real T = bounds_.axis.durations[segment];
  return {!Range{least, most}.lies_in(allowed_positions(bounds_, segment)), !(speed <= largest_difference_[0] * T),
          !(acceleration <= largest_difference_[1] * (T * T))};
}

bool SegmentSweep::find_worst_of(const std::array<bool, 3>& suspect, std::size_t segment, const QuinticEnds& ends,
                                 Violation& violation) const {
  const Real T = bounds_.axis.durations[segment];
  const Quintic quintic = quintic_from_ends(ends);
  ControlPoints points = quintic_control_points(ends);
  const Real v = largest_difference_[0] * T;
  const Real a = largest_difference_[1] * (T * T);
  const std::array<Range, 3> allowed{allowed_positions(bounds_, segment), Range{-v, v}, Range{-a, a}};
  WorstViolation worst(bounds_, segment, violation);
  for (int derivative = 0; derivative <= 2; ++derivative) {
    if (suspect[static_cast<std::size_t>(derivative)] &&
        !hull_of_halves(points, points.size() - static_cast<std::size_t>(derivative))
             .lies_in(allowed[static_cast<std::size_t>(derivative)])) {
      worst.check_extrema(quintic, derivative);
    }
    differentiate(points);
  }
  return worst.exists();
}

}  // namespace swiftlet
