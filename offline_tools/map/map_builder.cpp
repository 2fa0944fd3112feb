#include "map/map_builder.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "map/box_graph.hpp"
#include "map/free_space.hpp"
#include "map/landmarks.hpp"
#include "map/obstacles.hpp"
#include "map/partition.hpp"
#include "map/slivers.hpp"
#include "swiftlet/box_graph_view.hpp"

namespace swiftlet::tools {
namespace {

BlobBox to_blob_box(const GridBox& box) {
  BlobBox narrow{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    narrow.lo[axis] = static_cast<std::uint16_t>(box.lo[axis]);
    narrow.hi[axis] = static_cast<std::uint16_t>(box.hi[axis]);
  }
  return narrow;
}

std::vector<BlobBox> to_blob_boxes(const std::vector<GridBox>& boxes) {
  std::vector<BlobBox> narrow;
  narrow.reserve(boxes.size());
  for (const GridBox& box : boxes) narrow.push_back(to_blob_box(box));
  return narrow;
}

void include(BlobBox& bounds, const BlobBox& box) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bounds.lo[axis] = std::min(bounds.lo[axis], box.lo[axis]);
    bounds.hi[axis] = std::max(bounds.hi[axis], box.hi[axis]);
  }
}

/// Bounds of the implicit tree over cells that are in its order already.
std::vector<BlobBox> build_index(const std::vector<BlobBox>& cells) {
  const std::size_t leaves = (cells.size() + kCellsPerIndexLeaf - 1) / kCellsPerIndexLeaf;
  std::vector<BlobBox> index(leaves == 0 ? 0 : 2 * leaves - 1);
  for (std::size_t node = index.size(); node-- > 0;) {
    if (node + 1 < leaves) {
      index[node] = index[2 * node + 1];
      include(index[node], index[2 * node + 2]);
      continue;
    }
    const std::size_t first = (node + 1 - leaves) * kCellsPerIndexLeaf;
    index[node] = cells[first];
    for (std::size_t i = first; i < std::min(first + kCellsPerIndexLeaf, cells.size()); ++i)
      include(index[node], cells[i]);
  }
  return index;
}

/// Sections one after the other behind a header that is filled in last.
class BlobWriter {
 public:
  BlobWriter() : bytes_(sizeof(BlobHeader)) {}

  template <typename T>
  void append(BlobSection section, const std::vector<T>& elements) {
    const std::size_t size = elements.size() * sizeof(T);
    entries_[static_cast<std::size_t>(section)] = {static_cast<std::uint32_t>(bytes_.size()),
                                                   static_cast<std::uint32_t>(size)};
    const std::size_t start = bytes_.size();
    bytes_.resize((start + size + 7) / 8 * 8);
    if (size > 0) std::memcpy(bytes_.data() + start, elements.data(), size);
  }

  std::vector<std::byte> finish(BlobHeader header) {
    header.magic = kBlobMagic;
    header.byte_order = kBlobByteOrderMark;
    header.version = kBlobVersion;
    header.blob_bytes = static_cast<std::uint32_t>(bytes_.size());
    header.sections = entries_;
    seal(header, bytes_);
    return std::move(bytes_);
  }

  static void seal(BlobHeader header, std::vector<std::byte>& bytes) {
    header.crc32 = 0;
    std::memcpy(bytes.data(), &header, sizeof(BlobHeader));
    header.crc32 = blob_crc32(bytes);
    std::memcpy(bytes.data(), &header, sizeof(BlobHeader));
  }

  [[nodiscard]] std::size_t size() const { return bytes_.size(); }

 private:
  std::vector<std::byte> bytes_;
  std::array<BlobSectionEntry, kBlobSectionCount> entries_{};
};

std::vector<GridBox> grow_extents(const FreeSpace& space, const std::vector<GridBox>& cells, const Progress& progress) {
  std::vector<GridBox> extents;
  extents.reserve(cells.size());
  for (const GridBox& cell : cells) {
    extents.push_back(grow(space.free, cell));
    progress("extend", static_cast<double>(extents.size()) / static_cast<double>(cells.size()));
  }
  return extents;
}

using Windows = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// LEB128: seven bits a byte, lowest first.
void put_number(std::uint64_t value, std::vector<std::byte>& bytes) {
  while (value >= 128) {
    bytes.push_back(static_cast<std::byte>((value & 127U) | 128U));
    value >>= 7;
  }
  bytes.push_back(static_cast<std::byte>(value));
}

std::uint64_t to_zigzag(std::int64_t value) {
  return value < 0 ? 2 * static_cast<std::uint64_t>(-value) - 1 : 2 * static_cast<std::uint64_t>(value);
}

/// The records of all cells (BlobSection::kRecords) and where each one starts.
struct Records {
  std::vector<std::uint32_t> offsets;
  std::vector<std::byte> bytes;
};

Records write_records(const std::vector<GridBox>& cells, const std::vector<GridBox>& extents, const Windows& windows,
                      const std::vector<std::uint16_t>& labels, const LandmarkTable& landmarks) {
  std::vector<std::vector<std::uint32_t>> rows(cells.size());
  // Windows are sorted, so each row first receives its lower neighbours in order, then the higher ones.
  for (const auto& [a, b] : windows) rows[b].push_back(a);
  for (const auto& [a, b] : windows) rows[a].push_back(b);

  Records records;
  auto distance = landmarks.distances.begin();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    records.offsets.push_back(static_cast<std::uint32_t>(records.bytes.size()));
    put_number(rows[i].size(), records.bytes);
    for (std::size_t k = 0; k < rows[i].size(); ++k) {
      const std::uint64_t number = k == 0 ? to_zigzag(std::int64_t{rows[i][0]} - static_cast<std::int64_t>(i))
                                          : std::uint64_t{rows[i][k]} - rows[i][k - 1] - 1;
      put_number(number, records.bytes);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      put_number(static_cast<std::uint64_t>(cells[i].lo[axis] - extents[i].lo[axis]), records.bytes);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      put_number(static_cast<std::uint64_t>(extents[i].hi[axis] - cells[i].hi[axis]), records.bytes);
    }
    if (labels[i] != 0) continue;
    const auto higher = std::count_if(rows[i].begin(), rows[i].end(), [i](std::uint32_t j) { return j > i; });
    for (const auto end = distance + higher * static_cast<std::ptrdiff_t>(landmarks.count); distance != end;
         ++distance) {
      records.bytes.push_back(static_cast<std::byte>(*distance & 0xFFU));
      records.bytes.push_back(static_cast<std::byte>(*distance >> 8U));
    }
  }
  return records;
}

std::size_t windows_of_largest(const Windows& windows, const std::vector<std::uint16_t>& labels) {
  return static_cast<std::size_t>(
      std::count_if(windows.begin(), windows.end(), [&](const auto& window) { return labels[window.first] == 0; }));
}

}  // namespace

Expected<BuiltMap> build_map(const VoxelMap& map, const std::string& source, const MapBuildOptions& options,
                             const Progress& progress) {
  const Expected<FreeSpace> space = compute_free_space(map, source, options, progress);
  if (!space) return tl::unexpected(space.error());

  std::array<std::int64_t, 3> key{};
  std::array<std::int32_t, 3> size_voxels{};
  BlobHeader header{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    key[axis] = (std::int64_t{map.key[axis]} + space->first_voxel[axis]) << space->unit_shift;
    size_voxels[axis] = space->free.size()[axis] >> space->unit_shift;
    header.size[axis] = static_cast<std::uint32_t>(space->free.size()[axis]);
  }
  std::vector<GridBox> cells = options.partition == Partition::kOctree
                                   ? octree_leaves(space->free, key)
                                   : merged_boxes(space->free, key, [&](double done) { progress("partition", done); });
  if (options.sliver_tolerance) {
    const std::int32_t voxel = std::int32_t{1} << space->unit_shift;
    const double tolerance =
        *options.sliver_tolerance / std::ldexp(map.resolution, -static_cast<int>(space->unit_shift));
    header.lost_to_slivers =
        drop_slivers(cells, voxel, tolerance, [&](double done) { progress("drop slivers", done); });
  }
  order_for_index(cells);
  const std::vector<GridBox> extents = grow_extents(*space, cells, progress);
  progress("connect", 0);
  const Windows windows = find_windows(cells);
  const std::vector<std::uint16_t> labels = label_components(cells, windows, header.component_count);
  const std::vector<BlobBox> blob_cells = to_blob_boxes(cells);
  const std::vector<BlobBox> index = build_index(blob_cells);
  progress("landmarks", 0);
  const std::size_t bytes_without_landmarks =
      sizeof(BlobHeader) + cells.size() * (sizeof(BlobBox) + sizeof(std::uint32_t) + sizeof(std::uint16_t)) +
      write_records(cells, extents, windows, labels, {}).bytes.size() + index.size() * sizeof(BlobBox);
  const std::uint32_t affordable = affordable_landmarks(windows_of_largest(windows, labels), bytes_without_landmarks);
  const LandmarkTable landmarks = choose_landmarks(cells, windows, labels, options.landmarks.value_or(affordable));
  const Records records = write_records(cells, extents, windows, labels, landmarks);
  header.resolution = map.resolution;
  header.origin = space->origin;
  header.radius = options.radius;
  header.unknown_policy = static_cast<std::uint32_t>(options.unknown);
  header.unit_shift = space->unit_shift;
  header.cell_count = static_cast<std::uint32_t>(cells.size());
  header.neighbour_count = static_cast<std::uint32_t>(2 * windows.size());
  header.index_node_count = static_cast<std::uint32_t>(index.size());
  header.landmark_count = landmarks.count;
  header.landmark_shift = landmarks.shift;
  header.lost_to_inflation = space->lost_to_inflation;
  header.lost_to_unknown = space->lost_to_unknown;
  header.lost_to_coarsening = space->lost_to_coarsening;
  header.source_digest = map.source_digest;

  BlobWriter writer;
  writer.append(BlobSection::kCells, blob_cells);
  writer.append(BlobSection::kRecordOffsets, records.offsets);
  writer.append(BlobSection::kRecords, records.bytes);
  writer.append(BlobSection::kComponents, labels);
  writer.append(BlobSection::kIndex, index);
  writer.append(BlobSection::kObstacles, pack_obstacles(map, space->first_voxel, size_voxels));
  constexpr std::size_t kMaxBlob = 0xFFFFFFF0;
  if (writer.size() > kMaxBlob) return bad_file(source + ": the blob would pass 4 GB; crop the map with --bounds");

  BuiltMap built{writer.finish(header), {}};
  Result<BoxGraphView> view = BoxGraphView::open(built.blob);
  if (view.ok() && measure_search_points(*view) == SearchPoints::kCentres) {
    header = view->header();
    header.search_points = static_cast<std::uint32_t>(SearchPoints::kCentres);
    BlobWriter::seal(header, built.blob);
    view = BoxGraphView::open(built.blob);
  }
  if (!view.ok()) {
    constexpr int kInternalError = 4;
    return tl::unexpected(Error{kInternalError, source + ": built a blob that the reader refuses: " +
                                                    swiftlet::describe(view.status()) + "; please report this"});
  }
  built.report = map_info(*view);
  built.report.source = source;
  built.report.landmarks_too_far = landmarks.too_far;
  return built;
}

}  // namespace swiftlet::tools
