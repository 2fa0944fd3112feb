#pragma once
#include <array>
#include <span>

#include "swiftlet/types.hpp"

namespace swiftlet::tools {

/// Boxes on the grid of a map: a corner i lies at origin + unit * i in frame W.
struct GridBoxes {
  std::array<double, 3> origin{};  ///< [m]
  double unit = 0;                 ///< [m]
  double resolution = 0;           ///< [m] edge of a voxel, a multiple of the unit
  std::span<const IntBox> boxes;   ///< [unit], disjoint
};

}  // namespace swiftlet::tools
