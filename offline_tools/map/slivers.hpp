#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "map/bit_grid.hpp"

namespace swiftlet::tools {

/// Drops cells that are at most `thickness` units thick and that no way needs: for any two of a cell's neighbours the
/// way from window to window through it, centre to centre, has a substitute through other cells that is at most
/// `tolerance` units longer (a local witness search, as in contraction hierarchies). The smallest cells go first, and
/// each is judged against what is left, so no connection is ever lost and a cell without windows always stays; the
/// tolerance is for one cell, so a way past many may grow by more. Returns the dropped volume [unit^3]; the order of
/// the other cells is kept. Deterministic.
std::uint64_t drop_slivers(std::vector<GridBox>& cells, std::int32_t thickness, double tolerance,
                           const std::function<void(double)>& done);

}  // namespace swiftlet::tools
