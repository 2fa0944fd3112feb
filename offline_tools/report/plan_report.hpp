#pragma once
#include <array>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "swiftlet/types.hpp"

namespace swiftlet::tools {

/// Boxes of whole voxels, disjoint; a corner i lies at origin + resolution * i in frame W.
struct VoxelBoxes {
  std::array<double, 3> origin{};  ///< [m]
  double resolution = 0;           ///< [m] edge of a voxel
  std::span<const IntBox> boxes;   ///< [voxel], any order; merged here where they fit together
};

struct PlanReportInput {
  const nlohmann::ordered_json& plan;  ///< swiftlet-plan/1 with any status; fields may be absent
  VoxelBoxes obstacles;                ///< of the plan's map; may be empty
  std::string title;                   ///< UTF-8, plain text
};

/// One self-contained HTML page: 3-D view, plots and numbers of a plan, working offline and, but for the view, without
/// WebGL. It carries at most 400,000 merged obstacle boxes, the largest, and says so when there are more: below 10 MB.
std::string plan_report_html(const PlanReportInput& input);

}  // namespace swiftlet::tools
