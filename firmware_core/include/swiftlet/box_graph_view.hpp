#pragma once
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>

#include "swiftlet/box_graph_format.hpp"
#include "swiftlet/status.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// zlib's CRC-32 over a blob of at least a header's size, with its own field taken as zero.
std::uint32_t blob_crc32(std::span<const std::byte> blob);

/// The neighbours of one cell, ascending, decoded while they are walked over. Lives as long as the blob.
class NeighbourRange {
 public:
  class Iterator {
   public:
    // NOLINTBEGIN(readability-identifier-naming): the names of the standard library
    using iterator_category = std::forward_iterator_tag;
    using value_type = CellIndex;
    using difference_type = std::ptrdiff_t;
    using pointer = const CellIndex*;
    using reference = CellIndex;
    // NOLINTEND(readability-identifier-naming)

    Iterator() = default;
    CellIndex operator*() const { return static_cast<CellIndex>(value_); }
    Iterator& operator++();
    Iterator operator++(int) {
      const Iterator before = *this;
      ++*this;
      return before;
    }
    /// How many neighbours are left, this one included.
    [[nodiscard]] std::uint32_t remaining() const { return remaining_; }
    /// Iterators of the same range are equal when as many neighbours remain.
    friend bool operator==(const Iterator& a, const Iterator& b) { return a.remaining_ == b.remaining_; }

   private:
    friend class NeighbourRange;
    const std::byte* at_ = nullptr;  ///< behind the last number read
    std::uint32_t remaining_ = 0;    ///< including the current one
    std::uint32_t value_ = 0;
  };

  NeighbourRange(CellIndex cell, const std::byte* record);
  [[nodiscard]] Iterator begin() const { return begin_; }
  [[nodiscard]] Iterator end() const { return {}; }
  [[nodiscard]] std::size_t size() const { return begin_.remaining_; }
  [[nodiscard]] bool empty() const { return size() == 0; }

 private:
  Iterator begin_;
};

/// The stored distances of one window from the landmarks of its component, over window centres. Lives as
/// long as the blob.
class LandmarkRow {
 public:
  explicit LandmarkRow(const std::byte* first) : first_(first) {}
  /// Distance [unit / 2^landmark_shift] from landmark k, to the nearest.
  std::uint16_t operator[](std::size_t k) const {
    return static_cast<std::uint16_t>(std::to_integer<unsigned>(first_[2 * k]) |
                                      std::to_integer<unsigned>(first_[2 * k + 1]) << 8U);
  }

 private:
  const std::byte* first_;
};
class BlockedSpace;

/// Read-only view of a map blob (docs/map_format.md), read in place: flash, mmap or any 8-byte aligned memory that
/// outlives the view. A view exists only if its blob was valid, so every accessor is plain and cannot leave the blob.
class BoxGraphView {
 public:
  /// A view of nothing; only `open` makes a useful one.
  BoxGraphView() = default;

  /// Validates size, header, CRC and every index, once: after it no call can leave the blob or loop without end. That
  /// cells are disjoint and free is the builder's promise (`swiftlet map verify`), not checked here. `blob` starts at
  /// the header and may be longer than the blob, as a flash sector is. Cost: one pass for the checksum, then one over
  /// cells, records (which look up each neighbour's cell) and index.
  /// Errors: kBadRequest (not 8-byte aligned), kBlobTruncated, kBlobWrongMagic, kBlobWrongByteOrder, kBlobWrongVersion,
  /// kBlobDamaged, kBlobInconsistent.
  static Result<BoxGraphView> open(std::span<const std::byte> blob);

  [[nodiscard]] const BlobHeader& header() const { return *header_; }
  [[nodiscard]] std::size_t cell_count() const { return header_->cell_count; }
  [[nodiscard]] double unit() const { return unit_; }  ///< [m], resolution / 2^unit_shift

  /// The cell itself: cells are disjoint but for their faces.
  [[nodiscard]] IntBox cell(CellIndex cell) const;
  /// The free box grown around the cell; contains it. Extents overlap. Cost O(number of neighbours): for corridors, not
  /// for searching.
  [[nodiscard]] IntBox extent(CellIndex cell) const;
  /// Cells that share a window with `cell`, ascending.
  [[nodiscard]] NeighbourRange neighbours(CellIndex cell) const { return {cell, record(cell)}; }
  /// Label of the connected component of free space; two cells with different labels are not connected.
  [[nodiscard]] std::uint16_t component(CellIndex cell) const;

  /// True when the windows of this component carry landmark distances: those of the largest one do, unless something is
  /// blocked, since windows of pieces have none.
  [[nodiscard]] bool has_landmarks(std::uint16_t component) const {
    return component == 0 && header_->landmark_count > 0 && blocked_ == nullptr;
  }
  /// The landmark distances of the window from `cell` to the neighbour that `at` stands on, of a higher index. For
  /// components that have landmarks only.
  [[nodiscard]] LandmarkRow landmarks(CellIndex cell, const NeighbourRange::Iterator& at) const {
    return LandmarkRow(record_end(cell) - 2 * std::size_t{header_->landmark_count} * at.remaining());
  }
  /// The same for two neighbouring cells in either order. Cost O(number of neighbours).
  [[nodiscard]] LandmarkRow landmarks(CellIndex a, CellIndex b) const;

  /// The occupied voxels, packed for the offline tools (docs/map_format.md); opaque here.
  [[nodiscard]] std::span<const std::byte> obstacles() const;
  /// The whole blob, header first.
  [[nodiscard]] std::span<const std::byte> bytes() const;

  /// Corners in frame W [m]: origin + unit * i, the coordinates that `locate` compares with, too.
  [[nodiscard]] Box to_world(const IntBox& box) const;

  /// The cell that holds the point (closed boxes as `to_world` gives them; the lowest index when it lies on a shared
  /// face), or nothing (also for a point that is not finite). Cost O(log n) typical; at most one visit of every index
  /// node.
  [[nodiscard]] std::optional<CellIndex> locate(const Vector3& p_W) const;

  struct NearestFree {
    CellIndex cell{};
    Vector3 point = Vector3::Zero();  ///< [m] frame W, inside `cell`
    Real distance = 0;                ///< [m]
  };
  /// The free point nearest to `p_W`, of one component where one is named, in the cell of the lowest index on ties;
  /// nothing when there is no such cell or `p_W` is not finite. Branch and bound: at most one visit of every index
  /// node.
  [[nodiscard]] std::optional<NearestFree> nearest_free(const Vector3& p_W,
                                                        std::optional<std::uint16_t> component = {}) const;

  /// The same map without what `blocked` blocks (blocked_space.hpp): cell indices from cell_count() on are pieces of
  /// cells that it cuts, `extent` and `locate` keep out of it, and neighbours are those that `visit_neighbours` finds.
  /// nullptr: the map as it is.
  [[nodiscard]] BoxGraphView with_blocked(const BlockedSpace* blocked) const {
    BoxGraphView view = *this;
    view.blocked_ = blocked;
    return view;
  }
  [[nodiscard]] const BlockedSpace* blocked() const { return blocked_; }
  /// The cell of the map that a cell or piece is of.
  [[nodiscard]] CellIndex map_cell(CellIndex cell) const;
  /// How many cells of the map share volume with `box`; as many as fit are written.
  std::size_t cells_in(const IntBox& box, std::span<CellIndex> cells) const;

  /// Volume [unit^3] of `box` that is covered by cells of the map, blocked or not: equal to the volume of `box` exactly
  /// when it is all free.
  [[nodiscard]] std::uint64_t covered_volume(const IntBox& box) const;

 private:
  [[nodiscard]] Real coordinate(std::size_t axis, std::uint16_t i) const {
    return static_cast<Real>(header_->origin[axis] + unit_ * i);
  }
  [[nodiscard]] const std::byte* record(CellIndex cell) const;
  [[nodiscard]] const std::byte* record_end(CellIndex cell) const;
  template <typename T>
  [[nodiscard]] std::span<const T> section(BlobSection section) const;
  [[nodiscard]] bool cells_consistent() const;
  [[nodiscard]] bool records_consistent() const;
  [[nodiscard]] bool index_consistent() const;

  const BlobHeader* header_ = nullptr;
  double unit_ = 0;
  const BlockedSpace* blocked_ = nullptr;
};

}  // namespace swiftlet
