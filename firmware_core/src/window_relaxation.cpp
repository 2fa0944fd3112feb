#include "swiftlet/window_relaxation.hpp"

#include <algorithm>

#include "swiftlet/assert.hpp"

namespace swiftlet {
namespace {

/// Where two adjacent cells touch, seen from the first one.
struct Face {
  std::size_t axis = 0;  ///< on which the window has no thickness; 3: the cells share no window
  bool high = false;     ///< on the first cell's upper side
};
constexpr std::size_t kNoAxis = 3;

Face shared_face(const IntBox& from, const IntBox& to) {
  const IntBox window = intersection(from, to);
  if (!is_passage(window)) return {kNoAxis, false};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (window.lo[axis] == window.hi[axis]) return {axis, window.lo[axis] == from.hi[axis]};
  }
  return {kNoAxis, false};
}

/// True when the cross-section of `inner` on the two axes other than `axis` lies inside that of `outer`.
bool face_lies_inside(const IntBox& inner, const IntBox& outer, std::size_t axis) {
  for (std::size_t other = 0; other < 3; ++other) {
    if (other == axis) continue;
    if (inner.lo[other] < outer.lo[other] || inner.hi[other] > outer.hi[other]) return false;
  }
  return true;
}

void extrude(IntBox& box, const IntBox& over, std::size_t axis) {
  box.lo[axis] = std::min(box.lo[axis], over.lo[axis]);
  box.hi[axis] = std::max(box.hi[axis], over.hi[axis]);
}

/// The state of the machine of Fig. 8 at cell i: how its entry window was treated, and on which face that window lies.
struct Entry {
  Relaxation relaxation = Relaxation::kNone;
  Face face;
};

Relaxation decide(const IntBox& here, const IntBox& next, const Entry& entry, const Face& exit) {
  if (exit.axis == kNoAxis) return Relaxation::kNone;
  if (face_lies_inside(here, next, exit.axis)) {
    // Backward, then forward is case 6: extruded along two axes the box would gain a corner that no cell covers.
    const bool opposite = entry.face.axis == exit.axis && entry.face.high != exit.high;
    const bool allowed = entry.relaxation != Relaxation::kBackward || opposite;
    return allowed ? Relaxation::kForward : Relaxation::kNone;
  }
  return face_lies_inside(next, here, exit.axis) ? Relaxation::kBackward : Relaxation::kNone;
}

}  // namespace

void relax_windows(std::span<IntBox> cells, std::span<Relaxation> decisions) {
  SWIFTLET_ASSERT(decisions.empty() || decisions.size() + 1 >= cells.size());
  if (cells.empty()) return;
  Entry entry;
  IntBox here = cells[0];  // as the map has it; cells[i] may have been extruded backward already
  for (std::size_t i = 0; i + 1 < cells.size(); ++i) {
    const IntBox next = cells[i + 1];
    const Face exit = shared_face(here, next);
    const Relaxation relaxation = decide(here, next, entry, exit);
    if (relaxation == Relaxation::kForward) extrude(cells[i], next, exit.axis);
    if (relaxation == Relaxation::kBackward) extrude(cells[i + 1], here, exit.axis);
    if (!decisions.empty()) decisions[i] = relaxation;
    entry = {relaxation, {exit.axis, !exit.high}};
    here = next;
  }
}

}  // namespace swiftlet
