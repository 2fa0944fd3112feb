#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <optional>
#include <span>

#include "swiftlet/box_graph_format.hpp"
#include "swiftlet/box_graph_view.hpp"

namespace swiftlet::test {

/// A map blob of a few hand-written cells without a heap, so that one test source runs on host and target. Adjacency
/// and components come from comparing every pair; extents are the cells themselves unless set; the origin is zero.
class TestBlob {
 public:
  static constexpr std::size_t kMaxCells = 32;
  static constexpr std::size_t kMaxBytes = 12288;

  TestBlob(std::array<std::uint32_t, 3> size, std::initializer_list<IntBox> cells, double resolution = 1)
      : TestBlob(size, std::span(cells.begin(), cells.size()), resolution) {}
  TestBlob(std::array<std::uint32_t, 3> size, std::span<const IntBox> cells, double resolution = 1) {
    header_.resolution = resolution;
    header_.radius = 0.25;
    header_.size = size;
    for (const IntBox& cell : cells) {
      if (header_.cell_count == kMaxCells) break;
      cells_[header_.cell_count] = cell;
      extents_[header_.cell_count] = cell;
      ++header_.cell_count;
    }
    find_neighbours();
    write();
  }

  void set_extent(std::size_t cell, const IntBox& extent) {
    extents_[cell] = extent;
    write();
  }
  /// For tests of the validation: claims or denies a window, in this direction alone.
  void set_adjacent(std::size_t from, std::size_t to, bool adjacent) {
    adjacent_[from][to] = adjacent;
    write();
  }
  /// Gives the windows of component 0 their distances from `count` of them, chosen evenly.
  void set_landmarks(std::uint32_t count) {
    header_.landmark_count = count;
    header_.landmark_shift = count > 0 ? 8 : 0;
    write();
  }
  /// For tests of the search: overwrites the landmark distances of every second window.
  void set_every_second_distance(std::uint16_t distance) {
    lie_ = distance;
    write();
  }
  void set_search_points(SearchPoints points) {
    header_.search_points = static_cast<std::uint32_t>(points);
    write();
  }
  void set_origin(const std::array<double, 3>& origin) {
    header_.origin = origin;
    write();
  }

  [[nodiscard]] std::span<std::byte> bytes() { return std::span(bytes_).first(header_.blob_bytes); }
  [[nodiscard]] BlobHeader& header() { return *reinterpret_cast<BlobHeader*>(bytes_.data()); }
  template <typename T>
  [[nodiscard]] T* section(BlobSection section) {
    return reinterpret_cast<T*>(bytes_.data() + header_.sections[static_cast<std::size_t>(section)].offset);
  }
  /// Makes the checksum right again after a test has changed something.
  void seal() { header().crc32 = blob_crc32(bytes()); }

  [[nodiscard]] BoxGraphView view() { return *BoxGraphView::open(bytes()); }

 private:
  static bool shares_window(const IntBox& a, const IntBox& b) {
    const IntBox common = intersection(a, b);
    bool thin = false;
    for (std::size_t axis = 0; axis < 3; ++axis) thin = thin || common.lo[axis] == common.hi[axis];
    return thin && is_passage(common);
  }

  template <typename T>
  void append(BlobSection section, const T* data, std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    header_.sections[static_cast<std::size_t>(section)] = {header_.blob_bytes, static_cast<std::uint32_t>(bytes)};
    if (bytes > 0) std::memcpy(bytes_.data() + header_.blob_bytes, data, bytes);
    header_.blob_bytes = static_cast<std::uint32_t>((header_.blob_bytes + bytes + 7) / 8 * 8);
  }

  void put_number(std::uint32_t value) {
    while (value >= 128) {
      records_[record_bytes_++] = static_cast<std::byte>((value & 127U) | 128U);
      value >>= 7;
    }
    records_[record_bytes_++] = static_cast<std::byte>(value);
  }

  struct Window {
    std::size_t a, b;
    std::array<double, 3> centre;
    double distance;
  };

  /// The windows of component 0 by (a, b), a < b. Returns how many.
  std::size_t list_windows(const std::array<std::uint16_t, kMaxCells>& labels, std::span<Window> windows) const {
    std::size_t count = 0;
    for (std::size_t a = 0; a < header_.cell_count; ++a) {
      for (std::size_t b = a + 1; b < header_.cell_count; ++b) {
        if (!adjacent_[a][b] || labels[a] != 0) continue;
        const IntBox box = intersection(cells_[a], cells_[b]);
        windows[count++] = {
            a, b, {(box.lo[0] + box.hi[0]) / 2.0, (box.lo[1] + box.hi[1]) / 2.0, (box.lo[2] + box.hi[2]) / 2.0}, 0};
      }
    }
    return count;
  }

  /// Distances over window centres from one window, relaxed until nothing changes.
  static void spread_from(std::size_t source, std::span<Window> windows) {
    for (Window& window : windows) window.distance = 1e9;
    windows[source].distance = 0;
    for (bool changed = true; changed;) {
      changed = false;
      for (const Window& from : windows) {
        for (Window& to : windows) {
          if (from.a != to.a && from.a != to.b && from.b != to.a && from.b != to.b) continue;
          double squared = 0;
          for (std::size_t axis = 0; axis < 3; ++axis) {
            squared += (from.centre[axis] - to.centre[axis]) * (from.centre[axis] - to.centre[axis]);
          }
          const double through = from.distance + std::sqrt(squared);
          if (through >= to.distance) continue;
          to.distance = through;
          changed = true;
        }
      }
    }
  }

  /// Rows for the records, in the order of the windows.
  void find_landmark_distances(const std::array<std::uint16_t, kMaxCells>& labels) {
    const std::uint32_t landmarks = header_.landmark_count;
    const std::size_t count = list_windows(labels, scratch_windows);
    const std::span<Window> windows = std::span(scratch_windows).first(count);
    for (std::uint32_t k = 0; k < landmarks && count > 0; ++k) {
      spread_from(k * count / landmarks, windows);
      for (std::size_t i = 0; i < count; ++i) {
        scratch_distances[landmarks * i + k] =
            lie_ && i % 2 == 1
                ? *lie_
                : static_cast<std::uint16_t>(std::lround(windows[i].distance * (1U << header_.landmark_shift)));
      }
    }
  }

  void find_neighbours() {
    for (std::size_t i = 0; i < header_.cell_count; ++i) {
      for (std::size_t j = 0; j < header_.cell_count; ++j) {
        adjacent_[i][j] = i != j && shares_window(cells_[i], cells_[j]);
      }
    }
  }

  void write() {
    const std::size_t count = header_.cell_count;
    std::array<std::uint32_t, kMaxCells> offsets{};
    std::array<std::uint16_t, kMaxCells> labels{};
    std::uint32_t entries = 0;
    for (std::size_t i = 0; i < count; ++i) labels[i] = static_cast<std::uint16_t>(i);
    for (std::size_t round = 0; round < count; ++round) {
      for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = 0; j < count; ++j) {
          if (adjacent_[i][j]) labels[i] = std::min(labels[i], labels[j]);
        }
      }
    }
    std::uint16_t components = 0;
    for (std::size_t i = 0; i < count; ++i) {  // so far the label is the component's first cell
      labels[i] = labels[i] == i ? components++ : labels[labels[i]];
    }
    find_landmark_distances(labels);
    std::size_t landmark_numbers = 0;
    record_bytes_ = 0;
    for (std::size_t i = 0; i < count; ++i) {
      offsets[i] = static_cast<std::uint32_t>(record_bytes_);
      std::uint32_t degree = 0;
      std::uint32_t higher = 0;
      for (std::size_t j = 0; j < count; ++j) degree += adjacent_[i][j] ? 1U : 0U;
      for (std::size_t j = i + 1; j < count; ++j) higher += adjacent_[i][j] ? 1U : 0U;
      entries += degree;
      put_number(degree);
      std::size_t previous = kMaxCells;
      for (std::size_t j = 0; j < count; ++j) {
        if (!adjacent_[i][j]) continue;
        const std::size_t zigzag = j < i ? 2 * (i - j) - 1 : 2 * (j - i);
        put_number(static_cast<std::uint32_t>(previous == kMaxCells ? zigzag : j - previous - 1));
        previous = j;
      }
      for (std::size_t axis = 0; axis < 3; ++axis) {
        put_number(static_cast<std::uint32_t>(cells_[i].lo[axis] - extents_[i].lo[axis]));
      }
      for (std::size_t axis = 0; axis < 3; ++axis) {
        put_number(static_cast<std::uint32_t>(extents_[i].hi[axis] - cells_[i].hi[axis]));
      }
      if (labels[i] != 0) continue;
      for (std::uint32_t n = 0; n < higher * header_.landmark_count; ++n) {
        const std::uint16_t distance = scratch_distances[landmark_numbers++];
        records_[record_bytes_++] = static_cast<std::byte>(distance & 0xFFU);
        records_[record_bytes_++] = static_cast<std::byte>(distance >> 8U);
      }
    }

    const std::size_t leaves = (count + kCellsPerIndexLeaf - 1) / kCellsPerIndexLeaf;
    const std::size_t nodes = leaves == 0 ? 0 : 2 * leaves - 1;
    std::array<IntBox, 2 * kMaxCells> index{};
    for (std::size_t node = nodes; node-- > 0;) {
      IntBox bounds{{65'535, 65'535, 65'535}, {0, 0, 0}};
      const auto include = [&bounds](const IntBox& box) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          bounds.lo[axis] = std::min(bounds.lo[axis], box.lo[axis]);
          bounds.hi[axis] = std::max(bounds.hi[axis], box.hi[axis]);
        }
      };
      if (node + 1 < leaves) {
        include(index[2 * node + 1]);
        include(index[2 * node + 2]);
      } else {
        const std::size_t first = (node + 1 - leaves) * kCellsPerIndexLeaf;
        for (std::size_t i = first; i < std::min(first + kCellsPerIndexLeaf, count); ++i) include(cells_[i]);
      }
      index[node] = bounds;
    }

    bytes_.fill(std::byte{0});
    header_.magic = kBlobMagic;
    header_.byte_order = kBlobByteOrderMark;
    header_.version = kBlobVersion;
    header_.neighbour_count = entries;
    header_.index_node_count = static_cast<std::uint32_t>(nodes);
    header_.component_count = components;
    header_.blob_bytes = sizeof(BlobHeader);
    append(BlobSection::kCells, cells_.data(), count);
    append(BlobSection::kRecordOffsets, offsets.data(), count);
    append(BlobSection::kRecords, records_.data(), record_bytes_);
    append(BlobSection::kComponents, labels.data(), count);
    append(BlobSection::kIndex, index.data(), nodes);
    append(BlobSection::kObstacles, index.data(), 0);
    std::memcpy(bytes_.data(), &header_, sizeof(BlobHeader));
    seal();
  }

  BlobHeader header_{};
  std::optional<std::uint16_t> lie_;
  std::array<IntBox, kMaxCells> cells_{};
  std::array<IntBox, kMaxCells> extents_{};
  std::array<std::array<bool, kMaxCells>, kMaxCells> adjacent_{};
  static constexpr std::size_t kMaxWindows = kMaxCells * (kMaxCells - 1) / 2;
  static constexpr std::size_t kMaxLandmarks = 4;
  // Scratch of `write`, shared: a board's stack has to hold a few blobs.
  static inline std::array<Window, kMaxWindows> scratch_windows{};
  static inline std::array<std::uint16_t, kMaxLandmarks * kMaxWindows> scratch_distances{};
  std::array<std::byte, 6144> records_{};  // at most 2 bytes a neighbour and 3 a growth here
  std::size_t record_bytes_ = 0;
  alignas(8) std::array<std::byte, kMaxBytes> bytes_{};
};

}  // namespace swiftlet::test
