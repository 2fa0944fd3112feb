#include "cli/map_file.hpp"

#include <array>
#include <cstdio>
#include <cstring>
#include <span>

#include "cli/failure.hpp"
#include "cli/text.hpp"
#include "map/file_io.hpp"
#include "map/obstacles.hpp"

namespace swiftlet::tools {
namespace {

/// What the user can do about a blob that is refused.
const char* advice(Status status) {
  switch (status) {
    case Status::kBlobWrongMagic:
      return "make one with 'swiftlet map build'";
    case Status::kBlobWrongVersion:
    case Status::kBlobWrongByteOrder:
      return "build it again with this program's 'swiftlet map build'";
    default:
      return "copy it again or build it again with 'swiftlet map build'";
  }
}

/// " (1000 of 1234 bytes)" of a blob cut short behind its header.
std::string size_of(Status status, std::span<const std::byte> bytes) {
  if (status != Status::kBlobTruncated || bytes.size() < sizeof(BlobHeader)) return "";
  BlobHeader header{};
  std::memcpy(&header, bytes.data(), sizeof(header));
  return " (" + std::to_string(bytes.size()) + " of " + std::to_string(header.blob_bytes) + " bytes)";
}

double volume(const Box& box) { return (box.hi - box.lo).prod(); }

/// "component 3 (12.5 % of the free space)".
std::string describe_component(const BoxGraphView& graph, std::optional<CellIndex> cell) {
  if (!cell) return "no component";
  const std::uint16_t label = graph.component(*cell);
  double whole = 0;
  double part = 0;
  for (std::size_t i = 0; i < graph.cell_count(); ++i) {
    const auto other = static_cast<CellIndex>(i);
    const double share = volume(graph.to_world(graph.cell(other)));
    whole += share;
    if (graph.component(other) == label) part += share;
  }
  const std::string share = " (" + to_text(100 * part / whole, 1) + " % of the free space";
  if (label == kMostComponentLabels - 1) return "one of the smallest components" + share + " together)";
  return "component " + std::to_string(label) + share + ")";
}

}  // namespace

MapFile load_map(const std::string& path) {
  MapFile map{path, unwrap(read_file(path)), {}};
  if (map.bytes.empty()) throw Failure{ExitStatus::kBadFile, path + ": is empty; make a map with 'swiftlet map build'"};
  const Result<BoxGraphView> graph = BoxGraphView::open(map.bytes);
  if (!graph.ok()) {
    // A short file of another kind is not a swiftlet map cut short.
    const bool has_magic = map.bytes.size() >= kBlobMagic.size() &&
                           std::memcmp(map.bytes.data(), kBlobMagic.data(), kBlobMagic.size()) == 0;
    const Status status = has_magic ? graph.status() : Status::kBlobWrongMagic;
    throw Failure{ExitStatus::kBadFile,
                  path + ": " + describe(status) + size_of(status, map.bytes) + "; " + advice(status)};
  }
  map.graph = *graph;
  return map;
}

std::string crc32_text(const BoxGraphView& graph) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%08x", graph.header().crc32);
  return text.data();
}

const std::vector<IntBox>& Obstacles::boxes() {
  if (!boxes_) boxes_ = unwrap(obstacle_boxes(map_.graph));
  return *boxes_;
}

std::string explain_not_free(const MapFile& map, Obstacles& obstacles, const std::string& which, const Vector3& point) {
  const NotFreeReason why = why_not_free(map.graph, obstacles.boxes(), point);
  std::string line = which + " (" + to_text(point) + ") is not free: " + describe(why.reason);
  if (why.reason == NotFree::kTooClose || why.reason == NotFree::kLostToGrid) {
    line += " (" + to_text(why.obstacle_distance, 3) + " m, radius " + to_text(map.graph.header().radius, 3) + " m" +
            (why.reason == NotFree::kLostToGrid ? ", grid of " + to_text(map.graph.unit(), 3) + " m)" : ")");
  }
  const auto nearest = map.graph.nearest_free(point);
  if (!nearest) return line + "; the map holds no free point at all";
  return line + "; the nearest free point is (" + to_text(nearest->point) + "), " + to_text(nearest->distance, 3) +
         " m away: use it, or --snap";
}

std::string explain_no_path(const MapFile& map, const Vector3& start, const Vector3& goal) {
  return "no way joins the two ends: the start lies in " + describe_component(map.graph, map.graph.locate(start)) +
         ", the goal in " + describe_component(map.graph, map.graph.locate(goal));
}

}  // namespace swiftlet::tools
