// Raising a limit must neither lose an answer nor slow it down: queries of the maze on which a search for durations
// that stops too early, or goes another way, once took up to 23 % longer. `plan_bench --sweep` does it for all.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "board_config.hpp"
#include "map/map_builder.hpp"
#include "map/voxel_map.hpp"
#include "swiftlet/planner.hpp"
#include "swiftlet/storage.hpp"
#include "world/worlds.hpp"

namespace swiftlet::tools {
namespace {

constexpr std::array<std::size_t, 6> kQueries{17, 24, 30, 43, 46, 71};
constexpr std::size_t kSteps = 12;
constexpr Real kSlower = Real(0.01);

/// Of the sweep, 0.5 to 10.
Real limit(std::size_t step) { return Real(0.5) * std::pow(Real(20), static_cast<Real>(step) / (kSteps - 1)); }

class RaisedLimits : public testing::Test {
 protected:
  void SetUp() override {
    const World maze = make_maze(1);
    const std::string bt = to_bt(maze.grid);
    const auto voxels = parse_octree("maze", std::as_bytes(std::span(bt)));
    ASSERT_TRUE(voxels);
    MapBuildOptions options;
    options.radius = maze.radius;
    auto built = build_map(*voxels, "maze", options, [](std::string_view, double) {});
    ASSERT_TRUE(built);
    blob_ = std::move(built->blob);
    map_ = *BoxGraphView::open(blob_);
    const auto queries = make_queries(maze, 1, kQueries.back() + 1);
    for (const std::size_t k : kQueries) {
      const auto start = maze.grid.centre(queries[k].start);
      const auto goal = maze.grid.centre(queries[k].goal);
      PlanRequest request;
      request.start.position = {start[0], start[1], start[2]};
      request.goal.position = {goal[0], goal[1], goal[2]};
      requests_.push_back(request);
    }
  }

  void expect_no_step_slower(std::size_t query, Real v_max, Real a_max, Real& before) {
    PlanRequest request = requests_[query];
    request.v_max = v_max;
    request.a_max = a_max;
    const Plan& plan = planner_.plan(map_, request);
    ASSERT_EQ(plan.status, Status::kOk);
    const Real duration = total_duration(plan.segments);
    if (before > 0) {
      EXPECT_LT(duration, (1 + kSlower) * before)
          << "query " << kQueries[query] << ", limits " << v_max << " and " << a_max;
    }
    before = duration;
  }

  std::vector<std::byte> blob_;
  BoxGraphView map_;
  std::vector<PlanRequest> requests_;
  std::unique_ptr<PlannerStorage<kBoard>> storage_ = std::make_unique<PlannerStorage<kBoard>>();
  Planner planner_{storage_->spans()};
};

TEST_F(RaisedLimits, OfSpeedMakeNoPlanSlower) {
  for (std::size_t query = 0; query < kQueries.size(); ++query) {
    for (const std::size_t a : {0, 6, 11}) {
      Real before = 0;
      for (std::size_t v = 0; v < kSteps; ++v) expect_no_step_slower(query, limit(v), limit(a), before);
    }
  }
}

TEST_F(RaisedLimits, OfAccelerationMakeNoPlanSlower) {
  for (std::size_t query = 0; query < kQueries.size(); ++query) {
    for (const std::size_t v : {3, 11}) {
      Real before = 0;
      for (std::size_t a = 0; a < kSteps; ++a) expect_no_step_slower(query, limit(v), limit(a), before);
    }
  }
}

}  // namespace
}  // namespace swiftlet::tools
