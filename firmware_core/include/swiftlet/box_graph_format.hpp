#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace swiftlet {

/// Byte layout of a map blob (docs/map_format.md): little-endian, every section 8-byte aligned, offsets from the first
/// byte. Included by the writer (offline_tools/map) and the reader (BoxGraphView), so the layout exists once.
inline constexpr std::array<char, 8> kBlobMagic{'S', 'W', 'I', 'F', 'T', 'M', 'A', 'P'};
inline constexpr std::uint32_t kBlobByteOrderMark = 0x01020304;
inline constexpr std::uint32_t kBlobVersion = 2;
inline constexpr std::size_t kCellsPerIndexLeaf = 8;

/// Most landmark distances of a window.
inline constexpr std::size_t kMostLandmarks = 32;

/// Most component labels; with so many, the last one stands for all the rest.
inline constexpr std::uint32_t kMostComponentLabels = 65'535;

/// Where the default search sees a window (SearchMode); the builder measures which serves the map better.
enum class SearchPoints : std::uint32_t { kLine = 0, kCentres = 1 };

/// What the builder did with space that was never observed (contract.md).
enum class UnknownPolicy : std::uint32_t { kAvoid = 0, kOccupied = 1, kFree = 2 };

enum class BlobSection : std::uint32_t {
  kCells,          ///< BlobBox x cell_count: disjoint cells
  kRecordOffsets,  ///< u32 x cell_count: where each cell's record starts in kRecords; they follow each other without
                   ///< gaps
  kRecords,        ///< bytes, one record a cell: its neighbours and its extent, all numbers in LEB128 (7 bits a byte):
             ///< neighbour count n; when n > 0 the first neighbour minus the cell, zigzag-coded; n - 1 times the step
             ///< to the next neighbour minus one; six growths [unit] from cell to extent: below x, y, z, above x, y, z.
             ///< In component 0 follow landmark_count u16 for each neighbour of a higher index, in order: distances
             ///< [unit / 2^landmark_shift] of their window from the landmarks over window centres, to the nearest
  kComponents,  ///< u16 x cell_count: component label
  kIndex,       ///< BlobBox x index_node_count: bounds, a binary tree in heap order (children 2i + 1 and 2i + 2);
                ///< node i >= L - 1 is a leaf and holds the kCellsPerIndexLeaf cells from (i - (L - 1)) * 8 on
  kObstacles,   ///< bytes: the occupied voxels, packed; for the offline tools alone, may be empty
  kCount,
};
inline constexpr std::size_t kBlobSectionCount = static_cast<std::size_t>(BlobSection::kCount);

struct BlobSectionEntry {
  std::uint32_t offset;  ///< bytes from the first byte of the blob, multiple of 8
  std::uint32_t bytes;
};

/// Corners in units relative to the map origin, low then high.
struct BlobBox {
  std::array<std::uint16_t, 3> lo;
  std::array<std::uint16_t, 3> hi;
};

struct BlobHeader {
  std::array<char, 8> magic;
  std::uint32_t byte_order;
  std::uint32_t version;
  std::uint32_t crc32;                ///< zlib's CRC-32 over the whole blob with this field zero
  std::uint32_t blob_bytes;           ///< size of the whole blob
  double resolution;                  ///< [m] edge of a voxel of the source map
  std::array<double, 3> origin;       ///< [m] frame W: low corner of the mapped box
  double radius;                      ///< [m] inflation radius
  std::uint32_t unknown_policy;       ///< UnknownPolicy
  std::uint32_t unit_shift;           ///< unit = resolution / 2^unit_shift, 0 to 8
  std::array<std::uint32_t, 3> size;  ///< [unit] the map spans 0 to size on each axis, at most 65,535
  std::uint32_t cell_count;
  std::uint32_t neighbour_count;   ///< directed: twice the number of windows
  std::uint32_t index_node_count;  ///< 2 L - 1 with L = ceil(cell_count / kCellsPerIndexLeaf); 0 without cells
  std::uint32_t component_count;
  std::uint32_t landmark_count;  ///< distances stored with each window of component 0, at most kMostLandmarks
  std::uint32_t landmark_shift;  ///< 1 to 16; 0 without landmarks
  std::uint32_t search_points;   ///< SearchPoints
  /// [unit^3] Known free space that the inflation blocks; space that policy `free` would leave free and this one does
  /// not; space dropped by coarsening. For reports.
  std::uint64_t lost_to_inflation;
  std::uint64_t lost_to_unknown;
  std::uint64_t lost_to_coarsening;
  std::uint64_t lost_to_slivers;               ///< thin cells that were dropped; extents may still cover them
  std::array<std::uint8_t, 32> source_digest;  ///< SHA-256 of the source file
  std::array<BlobSectionEntry, kBlobSectionCount> sections;
};

static_assert(sizeof(BlobBox) == 12 && alignof(BlobBox) == 2);
static_assert(sizeof(BlobHeader) == 224 && alignof(BlobHeader) == 8 && sizeof(BlobHeader) % 8 == 0);

}  // namespace swiftlet
