#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "swiftlet/box_graph_view.hpp"
#include "swiftlet/status.hpp"
#include "swiftlet/trajectory.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// An obstacle that is not in the map.
struct BlockedBox {
  std::uint32_t id = 0;
  IntBox box{};  ///< [unit] grown by the map's radius on every side and outward to whole units; empty off the map
};

/// A cell of the map that blocked boxes cut: what is left of it are `count` pieces from `first` on.
struct CutCell {
  std::uint32_t cell = 0;
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};
struct CutPiece {
  IntBox box{};
  std::uint32_t cell = 0;  ///< of the map, that it was cut from
};

/// Memory of a BlockedSpace; contents irrelevant. `found` holds at least as many elements as `cells`.
struct BlockedSpans {
  std::span<BlockedBox> boxes;
  std::span<CutCell> cells;
  std::span<CutPiece> pieces;
  std::span<CellIndex> found;
};

/// Memory for up to `kBoxes` obstacles that cut up to `kCells` cells, trivially destructible.
template <std::size_t kBoxes, std::size_t kCells>
class BlockedStorage {
 public:
  BlockedSpans spans() { return {boxes_, cells_, pieces_, found_}; }

 private:
  std::array<BlockedBox, kBoxes> boxes_;
  std::array<CutCell, kCells> cells_;
  std::array<CutPiece, 6 * kCells> pieces_;
  std::array<CellIndex, kCells> found_;
};

/// A map with obstacles that come and go at run time. `view()` is the map without what they block: their cells are cut
/// into boxes that keep the map's radius from them, and extents are cut back, so search, corridor and certificate are
/// those of any map. The map itself is not touched; it outlives this object.
class BlockedSpace {
 public:
  BlockedSpace(const BoxGraphView& map, const BlockedSpans& spans) : map_(map), spans_(spans) {}

  /// Blocks `obstacle` [m] (frame W) and everything nearer to it than the map's radius; an id that is known is moved.
  /// Errors, nothing having changed: kBadRequest (not finite, lo > hi), kBufferTooSmall (too many boxes, cut cells or
  /// pieces: the obstacle is NOT kept out of, so stop).
  Status add(std::uint32_t id, const Box& obstacle);

  /// Unblocks; false when there was no such id.
  bool remove(std::uint32_t id);

  [[nodiscard]] std::span<const BlockedBox> boxes() const { return spans_.boxes.first(box_count_); }

  /// The map without what is blocked. Good until the next add or remove; indices from the map's cell count on are
  /// pieces.
  [[nodiscard]] BoxGraphView view() const { return map_.with_blocked(box_count_ > 0 ? this : nullptr); }

  /// True when the inside of `box` meets a blocked box.
  [[nodiscard]] bool meets(const IntBox& box) const;

  /// True when a trajectory enters a blocked box after path time `from` [s] by more than the certificate's tolerance;
  /// false only when it is proven to stay out, by Bernstein hulls with subdivision.
  [[nodiscard]] bool meets(std::span<const Segment> segments, Real from) const;

  // For BoxGraphView and visit_neighbours.
  /// What is left of a cell of the map; nullptr when it is whole.
  [[nodiscard]] const CutCell* cut(CellIndex cell) const;
  [[nodiscard]] std::span<const CutPiece> pieces() const { return spans_.pieces.first(piece_count_); }
  /// The largest part, one face moved for each blocked box, of a free `extent` that holds `keep` and meets none.
  [[nodiscard]] IntBox cut_back(IntBox extent, const IntBox& keep) const;

 private:
  [[nodiscard]] IntBox inflated(const Box& obstacle) const;
  bool rebuild();
  bool collect_cells();
  bool cut_cell(CutCell& cell);
  bool cut_piece(std::size_t index, const IntBox& hole);

  BoxGraphView map_;
  BlockedSpans spans_;
  std::size_t box_count_ = 0;
  std::size_t cut_count_ = 0;
  std::size_t piece_count_ = 0;
};

/// Calls visit(CellIndex, IntBox) for every cell or piece that shares a window with `cell`, until one returns false;
/// then returns false. The order is the same on every machine.
template <typename Visit>
bool visit_neighbours(const BoxGraphView& graph, CellIndex cell, const Visit& visit) {
  const BlockedSpace* blocked = graph.blocked();
  if (blocked == nullptr) {
    for (const CellIndex neighbour : graph.neighbours(cell)) {
      if (!visit(neighbour, graph.cell(neighbour))) return false;
    }
    return true;
  }
  const IntBox box = graph.cell(cell);
  const auto visit_pieces = [&](const CutCell& whole) {
    for (std::uint32_t k = whole.first; k < whole.first + whole.count; ++k) {
      const auto index = static_cast<CellIndex>(graph.cell_count() + k);
      const IntBox& piece = blocked->pieces()[k].box;
      if (index != cell && is_passage(intersection(box, piece)) && !visit(index, piece)) return false;
    }
    return true;
  };
  const CellIndex whole = graph.map_cell(cell);
  const CutCell* own = blocked->cut(whole);
  if (own != nullptr && !visit_pieces(*own)) return false;
  for (const CellIndex neighbour : graph.neighbours(whole)) {
    const CutCell* cut = blocked->cut(neighbour);
    if (cut != nullptr) {
      if (!visit_pieces(*cut)) return false;
    } else {
      const IntBox other = graph.cell(neighbour);
      if (is_passage(intersection(box, other)) && !visit(neighbour, other)) return false;
    }
  }
  return true;
}

}  // namespace swiftlet
