#pragma once
#include <cstddef>
#include <limits>
#include <span>

#include "swiftlet/trajectory.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// One quintic cannot accelerate, cruise and brake: over a long box it reaches the speed limit at its middle only. A
/// box whose leg of the taut path is long is therefore repeated, and the gate between two copies is the box itself.

/// A corridor with the points of its taut path, in buffers that may grow to their full size.
struct KnottedCorridor {
  std::span<IntBox> int_boxes;  ///< [unit]
  std::span<Box> boxes;         ///< [m]
  std::span<Box> gates;         ///< [m]
  std::span<Vector3> points;    ///< one more than boxes [m]
};

/// Repeats boxes so that no straight piece between two points is longer than `longest_leg` [m] (largest axis), at most
/// `kMostPieces` pieces a box and as far as the buffers reach; the pieces of a leg are equally long.
///   count   boxes in use, at least one
///   legs    only the first so many legs are looked at
/// Returns the number of boxes afterwards. Cost O(M).
inline constexpr std::size_t kMostPieces = 3;
std::size_t insert_knots(const KnottedCorridor& corridor, std::size_t count, Real longest_leg,
                         std::size_t legs = std::numeric_limits<std::size_t>::max());

/// Puts `copies` more of the first box in front, with gates that are the box itself; points 1 to `copies` are left to
/// the caller. False, and nothing done, where the buffers are too short. Cost O(M).
bool repeat_first_box(const KnottedCorridor& corridor, std::size_t count, std::size_t copies);

/// True when junction k (between boxes k and k + 1) is such a knot and not a gate.
inline bool is_knot(std::span<const IntBox> int_boxes, std::size_t k) { return int_boxes[k] == int_boxes[k + 1]; }

/// Splits a segment into pieces of equal duration that together are the same polynomial, to rounding.
void split_segment(const Segment& segment, std::span<Segment> pieces);

}  // namespace swiftlet
