#pragma once
#include <array>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "swiftlet/types.hpp"

namespace swiftlet::tools {

/// Boxes on the grid of a map: a corner i lies at origin + unit * i in frame W.
struct GridBoxes {
  std::array<double, 3> origin{};  ///< [m]
  double unit = 0;                 ///< [m]
  double resolution = 0;           ///< [m] edge of a voxel, a multiple of the unit
  std::span<const IntBox> boxes;   ///< [unit], disjoint
};

struct PlanReportInput {
  const nlohmann::ordered_json& plan;  ///< swiftlet-plan/1 with any status; fields may be absent
  GridBoxes obstacles;                 ///< of the plan's map, best merged (map/obstacles.hpp); may be empty
  std::string title;                   ///< UTF-8, plain text
};

/// One self-contained HTML page: 3-D view, plots and numbers of a plan, working offline and, but for the view, without
/// WebGL. It carries at most 400,000 obstacle boxes, the largest, and says so when there are more: below 10 MB.
std::string plan_report_html(const PlanReportInput& input);

}  // namespace swiftlet::tools
