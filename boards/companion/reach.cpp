#include "companion/reach.hpp"

#include "swiftlet/quintic.hpp"

namespace swiftlet::companion {

bool Reach::covers(std::span<const Segment> segments) const {
  if (distance == kUnlimited) return true;
  for (const Segment& segment : segments) {
    const Real t = segment.duration;
    const Sample a = sample_segment(segment, 0);
    const Sample b = sample_segment(segment, t);
    const auto points = [&](Eigen::Index axis) {
      return quintic_control_points({a.position[axis], a.velocity[axis] * t, a.acceleration[axis] * t * t,
                                     b.position[axis], b.velocity[axis] * t, b.acceleration[axis] * t * t});
    };
    const auto x = points(0);
    const auto y = points(1);
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (!covers(Vector3{x[i], y[i], 0})) return false;
    }
  }
  return true;
}

}  // namespace swiftlet::companion
