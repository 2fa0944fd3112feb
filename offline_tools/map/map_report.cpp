#include "map/map_report.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace swiftlet::tools {
namespace {

std::string to_hex(std::span<const std::uint8_t> bytes) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

std::string to_hex(std::uint32_t value) {
  const std::array<std::uint8_t, 4> bytes{static_cast<std::uint8_t>(value >> 24),
                                          static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8),
                                          static_cast<std::uint8_t>(value)};
  return to_hex(bytes);
}

std::uint64_t units_in(const IntBox& box) {
  std::uint64_t product = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) product *= static_cast<std::uint64_t>(box.hi[axis] - box.lo[axis]);
  return product;
}

struct Component {
  std::uint64_t units = 0;  ///< volume [unit^3]
  CellIndex largest_cell{};
};

/// By floods over the neighbours, since labels run out.
std::vector<Component> components_of(const BoxGraphView& view) {
  std::vector<Component> components;
  std::vector<bool> reached(view.cell_count());
  std::vector<CellIndex> stack;
  for (std::size_t seed = 0; seed < view.cell_count(); ++seed) {
    if (reached[seed]) continue;
    reached[seed] = true;
    stack.push_back(static_cast<CellIndex>(seed));
    Component component{0, stack.back()};
    while (!stack.empty()) {
      const CellIndex cell = stack.back();
      stack.pop_back();
      const std::uint64_t units = units_in(view.cell(cell));
      const std::uint64_t most = units_in(view.cell(component.largest_cell));
      component.units += units;
      if (units > most || (units == most && cell < component.largest_cell)) component.largest_cell = cell;
      for (const CellIndex next : view.neighbours(cell)) {
        if (reached[to_size(next)]) continue;
        reached[to_size(next)] = true;
        stack.push_back(next);
      }
    }
    components.push_back(component);
  }
  return components;
}

std::size_t landmark_bytes(const BoxGraphView& view) {
  std::size_t directed = 0;  // windows of the largest component, from both sides
  for (std::size_t i = 0; i < view.cell_count(); ++i) {
    const auto cell = static_cast<CellIndex>(i);
    if (view.component(cell) == 0) directed += view.neighbours(cell).size();
  }
  return directed / 2 * view.header().landmark_count * sizeof(std::uint16_t);
}

constexpr std::array<const char*, kBlobSectionCount> kSectionNames{"cells",      "record_offsets", "records",
                                                                   "components", "index",          "obstacles"};

nlohmann::ordered_json boards_json(const std::vector<BoardFit>& boards) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const BoardFit& board : boards) {
    list.push_back({{"name", board.name},
                    {"map_bytes", board.memory.map_bytes},
                    {"holds_map", board.holds_map},
                    {"segments", board.capacity.segments},
                    {"search_nodes", board.capacity.search_nodes},
                    {"search_share", board.search_share}});
  }
  return list;
}

}  // namespace

const char* describe(UnknownPolicy policy) {
  switch (policy) {
    case UnknownPolicy::kAvoid:
      return "avoid";
    case UnknownPolicy::kOccupied:
      return "occupied";
    case UnknownPolicy::kFree:
      return "free";
  }
  return "?";
}

MapReport map_info(const BoxGraphView& view) {
  const BlobHeader& header = view.header();
  const double unit_volume = view.unit() * view.unit() * view.unit();
  MapReport report;
  report.source_sha256 = to_hex(header.source_digest);
  report.source = "sha256:" + report.source_sha256;
  report.crc32 = to_hex(header.crc32);
  report.resolution = header.resolution;
  report.unit = view.unit();
  report.radius = header.radius;
  report.unknown = static_cast<UnknownPolicy>(header.unknown_policy);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    report.bounds[axis] = header.origin[axis];
    report.bounds[axis + 3] = header.origin[axis] + view.unit() * header.size[axis];
  }
  report.cells = view.cell_count();
  report.windows = header.neighbour_count / 2;
  report.blob_bytes = header.blob_bytes;
  for (std::size_t i = 0; i < kBlobSectionCount; ++i) report.section_bytes[i] = header.sections[i].bytes;
  report.lost_to_inflation = unit_volume * static_cast<double>(header.lost_to_inflation);
  report.lost_to_unknown = unit_volume * static_cast<double>(header.lost_to_unknown);
  report.lost_to_coarsening = unit_volume * static_cast<double>(header.lost_to_coarsening);
  report.lost_to_slivers = unit_volume * static_cast<double>(header.lost_to_slivers);
  report.worst_loss = std::sqrt(3.0) * view.unit();
  report.boards = fit_to_boards(report.blob_bytes, report.windows);

  std::uint64_t free_units = 0;
  for (std::size_t i = 0; i < view.cell_count(); ++i) {
    const auto cell = static_cast<CellIndex>(i);
    free_units += units_in(view.cell(cell));
    report.degree_max = std::max(report.degree_max, view.neighbours(cell).size());
  }
  report.landmarks = header.landmark_count;
  report.landmark_bytes = landmark_bytes(view);
  report.section_bytes[static_cast<std::size_t>(BlobSection::kRecords)] -= report.landmark_bytes;
  report.searched_over_centres = header.search_points == static_cast<std::uint32_t>(SearchPoints::kCentres);
  report.free_volume = unit_volume * static_cast<double>(free_units);
  const std::vector<Component> components = components_of(view);
  report.components = components.size();
  if (components.empty()) return report;

  const Component& largest = *std::max_element(
      components.begin(), components.end(), [](const Component& a, const Component& b) { return a.units < b.units; });
  report.largest_component = static_cast<double>(largest.units) / static_cast<double>(free_units);
  const Box box = view.to_world(view.cell(largest.largest_cell));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<Eigen::Index>(axis);
    report.largest_component_point[axis] = (box.lo[row] + box.hi[row]) / 2;
  }
  return report;
}

nlohmann::ordered_json map_report_json(const MapReport& report) {
  nlohmann::ordered_json sections;
  std::size_t section_sum = 0;
  for (std::size_t i = 0; i < kBlobSectionCount; ++i) {
    sections[kSectionNames[i]] = report.section_bytes[i];
    section_sum += report.section_bytes[i];
  }
  section_sum += report.landmark_bytes;
  sections["landmarks"] = report.landmark_bytes;
  sections["header_and_padding"] = report.blob_bytes - section_sum;
  const double degree_mean =
      report.cells == 0 ? 0 : 2 * static_cast<double>(report.windows) / static_cast<double>(report.cells);
  nlohmann::ordered_json alternatives = nlohmann::ordered_json::array();
  for (const Alternative& other : report.alternatives.value_or(std::vector<Alternative>{})) {
    alternatives.push_back({{"option", other.option}, {"largest_component", other.largest_component}});
  }
  return {{"format", "swiftlet-map/1"},
          {"source", report.source},
          {"crc32", report.crc32},
          {"resolution_m", report.resolution},
          {"radius_m", report.radius},
          {"unknown", describe(report.unknown)},
          {"bounds", report.bounds},
          {"cells", report.cells},
          {"windows", report.windows},
          {"blob_bytes", report.blob_bytes},
          {"free_m3", report.free_volume},
          {"components", report.components},
          {"largest_component", report.largest_component},
          {"largest_component_point", report.largest_component_point},
          {"unit_m", report.unit},
          {"worst_loss_m", report.worst_loss},
          {"lost_to_inflation_m3", report.lost_to_inflation},
          {"lost_to_unknown_m3", report.lost_to_unknown},
          {"lost_to_coarsening_m3", report.lost_to_coarsening},
          {"lost_to_slivers_m3", report.lost_to_slivers},
          {"degree", {{"mean", degree_mean}, {"max", report.degree_max}}},
          {"section_bytes", sections},
          {"landmarks", report.landmarks},
          {"default_search", report.searched_over_centres ? "landmarks" : "line"},
          {"boards", boards_json(report.boards)},
          {"alternatives", alternatives},
          {"source_sha256", report.source_sha256}};
}

}  // namespace swiftlet::tools
