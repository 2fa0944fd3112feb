#include "swiftlet/box_graph_view.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "swiftlet/blocked_space.hpp"

namespace swiftlet {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the blob is read in place, so the machine must be little-endian");

// ---------------------------------------------------------------------------------------------------------- checksum

constexpr std::array<std::uint32_t, 256> make_crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t value = byte;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ ((value & 1U) != 0 ? 0xEDB88320U : 0U);
    table[byte] = value;
  }
  return table;
}
constexpr std::array<std::uint32_t, 256> kCrcTable = make_crc_table();

std::uint32_t crc_step(std::uint32_t crc, std::byte byte) {
  return (crc >> 8) ^ kCrcTable[(crc ^ std::to_integer<std::uint32_t>(byte)) & 0xFFU];
}

// ------------------------------------------------------------------------------------------------------------- boxes

IntBox to_int_box(const BlobBox& box) { return {box.lo, box.hi}; }

bool is_proper(const IntBox& box, const std::array<std::uint32_t, 3>& size) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (box.lo[axis] >= box.hi[axis] || box.hi[axis] > size[axis]) return false;
  }
  return true;
}

/// A window has no thickness on one axis and positive extent on the other two (eq. 1).
bool shares_window(const IntBox& a, const IntBox& b) {
  const IntBox common = intersection(a, b);
  int thin_axes = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) thin_axes += common.lo[axis] == common.hi[axis] ? 1 : 0;
  return thin_axes == 1 && is_passage(common);
}

std::uint64_t volume(const IntBox& box) {
  std::uint64_t product = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (box.lo[axis] >= box.hi[axis]) return 0;
    product *= static_cast<std::uint64_t>(box.hi[axis] - box.lo[axis]);
  }
  return product;
}

// ------------------------------------------------------------------------------------------------------------- index

/// The shape of the implicit tree: nodes 0 to 2L - 2 in heap order, the last L are leaves of kCellsPerIndexLeaf cells.
struct IndexShape {
  explicit IndexShape(std::size_t cells)
      : cell_count(cells), leaf_count((cells + kCellsPerIndexLeaf - 1) / kCellsPerIndexLeaf) {}
  [[nodiscard]] std::size_t node_count() const { return leaf_count == 0 ? 0 : 2 * leaf_count - 1; }
  [[nodiscard]] bool is_leaf(std::size_t node) const { return node + 1 >= leaf_count; }
  [[nodiscard]] std::size_t first_cell(std::size_t leaf) const { return (leaf + 1 - leaf_count) * kCellsPerIndexLeaf; }
  [[nodiscard]] std::size_t end_cell(std::size_t leaf) const {
    return std::min(first_cell(leaf) + kCellsPerIndexLeaf, cell_count);
  }
  std::size_t cell_count;
  std::size_t leaf_count;
};

/// Depth-first stack: a blob of at most 2^32 bytes has a tree of at most 27 levels, and each level leaves one sibling.
constexpr std::size_t kStackDepth = 32;

/// Calls `visit(cell)` for every cell below an index node that `overlaps` accepts; both take an IntBox.
template <typename Overlaps, typename Visit>
void for_each_overlapping(std::span<const BlobBox> index, std::size_t cell_count, const Overlaps& overlaps,
                          const Visit& visit) {
  if (index.empty()) return;
  const IndexShape shape(cell_count);
  std::array<std::size_t, kStackDepth> stack{};
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::size_t node = stack[--depth];
    if (!overlaps(to_int_box(index[node]))) continue;
    if (shape.is_leaf(node)) {
      for (std::size_t cell = shape.first_cell(node); cell < shape.end_cell(node); ++cell) visit(cell);
    } else {
      stack[depth++] = 2 * node + 2;
      stack[depth++] = 2 * node + 1;
    }
  }
}

// ---------------------------------------------------------------------------------------------------- header checks

/// Lengths that can be calculated with: no coordinate overflows, NaN is none of them.
bool lengths_usable(const BlobHeader& header) {
  constexpr double kSmallest = 1e-6;
  constexpr double kLargest = 1e6;
  constexpr double kFarthest = 1e12;
  bool usable = header.resolution >= kSmallest && header.resolution <= kLargest;
  usable = usable && header.radius >= 0 && header.radius <= kLargest;
  for (const double coordinate : header.origin) usable = usable && coordinate >= -kFarthest && coordinate <= kFarthest;
  return usable;
}

bool landmarks_usable(const BlobHeader& header) {
  constexpr std::uint32_t kMaxLandmarkShift = 16;
  if (header.search_points > static_cast<std::uint32_t>(SearchPoints::kCentres)) return false;
  if (header.landmark_count == 0) return header.landmark_shift == 0;
  return header.landmark_count <= kMostLandmarks && header.landmark_shift >= 1 &&
         header.landmark_shift <= kMaxLandmarkShift;
}

/// Sections follow each other without gaps but for the padding to 8 bytes, and hold exactly what the counts say.
bool sections_consistent(const BlobHeader& header) {
  const std::uint64_t cells = header.cell_count;
  const std::array<std::uint64_t, kBlobSectionCount> bytes{
      cells * sizeof(BlobBox),
      cells * sizeof(std::uint32_t),
      header.sections[static_cast<std::size_t>(BlobSection::kRecords)].bytes,
      cells * sizeof(std::uint16_t),
      std::uint64_t{header.index_node_count} * sizeof(BlobBox),
      header.sections[static_cast<std::size_t>(BlobSection::kObstacles)].bytes,
  };
  std::uint64_t offset = sizeof(BlobHeader);
  for (std::size_t i = 0; i < kBlobSectionCount; ++i) {
    if (header.sections[i].offset != offset || header.sections[i].bytes != bytes[i]) return false;
    offset = (offset + bytes[i] + 7) / 8 * 8;
  }
  return offset == header.blob_bytes;
}

bool header_consistent(const BlobHeader& header) {
  constexpr std::uint32_t kMaxUnitShift = 8;
  constexpr std::uint32_t kMaxSize = 65'535;
  constexpr std::uint32_t kMaxComponents = 65'536;
  if (!lengths_usable(header)) return false;
  if (header.unknown_policy > static_cast<std::uint32_t>(UnknownPolicy::kFree)) return false;
  if (header.unit_shift > kMaxUnitShift || !landmarks_usable(header)) return false;
  for (const std::uint32_t size : header.size) {
    if (size == 0 || size > kMaxSize) return false;
  }
  if (header.component_count > kMaxComponents) return false;
  return header.index_node_count == IndexShape(header.cell_count).node_count() && sections_consistent(header);
}

// ----------------------------------------------------------------------------------------------------------- records

constexpr unsigned kLebBits = 7;
constexpr unsigned kLebMore = 0x80;

/// Reads one number of a record that has been validated, so that it ends within the blob.
std::uint32_t read_number(const std::byte*& at) {
  std::uint32_t value = 0;
  for (unsigned shift = 0; shift < 32; shift += kLebBits) {
    const auto byte = std::to_integer<std::uint32_t>(*at++);
    value |= (byte & (kLebMore - 1)) << shift;
    if ((byte & kLebMore) == 0) break;
  }
  return value;
}

/// The same for bytes of unknown origin: false when the number passes `end` or 32 bits.
bool read_checked(const std::byte*& at, const std::byte* end, std::uint32_t& value) {
  std::uint64_t wide = 0;
  for (unsigned shift = 0; shift < 35; shift += kLebBits) {
    if (at == end) return false;
    const auto byte = std::to_integer<std::uint64_t>(*at++);
    wide |= (byte & (kLebMore - 1)) << shift;
    if ((byte & kLebMore) != 0) continue;
    value = static_cast<std::uint32_t>(wide);
    return wide <= 0xFFFFFFFFU;
  }
  return false;
}

/// 0, 1, 2, 3, 4 ... stand for 0, -1, 1, -2, 2 ...
std::int64_t from_zigzag(std::uint32_t code) {
  const auto half = static_cast<std::int64_t>(code >> 1);
  return (code & 1U) != 0 ? -half - 1 : half;
}

void skip_neighbours(const std::byte*& at) {
  for (std::uint32_t count = read_number(at); count > 0; --count) read_number(at);
}

/// A number that hardly any other pair has (splitmix64), to compare two sets of pairs by the sum over each.
std::uint64_t hash_pair(std::uint64_t low, std::uint64_t high) {
  std::uint64_t x = (low << 32 | high) + 0x9E3779B97F4A7C15U;
  x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9U;
  x = (x ^ x >> 27) * 0x94D049BB133111EBU;
  return x ^ x >> 31;
}

}  // namespace

std::uint32_t blob_crc32(std::span<const std::byte> blob) {
  constexpr std::size_t kField = offsetof(BlobHeader, crc32);
  constexpr std::size_t kAfterField = kField + sizeof(BlobHeader::crc32);
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const std::byte byte : blob.first(kField)) crc = crc_step(crc, byte);
  for (std::size_t i = kField; i < kAfterField; ++i) crc = crc_step(crc, std::byte{0});
  for (const std::byte byte : blob.subspan(kAfterField)) crc = crc_step(crc, byte);
  return ~crc;
}

Result<BoxGraphView> BoxGraphView::open(std::span<const std::byte> blob) {
  if (reinterpret_cast<std::uintptr_t>(blob.data()) % alignof(BlobHeader) != 0) return Status::kBadRequest;
  if (blob.size() < sizeof(BlobHeader)) return Status::kBlobTruncated;
  const auto* header = reinterpret_cast<const BlobHeader*>(blob.data());
  if (header->magic != kBlobMagic) return Status::kBlobWrongMagic;
  if (header->byte_order != kBlobByteOrderMark) return Status::kBlobWrongByteOrder;
  if (header->version != kBlobVersion) return Status::kBlobWrongVersion;
  if (header->blob_bytes > blob.size()) return Status::kBlobTruncated;
  if (header->blob_bytes < sizeof(BlobHeader)) return Status::kBlobInconsistent;
  if (blob_crc32(blob.first(header->blob_bytes)) != header->crc32) return Status::kBlobDamaged;
  if (!header_consistent(*header)) return Status::kBlobInconsistent;

  BoxGraphView view;
  view.header_ = header;
  view.unit_ = header->resolution / static_cast<double>(1U << header->unit_shift);
  const bool consistent = view.cells_consistent() && view.records_consistent() && view.index_consistent();
  if (!consistent) return Status::kBlobInconsistent;
  return view;
}

bool BoxGraphView::cells_consistent() const {
  const auto labels = section<std::uint16_t>(BlobSection::kComponents);
  for (std::size_t i = 0; i < cell_count(); ++i) {
    if (!is_proper(cell(static_cast<CellIndex>(i)), header_->size) || labels[i] >= header_->component_count)
      return false;
  }
  return true;
}

bool BoxGraphView::records_consistent() const {
  const auto offsets = section<std::uint32_t>(BlobSection::kRecordOffsets);
  const auto records = section<std::byte>(BlobSection::kRecords);
  const std::byte* at = records.data();
  const std::byte* const end = at + records.size();
  std::uint64_t neighbour_count = 0;
  std::uint64_t pairs_upward = 0;  // sums over all (i, j) with i < j, as seen from i and as seen from j
  std::uint64_t pairs_downward = 0;
  for (std::size_t i = 0; i < cell_count(); ++i) {
    const auto own = static_cast<CellIndex>(i);
    if (offsets[i] != static_cast<std::uint64_t>(at - records.data())) return false;

    std::uint32_t count = 0;
    if (!read_checked(at, end, count)) return false;
    neighbour_count += count;
    std::uint64_t higher = 0;  // neighbours of a higher index
    auto other = static_cast<std::int64_t>(i);
    for (std::uint32_t k = 0; k < count; ++k) {  // ends with the section: every turn reads at least a byte
      std::uint32_t number = 0;
      if (!read_checked(at, end, number)) return false;
      other += k == 0 ? from_zigzag(number) : std::int64_t{number} + 1;
      if (other < 0 || other >= static_cast<std::int64_t>(cell_count())) return false;
      const auto neighbour = static_cast<CellIndex>(other);
      if (component(neighbour) != component(own) || !shares_window(cell(own), cell(neighbour))) return false;
      if (neighbour > own) {
        ++higher;
        pairs_upward += hash_pair(i, to_size(neighbour));
      } else {
        pairs_downward += hash_pair(to_size(neighbour), i);
      }
    }

    const IntBox box = cell(own);
    for (std::size_t side = 0; side < 6; ++side) {
      const std::size_t axis = side % 3;
      const std::uint32_t room = side < 3 ? box.lo[axis] : header_->size[axis] - box.hi[axis];
      std::uint32_t growth = 0;
      if (!read_checked(at, end, growth) || growth > room) return false;
    }
    if (!has_landmarks(component(own))) continue;
    const std::uint64_t landmark_bytes = 2 * higher * header_->landmark_count;
    if (landmark_bytes > static_cast<std::uint64_t>(end - at)) return false;
    at += landmark_bytes;
  }
  // Rows hold each neighbour once, so equal sums mean that i knows j exactly when j knows i, unless somebody has forged
  // the rows for it; what that wins is a search that cannot go back the way it came.
  return at == end && neighbour_count == header_->neighbour_count && pairs_upward == pairs_downward;
}

bool BoxGraphView::index_consistent() const {
  const auto index = section<BlobBox>(BlobSection::kIndex);
  const IndexShape shape(cell_count());
  for (std::size_t node = 0; node < index.size(); ++node) {
    const IntBox bounds = to_int_box(index[node]);
    if (!is_proper(bounds, header_->size)) return false;
    if (node > 0 && !contains(to_int_box(index[(node - 1) / 2]), bounds)) return false;
    if (!shape.is_leaf(node)) continue;
    for (std::size_t i = shape.first_cell(node); i < shape.end_cell(node); ++i) {
      if (!contains(bounds, cell(static_cast<CellIndex>(i)))) return false;
    }
  }
  return true;
}

NeighbourRange::NeighbourRange(CellIndex cell, const std::byte* record) {
  begin_.remaining_ = read_number(record);
  if (begin_.remaining_ > 0) {
    const std::int64_t first = static_cast<std::int64_t>(to_size(cell)) + from_zigzag(read_number(record));
    begin_.value_ = static_cast<std::uint32_t>(first);
  }
  begin_.at_ = record;
}

NeighbourRange::Iterator& NeighbourRange::Iterator::operator++() {
  if (--remaining_ > 0) value_ += read_number(at_) + 1;
  return *this;
}

template <typename T>
std::span<const T> BoxGraphView::section(BlobSection section) const {
  const BlobSectionEntry& entry = header_->sections[static_cast<std::size_t>(section)];
  const auto* first = reinterpret_cast<const std::byte*>(header_) + entry.offset;
  return {reinterpret_cast<const T*>(first), entry.bytes / sizeof(T)};
}

IntBox BoxGraphView::cell(CellIndex cell) const {
  if (blocked_ != nullptr && to_size(cell) >= cell_count()) return blocked_->pieces()[to_size(cell) - cell_count()].box;
  return to_int_box(section<BlobBox>(BlobSection::kCells)[to_size(cell)]);
}

const std::byte* BoxGraphView::record(CellIndex cell) const {
  return section<std::byte>(BlobSection::kRecords).data() +
         section<std::uint32_t>(BlobSection::kRecordOffsets)[to_size(cell)];
}

const std::byte* BoxGraphView::record_end(CellIndex cell) const {
  const auto records = section<std::byte>(BlobSection::kRecords);
  if (to_size(cell) + 1 == cell_count()) return records.data() + records.size();
  return records.data() + section<std::uint32_t>(BlobSection::kRecordOffsets)[to_size(cell) + 1];
}

LandmarkRow BoxGraphView::landmarks(CellIndex a, CellIndex b) const {
  const CellIndex low = a < b ? a : b;
  const CellIndex high = a < b ? b : a;
  const NeighbourRange row = neighbours(low);
  NeighbourRange::Iterator at = row.begin();
  while (at.remaining() > 1 && *at != high) ++at;
  // Of forged rows, one may be empty: any bytes of the blob do, and behind the header there are always that many.
  if (row.empty()) return LandmarkRow(record_end(low) - 2 * std::size_t{header_->landmark_count});
  return landmarks(low, at);
}

CellIndex BoxGraphView::map_cell(CellIndex cell) const {
  if (to_size(cell) < cell_count()) return cell;
  return static_cast<CellIndex>(blocked_->pieces()[to_size(cell) - cell_count()].cell);
}

IntBox BoxGraphView::extent(CellIndex cell) const {
  const CellIndex whole = map_cell(cell);
  const std::byte* at = record(whole);
  skip_neighbours(at);
  IntBox box = this->cell(whole);
  for (std::uint16_t& low : box.lo) low = static_cast<std::uint16_t>(low - read_number(at));
  for (std::uint16_t& high : box.hi) high = static_cast<std::uint16_t>(high + read_number(at));
  return blocked_ == nullptr ? box : blocked_->cut_back(box, this->cell(cell));
}

std::uint16_t BoxGraphView::component(CellIndex cell) const {
  return section<std::uint16_t>(BlobSection::kComponents)[to_size(map_cell(cell))];
}

std::span<const std::byte> BoxGraphView::obstacles() const { return section<std::byte>(BlobSection::kObstacles); }

std::span<const std::byte> BoxGraphView::bytes() const {
  return {reinterpret_cast<const std::byte*>(header_), header_->blob_bytes};
}

Box BoxGraphView::to_world(const IntBox& box) const {
  Box world;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<Eigen::Index>(axis);
    world.lo[row] = coordinate(axis, box.lo[axis]);
    world.hi[row] = coordinate(axis, box.hi[axis]);
  }
  return world;
}

std::optional<CellIndex> BoxGraphView::locate(const Vector3& p_W) const {
  // Per axis the last unit coordinate <= p and the first >= p: from there on the search is exact in integers and agrees
  // with `to_world` to the last bit, whatever its rounding, because coordinate() never decreases.
  IntBox around{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Real p = p_W[static_cast<Eigen::Index>(axis)];
    const auto size = static_cast<std::uint16_t>(header_->size[axis]);
    if (!(p >= coordinate(axis, 0) && p <= coordinate(axis, size))) return std::nullopt;
    std::uint32_t first_not_below = 0;  // in [0, size], since coordinate(size) >= p
    for (std::uint32_t end = size; first_not_below < end;) {
      const std::uint32_t middle = (first_not_below + end) / 2;
      if (coordinate(axis, static_cast<std::uint16_t>(middle)) >= p) {
        end = middle;
      } else {
        first_not_below = middle + 1;
      }
    }
    std::uint32_t last_not_above = 0;  // in [0, size], since coordinate(0) <= p
    for (std::uint32_t end = size; last_not_above < end;) {
      const std::uint32_t middle = (last_not_above + end + 1) / 2;
      if (coordinate(axis, static_cast<std::uint16_t>(middle)) <= p) {
        last_not_above = middle;
      } else {
        end = middle - 1;
      }
    }
    around.lo[axis] = static_cast<std::uint16_t>(last_not_above);
    around.hi[axis] = static_cast<std::uint16_t>(first_not_below);
  }

  const auto holds_point = [&around](const IntBox& box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (box.lo[axis] > around.lo[axis] || box.hi[axis] < around.hi[axis]) return false;
    }
    return true;
  };
  std::optional<CellIndex> found;
  for_each_overlapping(section<BlobBox>(BlobSection::kIndex), cell_count(), holds_point, [&](std::size_t i) {
    const auto candidate = static_cast<CellIndex>(i);
    if ((!found || candidate < *found) && holds_point(cell(candidate))) found = candidate;
  });
  const CutCell* cut = found && blocked_ != nullptr ? blocked_->cut(*found) : nullptr;
  if (cut == nullptr) return found;
  // On a face that a blocked box ends at, the cell beyond might do; such a point counts as blocked.
  for (std::uint32_t k = cut->first; k < cut->first + cut->count; ++k) {
    if (holds_point(blocked_->pieces()[k].box)) return static_cast<CellIndex>(cell_count() + k);
  }
  return std::nullopt;
}

std::optional<BoxGraphView::NearestFree> BoxGraphView::nearest_free(const Vector3& p_W,
                                                                    std::optional<std::uint16_t> component) const {
  const auto index = section<BlobBox>(BlobSection::kIndex);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(p_W[axis])) return std::nullopt;
  }
  if (index.empty()) return std::nullopt;

  const auto nearest_in = [&](const IntBox& box) {
    const Box world = to_world(box);
    return Vector3(p_W.cwiseMax(world.lo).cwiseMin(world.hi));
  };
  const auto squared_distance = [&](const Vector3& q_W) {
    const Vector3 d = q_W - p_W;
    return d.x() * d.x() + d.y() * d.y() + d.z() * d.z();
  };
  struct Entry {
    std::size_t node;
    Real bound;  ///< squared distance to the node's box [m^2]
  };
  const auto entry_of = [&](std::size_t node) {
    return Entry{node, squared_distance(nearest_in(to_int_box(index[node])))};
  };

  const IndexShape shape(cell_count());
  std::array<Entry, kStackDepth> stack{};
  std::size_t depth = 0;
  stack[depth++] = entry_of(0);
  std::optional<NearestFree> best;
  Real best_squared = 0;
  while (depth > 0) {
    const Entry entry = stack[--depth];
    if (best && entry.bound > best_squared) continue;
    if (!shape.is_leaf(entry.node)) {
      const Entry left = entry_of(2 * entry.node + 1);
      const Entry right = entry_of(2 * entry.node + 2);
      const bool left_first = left.bound <= right.bound;
      stack[depth++] = left_first ? right : left;
      stack[depth++] = left_first ? left : right;
      continue;
    }
    for (std::size_t i = shape.first_cell(entry.node); i < shape.end_cell(entry.node); ++i) {
      const auto candidate = static_cast<CellIndex>(i);
      if (component && this->component(candidate) != *component) continue;
      const Vector3 point = nearest_in(cell(candidate));
      const Real squared = squared_distance(point);
      const bool tie = best && squared == best_squared && candidate < best->cell;
      if (best && !(squared < best_squared) && !tie) continue;
      best = NearestFree{candidate, point, 0};
      best_squared = squared;
    }
  }
  if (!best) return std::nullopt;
  best->distance = std::sqrt(best_squared);
  if (blocked_ == nullptr) return best;
  // The nearest point of the map, unless it is blocked: what lies behind an obstacle is no place to move to unasked.
  const std::optional<CellIndex> piece = locate(best->point);
  if (!piece) return std::nullopt;
  best->cell = *piece;
  return best;
}

std::size_t BoxGraphView::cells_in(const IntBox& box, std::span<CellIndex> cells) const {
  std::size_t count = 0;
  for_each_overlapping(
      section<BlobBox>(BlobSection::kIndex), cell_count(),
      [&box](const IntBox& bounds) { return volume(intersection(bounds, box)) > 0; },
      [&](std::size_t i) {
        const auto candidate = static_cast<CellIndex>(i);
        if (volume(intersection(cell(candidate), box)) == 0) return;
        if (count < cells.size()) cells[count] = candidate;
        ++count;
      });
  return count;
}

std::uint64_t BoxGraphView::covered_volume(const IntBox& box) const {
  std::uint64_t covered = 0;
  for_each_overlapping(
      section<BlobBox>(BlobSection::kIndex), cell_count(),
      [&box](const IntBox& bounds) { return volume(intersection(bounds, box)) > 0; },
      [&](std::size_t i) { covered += volume(intersection(cell(static_cast<CellIndex>(i)), box)); });
  return covered;
}

}  // namespace swiftlet
