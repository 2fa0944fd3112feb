#include "swiftlet/interior_knots.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

/// Pieces of a leg that is `length` long.
std::size_t pieces_of(Real length, Real longest_leg) {
  std::size_t pieces = 1;
  while (pieces < kMostPieces && length > longest_leg * static_cast<Real>(pieces)) ++pieces;
  return pieces;
}

Real leg_length(std::span<const Vector3> points, std::size_t leg) {
  return (points[leg + 1] - points[leg]).cwiseAbs().maxCoeff();
}

std::size_t room_of(const KnottedCorridor& corridor) {
  return std::min(
      {corridor.int_boxes.size(), corridor.boxes.size(), corridor.gates.size() + 1, corridor.points.size() - 1});
}

}  // namespace

std::size_t insert_knots(const KnottedCorridor& corridor, std::size_t count, Real longest_leg, std::size_t legs) {
  const std::size_t room = room_of(corridor);
  const auto pieces_at = [&](std::size_t i) {
    return i < legs ? pieces_of(leg_length(corridor.points, i), longest_leg) : std::size_t{1};
  };
  std::size_t wanted = 0;
  for (std::size_t i = 0; i < count; ++i) wanted += pieces_at(i);
  if (wanted > room) return count;
  // From the back, so that nothing is overwritten before it has moved.
  std::size_t end = wanted;
  for (std::size_t i = count; i-- > 0;) {
    const Vector3 from = corridor.points[i];
    const Vector3 to = corridor.points[i + 1];
    const IntBox int_box = corridor.int_boxes[i];
    const Box box = corridor.boxes[i];
    const std::size_t pieces = pieces_at(i);
    if (end < wanted) corridor.gates[end - 1] = corridor.gates[i];
    corridor.points[end] = to;
    for (std::size_t k = 1; k <= pieces; ++k) {
      corridor.int_boxes[end - k] = int_box;
      corridor.boxes[end - k] = box;
      if (k == pieces) continue;
      corridor.gates[end - k - 1] = box;
      corridor.points[end - k] = to + (from - to) * (static_cast<Real>(k) / static_cast<Real>(pieces));
    }
    end -= pieces;
  }
  return wanted;
}

bool repeat_first_box(const KnottedCorridor& corridor, std::size_t count, std::size_t copies) {
  if (count + copies > room_of(corridor)) return false;
  corridor.points[count + copies] = corridor.points[count];
  for (std::size_t i = count; i-- > 0;) {
    corridor.int_boxes[i + copies] = corridor.int_boxes[i];
    corridor.boxes[i + copies] = corridor.boxes[i];
    if (i > 0) corridor.gates[i + copies - 1] = corridor.gates[i - 1];
    if (i > 0) corridor.points[i + copies] = corridor.points[i];
  }
  for (std::size_t i = 0; i < copies; ++i) {
    corridor.int_boxes[i] = corridor.int_boxes[copies];
    corridor.boxes[i] = corridor.boxes[copies];
    corridor.gates[i] = corridor.boxes[copies];
  }
  return true;
}

void split_segment(const Segment& segment, std::span<Segment> pieces) {
  const Segment whole = segment;  // may be one of the pieces
  const Real T = whole.duration / static_cast<Real>(pieces.size());
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Real t = T * static_cast<Real>(i);
    pieces[i].duration = T;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // Taylor coefficients at t by repeated Horner division.
      std::array<Real, kQuinticTerms> c = whole.coefficients[axis];
      for (std::size_t low = 0; low + 1 < kQuinticTerms; ++low) {
        for (std::size_t j = kQuinticTerms - 1; j-- > low;) c[j] += t * c[j + 1];
      }
      pieces[i].coefficients[axis] = c;
    }
  }
}

}  // namespace swiftlet
