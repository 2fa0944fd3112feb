#pragma once
#include <span>

#include "swiftlet/flight_limits.hpp"
#include "swiftlet/trajectory.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet::companion {

/// How far the margins let a vehicle go from where the frames were tied: level, since an error of the heading turns
/// about the vertical there.
struct Reach {
  Vector3 centre = Vector3::Zero();  ///< [m] frame W
  Real distance = kUnlimited;        ///< [m]

  [[nodiscard]] Real distance_to(const Vector3& point) const { return (point - centre).head<2>().norm(); }
  [[nodiscard]] bool covers(const Vector3& point) const { return distance_to(point) <= distance; }
  /// False unless it is proven: by the hulls of the control points.
  [[nodiscard]] bool covers(std::span<const Segment> segments) const;
};

}  // namespace swiftlet::companion
