#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>

#include "no_heap/heap_guard.hpp"
#include "swiftlet/hover_thrust.hpp"
#include "swiftlet/margin_ledger.hpp"
#include "swiftlet/storage.hpp"
#include "swiftlet/supervisor.hpp"
#include "swiftlet/tracking_controller.hpp"
#include "swiftlet/trajectory_store.hpp"
#include "swiftlet/yaw.hpp"
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

TEST(NoHeap, FliesUnderAGuard) {
  TestBlob blob({20, 10, 10}, {{{0, 0, 0}, {10, 10, 10}}, {{10, 2, 2}, {20, 8, 8}}});
  const BoxGraphView view = blob.view();
  swiftlet::Planner planner(storage.spans());
  static swiftlet::TrajectorySlots<16> slots;
  swiftlet::TrajectoryStore store(slots.spans());
  swiftlet::Supervisor supervisor({});
  swiftlet::TrackingController controller({});
  swiftlet::StatePredictor predictor({});
  swiftlet::HoverThrustEstimator hover({});
  swiftlet::OfferResult result = swiftlet::OfferResult::kTooLong;
  {
    const HeapGuard guard;
    store.hold({1, 9, 1}, 0);
    const swiftlet::Splice splice = store.begin(0, 1000);
    swiftlet::PlanRequest request;
    request.start = splice.state;
    request.goal.position = {18, 3, 7};
    request.v_max = 1;
    request.a_max = 2;
    const swiftlet::Plan& plan = planner.plan(view, request);
    swiftlet::PlanOffer offer{plan.segments, plan.certificate, {}};
    offer.limits.a_max = plan.qp_a_max;
    result = store.offer(offer, splice, 500);
    swiftlet::SupervisorInputs inputs;
    swiftlet::YawState yaw;
    for (swiftlet::TimeUs now = 0; now < 5'000'000; now += 20'000) {
      inputs.now = now;
      static_cast<void>(supervisor.step(inputs));
      if (now == 4'000'000) store.brake(now);
      const swiftlet::Sample sample = store.sample(now);
      yaw = swiftlet::step_yaw({}, yaw, swiftlet::wanted_yaw({}, sample.position, {5, 5, 5}, yaw.yaw),
                               swiftlet::Real(0.02));
      const swiftlet::VehicleState state = predictor.predict({now, sample.position}, now + 10'000);
      const swiftlet::TrackingCommand command =
          controller.step({sample, yaw.yaw, yaw.rate}, state, predictor.disturbance());
      predictor.record(now, command.commanded_acceleration, command.thrust);
      predictor.learn(state);
      hover.update(now, 0, 1, hover.normalised(command.thrust));
    }
    static_cast<void>(swiftlet::check_margins({}, 1));
  }
  EXPECT_EQ(result, swiftlet::OfferResult::kAccepted);
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
