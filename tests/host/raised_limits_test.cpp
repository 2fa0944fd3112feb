// Raising a limit must neither lose an answer nor slow it down: queries of the maze on which a search for durations
// that stops too early, or goes another way, once took up to 23 % longer. `plan_bench --sweep` does it for all.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "board_config.hpp"
#include "harness/reference_map.hpp"
#include "swiftlet/storage.hpp"

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
    auto maze = test::world_site("maze", make_maze(1), 1);
    ASSERT_TRUE(maze);
    maze_ = std::move(*maze);
  }

  void expect_no_step_slower(std::size_t query, Real v_max, Real a_max, Real& before) {
    PlanRequest request;
    request.start.position = maze_.queries[query].start;
    request.goal.position = maze_.queries[query].goal;
    request.v_max = v_max;
    request.a_max = a_max;
    const Plan& plan = planner_.plan(maze_.graph, request);
    ASSERT_EQ(plan.status, Status::kOk);
    const Real duration = total_duration(plan.segments);
    if (before > 0) {
      EXPECT_LT(duration, (1 + kSlower) * before) << "query " << query << ", limits " << v_max << " and " << a_max;
    }
    before = duration;
  }

  test::SearchSite maze_;
  std::unique_ptr<PlannerStorage<kBoard>> storage_ = std::make_unique<PlannerStorage<kBoard>>();
  Planner planner_{storage_->spans()};
};

TEST_F(RaisedLimits, OfSpeedMakeNoPlanSlower) {
  for (const std::size_t query : kQueries) {
    for (const std::size_t a : {0, 6, 11}) {
      Real before = 0;
      for (std::size_t v = 0; v < kSteps; ++v) expect_no_step_slower(query, limit(v), limit(a), before);
    }
  }
}

TEST_F(RaisedLimits, OfAccelerationMakeNoPlanSlower) {
  for (const std::size_t query : kQueries) {
    for (const std::size_t v : {3, 11}) {
      Real before = 0;
      for (std::size_t a = 0; a < kSteps; ++a) expect_no_step_slower(query, limit(v), limit(a), before);
    }
  }
}

}  // namespace
}  // namespace swiftlet::tools
