#pragma once
#include <span>

#include "swiftlet/types.hpp"

namespace swiftlet {

/// What happens to the window between cell i and cell i + 1 (Sec. IV-E, Fig. 8).
enum class Relaxation : std::uint8_t {
  kNone,      ///< stays a window: neither face covers the other, or case 6 on windows that are not opposite
  kForward,   ///< cell i is extruded through the window over the depth of cell i + 1 (eq. 15)
  kBackward,  ///< cell i + 1 is extruded back through the window over the depth of cell i (eq. 14)
};

/// Runs the state machine over a chain of cells and extrudes them in place. A cell may be extruded only when its whole
/// face lies inside the neighbour's face, so every extruded box stays inside the union of the cells; containment of
/// faces decides, not volume, and equal faces go forward. A cell is extruded at both ends only when its two windows lie
/// on opposite faces (case 6 of Fig. 7 otherwise). Afterwards the gate between two boxes is their whole intersection.
///   cells      M boxes [unit], consecutive ones sharing a window; become the segments' boxes
///   decisions  M - 1 elements, or empty when the caller does not want them
void relax_windows(std::span<IntBox> cells, std::span<Relaxation> decisions);

}  // namespace swiftlet
