#include "report/map_report_page.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "report/page.hpp"
#include "swiftlet/version.hpp"

namespace swiftlet::tools {
namespace {

using Json = nlohmann::ordered_json;

// Base64 of an obstacle or a window takes 16 characters, of a cell with its extent and its component 35.
constexpr std::size_t kMostObstacles = 200'000;
constexpr std::size_t kMostCells = 100'000;
constexpr std::size_t kMostWindows = 100'000;
constexpr std::size_t kMostComponents = 8;  // as many as colours tell apart

struct Component {
  std::uint16_t label = 0;
  std::size_t cells = 0;
  std::uint64_t volume = 0;  ///< [unit^3]
};

/// All components, the largest first.
std::vector<Component> components_of(const BoxGraphView& graph) {
  std::vector<Component> components(graph.header().component_count);
  for (std::size_t i = 0; i < components.size(); ++i) components[i].label = static_cast<std::uint16_t>(i);
  for (std::size_t i = 0; i < graph.cell_count(); ++i) {
    const auto cell = static_cast<CellIndex>(i);
    Component& component = components[graph.component(cell)];
    component.cells += 1;
    component.volume += volume(graph.cell(cell));
  }
  const bool pooled = components.size() == kMostComponentLabels;  // its last one is many and stays behind
  std::stable_sort(components.begin(), components.end() - (pooled ? 1 : 0),
                   [](const Component& a, const Component& b) { return a.volume > b.volume; });
  return components;
}

Json components_json(const BoxGraphView& graph, const std::vector<Component>& components, std::uint64_t free_volume) {
  const double unit_volume = graph.unit() * graph.unit() * graph.unit();
  Json largest = Json::array();
  for (std::size_t i = 0; i < std::min(components.size(), kMostComponents); ++i) {
    const Component& component = components[i];
    const auto units = static_cast<double>(component.volume);
    largest.push_back({{"label", component.label},
                       {"cells", component.cells},
                       {"free_m3", unit_volume * units},
                       {"share", units / static_cast<double>(free_volume)}});
  }
  return largest;
}

Json cells_json(const BoxGraphView& graph, std::uint64_t free_volume) {
  const auto size_of = [&](std::size_t i) { return volume(graph.cell(static_cast<CellIndex>(i))); };
  std::vector<IntBox> cells;
  std::vector<IntBox> extents;
  std::vector<std::uint16_t> components;
  std::uint64_t shown_volume = 0;
  for (const std::size_t i : largest_items(graph.cell_count(), kMostCells, size_of)) {
    const auto cell = static_cast<CellIndex>(i);
    cells.push_back(graph.cell(cell));
    extents.push_back(graph.extent(cell));
    components.push_back(graph.component(cell));
    shown_volume += size_of(i);
  }
  return {{"count", graph.cell_count()},
          {"shown", cells.size()},
          {"shown_share", free_volume == 0 ? 0 : static_cast<double>(shown_volume) / static_cast<double>(free_volume)},
          {"boxes", encode_boxes(cells)},
          {"extents", encode_boxes(extents)},
          {"components", encode_integers(components)}};
}

/// Area of a thin box [unit^2].
std::uint64_t area(const IntBox& window) {
  std::uint64_t product = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int width = window.hi[axis] - window.lo[axis];
    if (width > 0) product *= static_cast<std::uint64_t>(width);
  }
  return product;
}

Json windows_json(const BoxGraphView& graph) {
  std::vector<IntBox> all;
  all.reserve(graph.header().neighbour_count / 2);
  for (std::size_t i = 0; i < graph.cell_count(); ++i) {
    const auto cell = static_cast<CellIndex>(i);
    for (const CellIndex neighbour : graph.neighbours(cell)) {
      if (cell < neighbour) all.push_back(intersection(graph.cell(cell), graph.cell(neighbour)));
    }
  }
  std::vector<IntBox> shown;
  for (const std::size_t i : largest_items(all.size(), kMostWindows, [&](std::size_t at) { return area(all[at]); })) {
    shown.push_back(all[i]);
  }
  return {{"count", all.size()}, {"shown", shown.size()}, {"boxes", encode_boxes(shown)}};
}

}  // namespace

std::string map_report_html(const MapReportInput& input) {
  const BoxGraphView& graph = input.graph;
  const BlobHeader& header = graph.header();
  const std::vector<Component> components = components_of(graph);
  std::uint64_t free_volume = 0;
  for (const Component& component : components) free_volume += component.volume;
  const GridBoxes obstacles{header.origin, graph.unit(), header.resolution, input.obstacles};
  return page(input.title, {{"kind", "map"},
                            {"title", input.title},
                            {"version", kVersion},
                            {"note", input.note},
                            {"grid", {{"origin", header.origin}, {"unit", graph.unit()}, {"voxel", header.resolution}}},
                            {"obstacles", obstacles_json(obstacles, kMostObstacles)},
                            {"cells", cells_json(graph, free_volume)},
                            {"windows", windows_json(graph)},
                            {"components", components_json(graph, components, free_volume)},
                            {"map", input.map}});
}

}  // namespace swiftlet::tools
