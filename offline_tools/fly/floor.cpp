#include "fly/floor.hpp"

#include <algorithm>

namespace swiftlet::tools {

Floor::Floor(std::vector<Box> obstacles, const Box& bounds, const Vector3& start_W)
    : obstacles_(std::move(obstacles)), lowest_(bounds.lo.z()), pad_(start_W) {
  pad_.z() = std::max(obstacle_below(start_W), start_W.z() - kPadDrop);
}

double Floor::below(const Vector3& p_W) const {
  const bool over_pad = (p_W - pad_).head<2>().cwiseAbs().maxCoeff() <= kPadSize / 2 && p_W.z() >= pad_.z();
  return over_pad ? pad_.z() : obstacle_below(p_W);
}

double Floor::obstacle_below(const Vector3& p_W) const {
  double height = std::min(lowest_, p_W.z());
  for (const Box& box : obstacles_) {
    const bool covers =
        p_W.x() >= box.lo.x() && p_W.x() <= box.hi.x() && p_W.y() >= box.lo.y() && p_W.y() <= box.hi.y();
    if (covers && box.hi.z() <= p_W.z()) height = std::max(height, box.hi.z());
  }
  return height;
}

}  // namespace swiftlet::tools
