#include "swiftlet/trajectory.hpp"

#include <cmath>

namespace swiftlet {

Sample sample_segment(const Segment& segment, Real t) {
  Sample sample;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::array<Real, kQuinticTerms>& c = segment.coefficients[axis];
    const auto row = static_cast<Eigen::Index>(axis);
    sample.position[row] = ((((c[5] * t + c[4]) * t + c[3]) * t + c[2]) * t + c[1]) * t + c[0];
    sample.velocity[row] = (((5 * c[5] * t + 4 * c[4]) * t + 3 * c[3]) * t + 2 * c[2]) * t + c[1];
    sample.acceleration[row] = ((20 * c[5] * t + 12 * c[4]) * t + 6 * c[3]) * t + 2 * c[2];
    sample.jerk[row] = (60 * c[5] * t + 24 * c[4]) * t + 6 * c[3];
  }
  return sample;
}

Sample sample_trajectory(std::span<const Segment> segments, Real t) {
  std::size_t i = 0;
  while (i + 1 < segments.size() && t > segments[i].duration) t -= segments[i++].duration;
  const Real local = t < 0 ? Real(0) : t;
  return sample_segment(segments[i], local < segments[i].duration ? local : segments[i].duration);
}

Real total_duration(std::span<const Segment> segments) {
  Real sum = 0;
  for (const Segment& segment : segments) sum += segment.duration;
  return sum;
}

Real jerk_cost(std::span<const Segment> segments, std::size_t axis) {
  Real sum = 0;
  for (const Segment& segment : segments) {
    const Real T = segment.duration;
    const std::array<Real, kQuinticTerms>& c = segment.coefficients[axis];
    // Jerk j0 + j1 s + j2 s^2 with s = t / T; the integral of its square over [0, T].
    const Real j0 = 6 * c[3];
    const Real j1 = 24 * c[4] * T;
    const Real j2 = 60 * c[5] * T * T;
    sum += T * (j0 * j0 + j0 * j1 + (j1 * j1 + 2 * j0 * j2) / 3 + j1 * j2 / 2 + j2 * j2 / 5);
  }
  return sum;
}

Real arc_length(std::span<const Segment> segments) {
  constexpr int kPieces = 16;
  constexpr std::array<Real, 3> kNode{Real(-0.774596669241483377), Real(0), Real(0.774596669241483377)};
  constexpr std::array<Real, 3> kWeight{Real(5) / 18, Real(8) / 18, Real(5) / 18};
  Real length = 0;
  for (const Segment& segment : segments) {
    const Real piece = segment.duration / kPieces;
    for (int i = 0; i < kPieces; ++i) {
      for (std::size_t k = 0; k < kNode.size(); ++k) {
        const Real t = piece * (static_cast<Real>(i) + (1 + kNode[k]) / 2);
        length += kWeight[k] * piece * sample_segment(segment, t).velocity.norm();
      }
    }
  }
  return length;
}

}  // namespace swiftlet
