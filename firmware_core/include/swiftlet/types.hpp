#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

namespace swiftlet {

/// The scalar of the whole core: double, or float where SWIFTLET_REAL_FLOAT is defined (a PUBLIC definition of
/// swiftlet::core, so that every user has the same ABI).
#ifdef SWIFTLET_REAL_FLOAT
using Real = float;
#else
using Real = double;
#endif

using Vector3 = Eigen::Matrix<Real, 3, 1>;

/// Standard gravity [m/s^2].
inline constexpr Real kGravity = Real(9.80665);

/// Axis-aligned closed box in frame W (ENU) [m]; lo <= hi on every axis, equality where it is thin.
struct Box {
  Vector3 lo;
  Vector3 hi;
};

/// The same box in blob units relative to the map origin: exact, and the source of every `Box` that a map yields.
struct IntBox {
  std::array<std::uint16_t, 3> lo;
  std::array<std::uint16_t, 3> hi;
  friend bool operator==(const IntBox&, const IntBox&) = default;
};

/// Index of a cell of the map's partition.
enum class CellIndex : std::uint32_t {};
constexpr std::size_t to_size(CellIndex cell) { return static_cast<std::size_t>(cell); }

/// Position [m], velocity [m/s] and acceleration [m/s^2] in frame W.
struct State {
  Vector3 position = Vector3::Zero();
  Vector3 velocity = Vector3::Zero();
  Vector3 acceleration = Vector3::Zero();
};

/// The common part of two closed boxes; lo > hi on some axis when they do not meet.
inline IntBox intersection(const IntBox& a, const IntBox& b) {
  IntBox common{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    common.lo[axis] = a.lo[axis] > b.lo[axis] ? a.lo[axis] : b.lo[axis];
    common.hi[axis] = a.hi[axis] < b.hi[axis] ? a.hi[axis] : b.hi[axis];
  }
  return common;
}

/// True when `common` (as `intersection` returns it) is a passage: boxes that touch, with positive extent on at least
/// two axes. An edge or a corner contact is no passage.
inline bool is_passage(const IntBox& common) {
  int wide_axes = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (common.lo[axis] > common.hi[axis]) return false;
    wide_axes += common.lo[axis] < common.hi[axis] ? 1 : 0;
  }
  return wide_axes >= 2;
}

/// True when every point of `inner` lies in `outer`.
inline bool contains(const IntBox& outer, const IntBox& inner) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (inner.lo[axis] < outer.lo[axis] || inner.hi[axis] > outer.hi[axis]) return false;
  }
  return true;
}

}  // namespace swiftlet
