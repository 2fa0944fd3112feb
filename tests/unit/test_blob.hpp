#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <span>

#include "swiftlet/box_graph_format.hpp"
#include "swiftlet/box_graph_view.hpp"

namespace swiftlet::test {

/// A map blob of a few hand-written cells without a heap, so that one test source runs on host and target. Adjacency
/// and components come from comparing every pair; extents are the cells themselves unless set; the origin is zero.
class TestBlob {
 public:
  static constexpr std::size_t kMaxCells = 32;
  static constexpr std::size_t kMaxBytes = 8192;

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
    record_bytes_ = 0;
    for (std::size_t i = 0; i < count; ++i) {
      offsets[i] = static_cast<std::uint32_t>(record_bytes_);
      labels[i] = static_cast<std::uint16_t>(i);
      std::uint32_t degree = 0;
      for (std::size_t j = 0; j < count; ++j) degree += adjacent_[i][j] ? 1U : 0U;
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
    }
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
  std::array<IntBox, kMaxCells> cells_{};
  std::array<IntBox, kMaxCells> extents_{};
  std::array<std::array<bool, kMaxCells>, kMaxCells> adjacent_{};
  std::array<std::byte, 4096> records_{};  // at most 2 bytes a neighbour and 3 a growth here
  std::size_t record_bytes_ = 0;
  alignas(8) std::array<std::byte, kMaxBytes> bytes_{};
};

}  // namespace swiftlet::test
