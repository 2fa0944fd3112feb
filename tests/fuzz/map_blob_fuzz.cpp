#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <vector>

#include "map/map_report.hpp"
#include "map/obstacles.hpp"
#include "swiftlet/box_graph_view.hpp"

namespace {

using swiftlet::BlobHeader;
using swiftlet::BoxGraphView;
using swiftlet::CellIndex;
using swiftlet::IntBox;
using swiftlet::Vector3;

void require(bool promise) {
  if (!promise) std::abort();
}

/// Uses every part of a blob that was accepted; the sanitizers see any step outside it.
void use(const BoxGraphView& view) {
  for (std::size_t i = 0; i < view.cell_count(); ++i) {
    const auto cell = static_cast<CellIndex>(i);
    std::size_t count = 0;
    for (const CellIndex neighbour : view.neighbours(cell)) {
      require(view.component(neighbour) == view.component(cell));
      ++count;
    }
    require(count == view.neighbours(cell).size());
    require(contains(view.extent(cell), view.cell(cell)));
    const swiftlet::Box box = view.to_world(view.cell(cell));
    require(view.locate((box.lo + box.hi) / 2).has_value());
    require(view.covered_volume(view.cell(cell)) > 0);
    require(view.nearest_free(2 * box.lo - box.hi).has_value());
  }
  (void)swiftlet::tools::obstacle_boxes(view);
  (void)swiftlet::tools::map_info(view);
}

}  // namespace

/// The input is a blob whose size and checksum are put right first: a fuzzer cannot guess a CRC, an attacker computes
/// it.
// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer calls it so
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::uint64_t> aligned((size + 7) / 8);
  if (size > 0) std::memcpy(aligned.data(), data, size);
  const std::span<std::byte> blob = std::as_writable_bytes(std::span(aligned)).first(size);
  (void)BoxGraphView::open(blob);
  if (size < sizeof(BlobHeader)) return 0;
  const auto bytes = static_cast<std::uint32_t>(size);
  std::memcpy(blob.data() + offsetof(BlobHeader, blob_bytes), &bytes, sizeof bytes);
  const std::uint32_t crc = swiftlet::blob_crc32(blob);
  std::memcpy(blob.data() + offsetof(BlobHeader, crc32), &crc, sizeof crc);
  const auto view = BoxGraphView::open(blob);
  if (view.ok()) use(*view);
  return 0;
}
