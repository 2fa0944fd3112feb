#include "report/plan_report.hpp"

#include <cstddef>

#include "report/page.hpp"
#include "swiftlet/version.hpp"

namespace swiftlet::tools {
namespace {

constexpr std::size_t kMostObstacles = 400'000;  // 16 characters each

}  // namespace

std::string plan_report_html(const PlanReportInput& input) {
  return page(input.title, {{"kind", "plan"},
                            {"title", input.title},
                            {"version", kVersion},
                            {"obstacles", obstacles_json(input.obstacles, kMostObstacles)},
                            {"plan", input.plan}});
}

}  // namespace swiftlet::tools
