#pragma once
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "swiftlet/box_graph_view.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet::tools {

struct MapReportInput {
  const nlohmann::ordered_json& map;  ///< swiftlet-map/1 of the graph
  const BoxGraphView& graph;
  std::span<const IntBox> obstacles;  ///< [unit] of the graph, disjoint, best merged (map/obstacles.hpp); may be empty
  std::string note;                   ///< what a user should know first; UTF-8, plain text; may be empty
  std::string title;                  ///< UTF-8, plain text
};

/// One self-contained HTML page: 3-D view, sections by height and numbers of a map, working offline and, but for the
/// view, without WebGL. It carries the largest 200,000 obstacle boxes, 100,000 cells with their extents and 100,000
/// windows, and says so when there are more: below 10 MB.
std::string map_report_html(const MapReportInput& input);

}  // namespace swiftlet::tools
