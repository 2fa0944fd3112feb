#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>

#include "no_heap/heap_guard.hpp"
#include "swiftlet/storage.hpp"
#include "unit/test_blob.hpp"

namespace {

using swiftlet::BoxGraphView;
using swiftlet::test::HeapGuard;
using swiftlet::test::TestBlob;

swiftlet::PlannerStorage<swiftlet::Capacity{.segments = 16, .search_nodes = 64}> storage;
void* volatile sink = nullptr;  // an allocation that nobody sees may be removed

TEST(HeapGuardDeathTest, MallocAbortsUnderAGuard) {
  EXPECT_DEATH(
      {
        const HeapGuard guard;
        sink = std::malloc(8);
      },
      "heap was used");
}

TEST(HeapGuardDeathTest, NewAbortsUnderAGuard) {
  EXPECT_DEATH(
      {
        const HeapGuard guard;
        sink = new double;
      },
      "heap was used");
}

TEST(HeapGuardDeathTest, FreeAbortsUnderAGuard) {
  sink = std::malloc(8);
  EXPECT_DEATH(
      {
        const HeapGuard guard;
        std::free(sink);
      },
      "heap was used");
  std::free(sink);
}

TEST(HeapGuard, AllocationIsAllowedAgainAfterTheGuard) {
  { const HeapGuard guard; }
  sink = std::malloc(8);
  EXPECT_NE(sink, nullptr);
  std::free(sink);
}

TEST(NoHeap, OpensAndSearchesABlobUnderAGuard) {
  TestBlob blob({20, 10, 10}, {{{0, 0, 0}, {10, 10, 10}}, {{10, 2, 2}, {20, 8, 8}}});
  const std::span<const std::byte> bytes = blob.bytes();
  bool found = false;
  {
    const HeapGuard guard;
    const swiftlet::Result<BoxGraphView> view = BoxGraphView::open(bytes);
    found = view.ok() && view->locate({15, 5, 5}).has_value() && view->nearest_free({15, 9, 9}).has_value();
  }
  EXPECT_TRUE(found);
}

TEST(NoHeap, PlansUnderAGuard) {
  TestBlob blob({20, 10, 10}, {{{0, 0, 0}, {10, 10, 10}}, {{10, 2, 2}, {20, 8, 8}}});
  const BoxGraphView view = blob.view();
  swiftlet::Planner planner(storage.spans());
  swiftlet::PlanRequest request;
  request.start.position = {1, 9, 1};
  request.goal.position = {18, 3, 7};
  request.v_max = 1;
  request.a_max = 2;
  swiftlet::Status status = swiftlet::Status::kBadRequest;
  std::size_t sampled = 0;
  {
    const HeapGuard guard;
    const swiftlet::Plan& plan = planner.plan(view, request);
    status = plan.status;
    const swiftlet::Real duration = swiftlet::total_duration(plan.segments);
    for (swiftlet::Real t = 0; t < duration; t += swiftlet::Real(0.1)) {
      sampled += swiftlet::sample_trajectory(plan.segments, t).position.allFinite() ? 1 : 0;
    }
  }
  EXPECT_EQ(status, swiftlet::Status::kOk);
  EXPECT_GT(sampled, 10);
}

TEST(NoHeap, RefusesABadRequestUnderAGuard) {
  TestBlob blob({10, 10, 10}, {{{0, 0, 0}, {10, 10, 10}}});
  const BoxGraphView view = blob.view();
  swiftlet::Planner planner(storage.spans());
  swiftlet::PlanRequest request;
  request.v_max = std::numeric_limits<swiftlet::Real>::quiet_NaN();
  swiftlet::Status status = swiftlet::Status::kOk;
  {
    const HeapGuard guard;
    status = planner.plan(view, request).status;
  }
  EXPECT_EQ(status, swiftlet::Status::kBadRequest);
}

}  // namespace
