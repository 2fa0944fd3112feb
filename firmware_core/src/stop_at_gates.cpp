#include "swiftlet/stop_at_gates.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

// Peaks of a rest-to-rest quintic over 1 m in 1 s, rounded up.
constexpr Real kPeakSpeed = Real(1.875);
constexpr Real kPeakAcceleration = Real(5.7736);  // 10 / sqrt(3)
constexpr Real kPeakJerk = 60;
constexpr Real kSlack = 1 + Real(sizeof(Real) == 8 ? 1e-6 : 1e-5);
constexpr Real kShortest = Real(1e-3);  // [s]

/// Shortest time [s] for a straight leg of this length within bounds of the same kind as the length.
Real leg_duration(Real length, Real v_max, Real a_max, Real j_max) {
  return kSlack * std::max({kPeakSpeed * length / v_max, std::sqrt(kPeakAcceleration * length / a_max),
                            j_max < kUnlimited ? cube_root(kPeakJerk * length / j_max) : Real(0)});
}

Segment rest_to_rest(const Vector3& from, const Vector3& to, Real T) {
  Segment segment;
  segment.duration = T;
  const Real T3 = T * T * T;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<Eigen::Index>(axis);
    const Real distance = to[row] - from[row];
    segment.coefficients[axis] = {
        from[row], 0, 0, 10 * distance / T3, -15 * distance / (T3 * T), 6 * distance / (T3 * T * T)};
  }
  return segment;
}

}  // namespace

void stop_at_gates(std::span<const Vector3> points, const MotionBounds& bounds, std::span<Segment> segments) {
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Vector3 leg = points[i + 1] - points[i];
    const Real T =
        std::max({kShortest, leg_duration(leg.cwiseAbs().maxCoeff(), bounds.v.axis, bounds.a.axis, bounds.j.axis),
                  leg_duration(leg.norm(), bounds.v.norm, bounds.a.norm, bounds.j.norm)});
    segments[i] = rest_to_rest(points[i], points[i + 1], T);
  }
}

void stop_at_gates(std::span<const Vector3> points, const Vector3& v_max, const Vector3& a_max,
                   std::span<Segment> segments) {
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Vector3 leg = points[i + 1] - points[i];
    Real T = kShortest;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      T = std::max(T, leg_duration(std::fabs(leg[axis]), v_max[axis], a_max[axis], kUnlimited));
    }
    segments[i] = rest_to_rest(points[i], points[i + 1], T);
  }
}

}  // namespace swiftlet
