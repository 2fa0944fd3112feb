#pragma once
#include <array>
#include <cstddef>
#include <span>

#include "swiftlet/flight_limits.hpp"
#include "swiftlet/trajectory.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// From motion to rest within one box: the answer that exists without any solver. Each axis brakes by itself, its
/// acceleration linear in time over three phases (down to a level, along it, back to zero), as gently as its room
/// affords. With no initial acceleration the way is 0.51 to 1 times v^2 / a.

inline constexpr std::size_t kMostBrakePieces = 9;  ///< three phases an axis, cut where any axis changes phase

struct Braking {
  std::array<Segment, kMostBrakePieces> pieces;
  std::size_t count = 0;  ///< 0 where some axis lacks room
  std::size_t axis = 0;   ///< the axis that lacks most of it
  Real missing = 0;       ///< [m] by which its room falls short of the shortest braking
};

/// Bounds hold for each axis (jerk included); those of norms are the caller's to split. Cost O(1).
Braking brake_within(const Box& box, const State& start, const Vector3& v_max, const Vector3& a_max, Real j_max);

}  // namespace swiftlet
