#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <vector>

#include "map/map_report.hpp"
#include "map/obstacles.hpp"
#include "swiftlet/box_graph_view.hpp"
#include "swiftlet/corridor_search.hpp"
#include "swiftlet/planner.hpp"
#include "swiftlet/storage.hpp"

namespace {

using swiftlet::BlobHeader;
using swiftlet::BoxGraphView;
using swiftlet::CellIndex;
using swiftlet::IntBox;
using swiftlet::Vector3;

void require(bool promise) {
  if (!promise) std::abort();
}

void use_landmarks(const BoxGraphView& view, CellIndex cell, CellIndex neighbour) {
  const swiftlet::LandmarkRow row = view.landmarks(cell, neighbour);
  const swiftlet::LandmarkRow same = view.landmarks(neighbour, cell);
  for (std::size_t k = 0; k < view.header().landmark_count; ++k) require(row[k] == same[k]);
}

/// A search that landmark distances of any kind must not hold up.
void search(const BoxGraphView& view) {
  constexpr std::size_t kNodes = 64;
  std::array<swiftlet::SearchNode, kNodes> nodes{};
  std::array<swiftlet::OpenEntry, kNodes> open{};
  std::array<std::uint32_t, 2 * kNodes> hash{};
  std::array<CellIndex, kNodes> path{};
  const auto first = static_cast<CellIndex>(0);
  const auto last = static_cast<CellIndex>(view.cell_count() - 1);
  const Vector3 start = view.to_world(view.cell(first)).lo;
  const Vector3 goal = view.to_world(view.cell(last)).hi;
  for (const auto mode : {swiftlet::SearchMode::kDefault, swiftlet::SearchMode::kLandmarks}) {
    std::size_t length = 0;
    swiftlet::SearchReport report;
    (void)swiftlet::find_cell_path(view, first, start, last, goal, {.mode = mode}, {nodes, open, hash}, path, length,
                                   report);
    require(report.expanded <= kNodes && length <= kNodes);
  }
}

/// A plan from the first cell to the last, corridor and trajectory included: what is answered is certified.
void plan(const BoxGraphView& view) {
  static swiftlet::PlannerStorage<swiftlet::Capacity{.segments = 16, .search_nodes = 64}> storage;
  static swiftlet::Planner planner{storage.spans()};
  const auto centre = [&](std::size_t cell) {
    const swiftlet::Box box = view.to_world(view.cell(static_cast<CellIndex>(cell)));
    return Vector3((box.lo + box.hi) / 2);
  };
  for (const auto kind : {swiftlet::CorridorKind::kExtents, swiftlet::CorridorKind::kCells}) {
    swiftlet::PlanRequest request;
    request.start.position = centre(0);
    request.goal.position = centre(view.cell_count() - 1);
    request.v_max = 1;
    request.a_max = 1;
    request.corridor = kind;
    request.budget.refinement = 0;
    const swiftlet::Plan& found = planner.plan(view, request);
    const bool answered = found.status == swiftlet::Status::kOk || found.status == swiftlet::Status::kFallback;
    require(answered == !found.segments.empty());
    require(!answered || found.certificate.pass);
  }
}

/// Uses every part of a blob that was accepted; the sanitizers see any step outside it.
void use(const BoxGraphView& view) {
  for (std::size_t i = 0; i < view.cell_count(); ++i) {
    const auto cell = static_cast<CellIndex>(i);
    std::size_t count = 0;
    for (const CellIndex neighbour : view.neighbours(cell)) {
      require(view.component(neighbour) == view.component(cell));
      if (view.has_landmarks(view.component(cell))) use_landmarks(view, cell, neighbour);
      ++count;
    }
    require(count == view.neighbours(cell).size());
    require(contains(view.extent(cell), view.cell(cell)));
    const swiftlet::Box box = view.to_world(view.cell(cell));
    require(view.locate((box.lo + box.hi) / 2).has_value());
    require(view.covered_volume(view.cell(cell)) > 0);
    require(view.nearest_free(2 * box.lo - box.hi).has_value());
  }
  if (view.cell_count() > 0) {
    search(view);
    plan(view);
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
