#include "fly/floor.hpp"

#include <algorithm>

namespace swiftlet::tools {
namespace {

/// Height of the lowest point from which all is free up to `p_W`, within kPadDrop.
double lowest_free(const BoxGraphView& map, const Vector3& p_W) {
  constexpr double kStep = 0.01;  // [m]
  Vector3 p = p_W;
  while (p.z() - kStep >= p_W.z() - Floor::kPadDrop && map.locate(p - kStep * Vector3::UnitZ())) p.z() -= kStep;
  return p.z();
}

}  // namespace

Floor::Floor(const BoxGraphView& map, std::vector<Box> obstacles, const Vector3& start_W)
    : obstacles_(std::move(obstacles)), lowest_(map.header().origin[2] - kBelowMap), pad_(start_W) {
  const double reach = lowest_free(map, start_W) - map.header().radius;
  pad_.z() = std::max({obstacle_below(start_W), start_W.z() - kPadDrop, reach});
}

double Floor::below(const Vector3& p_W) const {
  const bool over_pad = has_pad_ && (p_W - pad_).head<2>().cwiseAbs().maxCoeff() <= kPadSize / 2 && p_W.z() >= pad_.z();
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
