#include "swiftlet/planner.hpp"

#include "swiftlet/storage.hpp"
#include "swiftlet_test.hpp"
#include "unit/test_blob.hpp"

namespace swiftlet {
namespace {

constexpr bool kIsDouble = sizeof(Real) == 8;
constexpr Real kNan = std::numeric_limits<Real>::quiet_NaN();

PlannerStorage<Capacity{.segments = 16, .search_nodes = 64}> storage;

/// Two rooms of 4 x 4 x 3 m, a passage of 1 m between them, and a closet that nothing leads to. Units of 1 m.
struct Rooms {
  test::TestBlob blob{
      {12, 8, 3}, {{{0, 0, 0}, {4, 4, 3}}, {{4, 1, 0}, {6, 2, 3}}, {{6, 0, 0}, {10, 4, 3}}, {{0, 6, 0}, {2, 8, 3}}}};
  BoxGraphView graph = blob.view();
  PlanRequest request;
  Planner planner{storage.spans()};

  Rooms() {
    request.start.position = {1, 3, 1};
    request.goal.position = {9, 3, 2};
    request.v_max = 1;
    request.a_max = 1;
  }
  const Plan& plan() { return planner.plan(graph, request); }
};

TEST(Planner, FliesFromRoomToRoomWithACertificate) {
  Rooms rooms;
  const Plan& plan = rooms.plan();
  ASSERT_EQ(plan.status, Status::kOk);
  EXPECT_TRUE(plan.certificate.pass);
  EXPECT_EQ(plan.boxes.size(), plan.segments.size());
  EXPECT_EQ(plan.gates.size() + 1, plan.segments.size());
  const Sample first = sample_trajectory(plan.segments, 0);
  const Sample last = sample_trajectory(plan.segments, total_duration(plan.segments));
  EXPECT_LT((first.position - rooms.request.start.position).norm(), Real(1e-3));
  EXPECT_LT((last.position - rooms.request.goal.position).norm(), Real(1e-3));
  // 8 m at 1 m/s and 1 m/s^2 take 9 s at least; anything near twice that is no plan to be proud of.
  EXPECT_GT(total_duration(plan.segments), Real(8.5));
  EXPECT_LT(total_duration(plan.segments), Real(13));
}

TEST(Planner, BothCorridorsAndBothNormsKeepTheirLimits) {
  for (const CorridorKind kind : {CorridorKind::kExtents, CorridorKind::kCells}) {
    for (const bool relax : {true, false}) {
      for (const LimitNorm norm : {LimitNorm::kAxis, LimitNorm::kEuclidean}) {
        Rooms rooms;
        rooms.request.corridor = kind;
        rooms.request.relax = relax;
        rooms.request.norm = norm;
        const Plan& plan = rooms.plan();
        ASSERT_EQ(plan.status, Status::kOk);
        EXPECT_TRUE(plan.certificate.pass);
        EXPECT_TRUE(norm == LimitNorm::kAxis || plan.certificate.max_speed_norm <= Real(1.001));
      }
    }
  }
}

TEST(Planner, TheSameRequestGivesTheSameBits) {
  Rooms first;
  Rooms second;
  std::array<Segment, 16> kept;
  const Plan& plan = first.plan();
  ASSERT_EQ(plan.status, Status::kOk);
  std::copy(plan.segments.begin(), plan.segments.end(), kept.begin());
  const std::size_t count = plan.segments.size();
  second.request.goal.position = {5, Real(1.5), 1};  // something else in between
  (void)second.plan();
  const Plan& again = first.plan();
  ASSERT_EQ(again.segments.size(), count);
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(again.segments[i].duration, kept[i].duration);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t j = 0; j < kQuinticTerms; ++j) {
        EXPECT_EQ(again.segments[i].coefficients[axis][j], kept[i].coefficients[axis][j]);
      }
    }
  }
}

TEST(Planner, StartEqualToGoalIsOneSegmentOfPositiveDuration) {
  Rooms rooms;
  rooms.request.goal = rooms.request.start;
  const Plan& plan = rooms.plan();
  ASSERT_EQ(plan.status, Status::kOk);
  EXPECT_EQ(plan.segments.size(), std::size_t{1});
  EXPECT_GT(plan.segments[0].duration, Real(0));
}

TEST(Planner, AStartInMotionIsFlownFromItsVelocity) {
  Rooms rooms;
  rooms.request.start.velocity = {Real(0.5), 0, 0};
  const Plan& plan = rooms.plan();
  ASSERT_EQ(plan.status, Status::kOk);
  EXPECT_NEAR(sample_trajectory(plan.segments, 0).velocity[0], 0.5, 1e-3);
}

TEST(Planner, AStartTooFastForItsRoomIsInfeasibleAndSaysWhy) {
  Rooms rooms;
  rooms.request.start.position = {Real(0.1), 3, 1};
  rooms.request.start.velocity = {-1, 0, 0};  // 0.1 m before the wall, and 0.5 m needed to stop
  const Plan& plan = rooms.plan();
  ASSERT_EQ(plan.status, Status::kInfeasible);
  EXPECT_TRUE(plan.segments.empty());
  EXPECT_EQ(plan.trajectory.blocking.axis, 0);
  ASSERT_LT(plan.trajectory.blocking.box, plan.int_boxes.size());
  EXPECT_EQ(plan.int_boxes[plan.trajectory.blocking.box].hi[0], 4);  // the room it is in
  EXPECT_GT(plan.trajectory.blocking.missing, Real(0));
}

TEST(Planner, EndsOutsideFreeSpaceAreNamed) {
  Rooms rooms;
  rooms.request.start.position = {5, 3, 1};  // beside the passage
  EXPECT_EQ(rooms.plan().status, Status::kStartNotFree);
  rooms.request.start.position = {1, 3, 1};
  rooms.request.goal.position = {9, 3, 4};
  EXPECT_EQ(rooms.plan().status, Status::kGoalNotFree);
}

TEST(Planner, SnapMovesAnEndToFreeSpaceWithinItsDistanceAndNoFarther) {
  Rooms rooms;
  rooms.request.start.position = {Real(-0.2), 3, 1};
  rooms.request.snap_distance = Real(0.1);
  EXPECT_EQ(rooms.plan().status, Status::kStartNotFree);
  rooms.request.snap_distance = Real(0.3);
  const Plan& plan = rooms.plan();
  ASSERT_EQ(plan.status, Status::kOk);
  EXPECT_NEAR(plan.start.position[0], 0, 1e-6);
  EXPECT_EQ(plan.start.position[1], Real(3));
}

TEST(Planner, SnapLeavesAPocketForSpaceThatLeadsToTheOtherEnd) {
  const Vector3 between{1, Real(5.1), 1};  // 0.9 m from the closet, 1.1 m from the room
  Rooms rooms;
  rooms.request.snap_distance = Real(1.2);
  rooms.request.start.position = between;
  const Plan& plan = rooms.plan();
  ASSERT_EQ(plan.status, Status::kOk);
  EXPECT_NEAR(plan.start.position[1], 4, 1e-6);
  rooms.request.start.position = {1, 3, 1};
  rooms.request.goal.position = between;
  ASSERT_EQ(rooms.plan().status, Status::kOk);
  EXPECT_NEAR(plan.goal.position[1], 4, 1e-6);
  rooms.request.start.position = {5, Real(4.2), 1};  // nearest to the room, as the closet is too far
  rooms.request.goal.position = {1, 7, 1};           // free, and stays
  EXPECT_EQ(rooms.plan().status, Status::kNoPath);
  rooms.request.start.position = between;
  EXPECT_EQ(rooms.plan().status, Status::kOk);
  rooms.request.goal.position = {9, 3, 2};
  rooms.request.snap_distance = 1;
  EXPECT_EQ(rooms.plan().status, Status::kNoPath);
}

TEST(Planner, NothingLeadsToTheCloset) {
  Rooms rooms;
  rooms.request.goal.position = {1, 7, 1};
  EXPECT_EQ(rooms.plan().status, Status::kNoPath);
}

TEST(Planner, RefusesNumbersThatMakeNoRequest) {
  const auto status_of = [](auto&& spoil) {
    Rooms rooms;
    spoil(rooms.request);
    return rooms.plan().status;
  };
  EXPECT_EQ(status_of([](PlanRequest& r) { r.start.position[1] = kNan; }), Status::kBadRequest);
  EXPECT_EQ(status_of([](PlanRequest& r) { r.goal.velocity[1] = kNan; }), Status::kBadRequest);
  EXPECT_EQ(status_of([](PlanRequest& r) { r.start.acceleration[0] = std::numeric_limits<Real>::infinity(); }),
            Status::kBadRequest);
  for (const Real limit : {Real(0), Real(-1), kNan, Real(1e-9), Real(1e9), std::numeric_limits<Real>::infinity()}) {
    EXPECT_EQ(status_of([&](PlanRequest& r) { r.v_max = limit; }), Status::kBadRequest);
    EXPECT_EQ(status_of([&](PlanRequest& r) { r.a_max = limit; }), Status::kBadRequest);
  }
  EXPECT_EQ(status_of([](PlanRequest& r) { r.snap_distance = kNan; }), Status::kBadRequest);
  EXPECT_EQ(status_of([](PlanRequest& r) { r.search.weight = Real(0.5); }), Status::kBadRequest);
}

TEST(Planner, RunningOutOfNodesOrSegmentsIsAnOrdinaryAnswer) {
  static PlannerStorage<Capacity{.segments = 16, .search_nodes = 1}> few_nodes;
  static PlannerStorage<Capacity{.segments = 2, .search_nodes = 64}> few_segments;
  Rooms rooms;
  Planner starved{few_nodes.spans()};
  EXPECT_EQ(starved.plan(rooms.graph, rooms.request).status, Status::kSearchCapacity);
  Planner narrow{few_segments.spans()};
  EXPECT_EQ(narrow.plan(rooms.graph, rooms.request).status, Status::kCorridorCapacity);
}

TEST(Planner, TheLimitsMayDifferByThreeOrdersOfMagnitude) {
  for (const Real v : {Real(0.05), Real(10)}) {
    for (const Real a : {Real(0.05), Real(10)}) {
      Rooms rooms;
      rooms.request.v_max = v;
      rooms.request.a_max = a;
      const Plan& plan = rooms.plan();
      EXPECT_TRUE(plan.status == Status::kOk || plan.status == Status::kFallback);
      EXPECT_TRUE(plan.certificate.pass);
      EXPECT_TRUE(plan.status == Status::kOk || !kIsDouble);
    }
  }
}

}  // namespace
}  // namespace swiftlet
