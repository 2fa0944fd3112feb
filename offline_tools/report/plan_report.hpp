#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "report/grid_boxes.hpp"

namespace swiftlet::tools {

struct PlanReportInput {
  const nlohmann::ordered_json& plan;  ///< swiftlet-plan/1 with any status; fields may be absent
  GridBoxes obstacles;                 ///< of the plan's map, best merged (map/obstacles.hpp); may be empty
  std::string title;                   ///< UTF-8, plain text
};

/// One self-contained HTML page: 3-D view, plots and numbers of a plan, working offline and, but for the view, without
/// WebGL. It carries at most 400,000 obstacle boxes, the largest, and says so when there are more: below 10 MB.
std::string plan_report_html(const PlanReportInput& input);

}  // namespace swiftlet::tools
