#include "swiftlet/blocked_space.hpp"

#include <algorithm>
#include <limits>

#include "harness/random_corridor.hpp"
#include "swiftlet/storage.hpp"
#include "swiftlet_test.hpp"
#include "unit/test_blob.hpp"

namespace swiftlet {
namespace {

constexpr bool kIsDouble = sizeof(Real) == 8;
constexpr Real kRadius = Real(0.25);  // TestBlob's
constexpr double kUnit = 0.125;
constexpr std::uint64_t kSeeds = 6 + test::kPropertyRuns / 50;

PlannerStorage<Capacity{.segments = 48, .search_nodes = 2048}> storage;
BlockedStorage<6, 8> blocked_memory;

/// Two rooms of 4 x 4 x 3 m joined by two passages of 1 m, in units of 1/8 m; every extent is its cell. Static: too
/// large for a small stack.
test::TestBlob blob{
    {80, 32, 24},
    {{{0, 0, 0}, {32, 32, 24}}, {{32, 4, 0}, {48, 12, 24}}, {{32, 20, 0}, {48, 28, 24}}, {{48, 0, 0}, {80, 32, 24}}},
    kUnit};

struct Rooms {
  BoxGraphView map = blob.view();
  BlockedSpace blocked{map, blocked_memory.spans()};
  Planner planner{storage.spans()};
  PlanRequest request;

  Rooms() {
    request.start.position = {Real(0.5), 1, Real(1.5)};
    request.goal.position = {Real(9.5), 1, Real(1.5)};
    request.v_max = 1;
    request.a_max = 2;
  }
  const Plan& plan() { return planner.plan(blocked.view(), request); }
};

constexpr Real kWhole[2] = {-1, 5};  // beyond floor and ceiling

Box wall(Real x0, Real x1, Real y0, Real y1) { return {{x0, y0, kWhole[0]}, {x1, y1, kWhole[1]}}; }

Real distance(const Box& box, const Vector3& p) { return (p - p.cwiseMax(box.lo).cwiseMin(box.hi)).norm(); }

/// Least distance of a plan's path from an obstacle [m].
Real clearance(const Plan& plan, const Box& obstacle) {
  Real least = 1000;
  const Real total = total_duration(plan.segments);
  for (int k = 0; k <= 500; ++k) {
    const Vector3 p = sample_trajectory(plan.segments, total * static_cast<Real>(k) / 500).position;
    least = std::min(least, distance(obstacle, p));
  }
  return least;
}

TEST(BlockedSpace, WithNothingBlockedItIsTheMap) {
  Rooms rooms;
  EXPECT_TRUE(rooms.blocked.view().blocked() == nullptr);
  EXPECT_EQ(rooms.plan().status, Status::kOk);
}

TEST(BlockedSpace, ThePathGoesRoundABoxWithTheMapsRadiusToSpare) {
  Rooms rooms;
  EXPECT_EQ(rooms.plan().status, Status::kOk);
  const Box box = wall(2, Real(2.5), Real(0.5), Real(1.5));
  EXPECT_LT(clearance(rooms.plan(), box), Real(0.01));
  EXPECT_TRUE(rooms.blocked.add(7, box) == Status::kOk);
  const Plan& plan = rooms.plan();
  EXPECT_TRUE(plan.status == Status::kOk || plan.status == Status::kFallback);
  EXPECT_TRUE(plan.certificate.pass);
  EXPECT_GE(clearance(plan, box), kRadius - Real(2e-3));
  EXPECT_FALSE(rooms.blocked.meets(plan.segments, 0));
}

TEST(BlockedSpace, ABlockedPassageIsAvoidedAndTwoOfThemAreNoPath) {
  Rooms rooms;
  const Box first = wall(Real(4.5), 5, 0, 2);
  EXPECT_TRUE(rooms.blocked.add(1, first) == Status::kOk);
  ASSERT_EQ(rooms.plan().status, Status::kOk);
  EXPECT_GE(clearance(rooms.plan(), first), kRadius);
  EXPECT_TRUE(rooms.blocked.add(2, wall(Real(4.5), 5, 2, 4)) == Status::kOk);
  EXPECT_EQ(rooms.plan().status, Status::kNoPath);
  EXPECT_TRUE(rooms.blocked.remove(1));
  EXPECT_EQ(rooms.plan().status, Status::kOk);
}

TEST(BlockedSpace, AfterRemovalEverythingIsAsBefore) {
  Rooms rooms;
  const Plan& plan = rooms.plan();
  ASSERT_EQ(plan.status, Status::kOk);
  const Real duration = total_duration(plan.segments);
  EXPECT_TRUE(rooms.blocked.add(1, wall(2, Real(2.5), 0, 2)) == Status::kOk);
  static_cast<void>(rooms.plan());
  EXPECT_TRUE(rooms.blocked.remove(1));
  EXPECT_FALSE(rooms.blocked.remove(1));
  EXPECT_TRUE(rooms.blocked.view().blocked() == nullptr);
  EXPECT_EQ(total_duration(rooms.plan().segments), duration);
}

TEST(BlockedSpace, TheSameIdMovesItsBox) {
  Rooms rooms;
  EXPECT_TRUE(rooms.blocked.add(1, wall(Real(4.5), 5, 0, 2)) == Status::kOk);
  EXPECT_TRUE(rooms.blocked.add(1, wall(Real(4.5), 5, 2, 4)) == Status::kOk);
  EXPECT_EQ(rooms.blocked.boxes().size(), 1U);
  ASSERT_EQ(rooms.plan().status, Status::kOk);
  EXPECT_LT(clearance(rooms.plan(), wall(Real(4.5), 5, 0, 2)), Real(0.01));
}

TEST(BlockedSpace, StartAndGoalInsideAreNotFree) {
  Rooms rooms;
  EXPECT_TRUE(rooms.blocked.add(1, wall(Real(0.6), 1, 0, 2)) == Status::kOk);
  EXPECT_EQ(rooms.plan().status, Status::kStartNotFree);
  EXPECT_TRUE(rooms.blocked.add(1, wall(9, Real(9.4), 0, 2)) == Status::kOk);
  EXPECT_EQ(rooms.plan().status, Status::kGoalNotFree);
}

TEST(BlockedSpace, RefusesWhatDoesNotFitAndStaysAsItWas) {
  Rooms rooms;
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  EXPECT_TRUE(rooms.blocked.add(1, {{0, 0, nan}, {1, 1, 1}}) == Status::kBadRequest);
  EXPECT_TRUE(rooms.blocked.add(1, {{2, 0, 0}, {1, 1, 1}}) == Status::kBadRequest);
  EXPECT_EQ(rooms.blocked.boxes().size(), 0U);
  for (std::uint32_t id = 0; id < 6; ++id) {
    const Real x = Real(0.1) * static_cast<Real>(id);
    EXPECT_TRUE(rooms.blocked.add(id, wall(6 + x, 6 + x, 2, 2)) == Status::kOk);
  }
  EXPECT_TRUE(rooms.blocked.add(9, wall(1, 1, 1, 1)) == Status::kBufferTooSmall);
  EXPECT_EQ(rooms.blocked.boxes().size(), 6U);
  EXPECT_EQ(rooms.plan().status, Status::kOk);

  static BlockedStorage<4, 1> tiny_memory;
  BlockedSpace tiny(rooms.map, tiny_memory.spans());
  EXPECT_TRUE(tiny.add(1, wall(1, 1, 1, 1)) == Status::kOk);
  EXPECT_TRUE(tiny.add(2, wall(4, 4, 1, 1)) == Status::kBufferTooSmall);  // two cells
  EXPECT_TRUE(tiny.add(3, {{1, 3, 1}, {1, 3, 1}}) == Status::kOk || tiny.boxes().size() == 1);
  EXPECT_TRUE(tiny.meets(IntBox{{8, 8, 0}, {9, 9, 1}}));
}

TEST(BlockedSpace, WhatLiesOffTheMapBlocksNothing) {
  Rooms rooms;
  EXPECT_TRUE(rooms.blocked.add(1, wall(20, 30, 0, 2)) == Status::kOk);
  ASSERT_EQ(rooms.plan().status, Status::kOk);
  EXPECT_FALSE(rooms.blocked.meets(rooms.plan().segments, 0));
}

Box random_obstacle(test::Random& random) {
  const Vector3 lo{random.uniform(0, 10), random.uniform(0, 4), random.uniform(-1, 2)};
  const Vector3 size{random.uniform(0, Real(1.5)), random.uniform(0, Real(1.5)), random.uniform(0, 3)};
  return {lo, lo + size};
}

// Pieces against the definition, unit cube by unit cube: free exactly where the map is and no grown obstacle is.
TEST(BlockedSpace, PiecesTileExactlyWhatIsLeftOfTheMap) {
  for (std::uint64_t seed = 0; seed < kSeeds / 6; ++seed) {
    Rooms rooms;
    test::Random random(seed);
    for (std::uint32_t id = 0; id < 3; ++id) static_cast<void>(rooms.blocked.add(id, random_obstacle(random)));
    const BoxGraphView view = rooms.blocked.view();
    std::uint64_t wrong = 0;
    for (std::uint16_t x = 0; x < 80; ++x) {
      for (std::uint16_t y = 0; y < 32; ++y) {
        for (std::uint16_t z = 0; z < 24; z = static_cast<std::uint16_t>(z + 5)) {
          const IntBox cube{{x, y, z},
                            {static_cast<std::uint16_t>(x + 1), static_cast<std::uint16_t>(y + 1),
                             static_cast<std::uint16_t>(z + 1)}};
          int holders = 0;
          for (std::size_t i = 0; i < view.cell_count(); ++i) {
            const auto cell = static_cast<CellIndex>(i);
            holders += rooms.blocked.cut(cell) == nullptr && contains(view.cell(cell), cube) ? 1 : 0;
          }
          for (const CutPiece& piece : rooms.blocked.pieces()) holders += contains(piece.box, cube) ? 1 : 0;
          const bool free = rooms.map.covered_volume(cube) == 1 && !rooms.blocked.meets(cube);
          wrong += holders == (free ? 1 : 0) ? 0 : 1;
        }
      }
    }
    EXPECT_EQ(wrong, 0U);
  }
}

// Neighbours are mutual and share a passage; extents hold their piece and meet nothing.
TEST(BlockedSpace, NeighboursAndExtentsOfPiecesAreSound) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Rooms rooms;
    test::Random random(seed);
    for (std::uint32_t id = 0; id < 3; ++id) static_cast<void>(rooms.blocked.add(id, random_obstacle(random)));
    const BoxGraphView view = rooms.blocked.view();
    if (view.blocked() == nullptr) continue;
    const std::size_t count = view.cell_count() + rooms.blocked.pieces().size();
    for (std::size_t i = 0; i < count; ++i) {
      const auto cell = static_cast<CellIndex>(i);
      if (i < view.cell_count() && rooms.blocked.cut(cell) != nullptr) continue;
      EXPECT_TRUE(contains(view.extent(cell), view.cell(cell)));
      EXPECT_FALSE(rooms.blocked.meets(view.extent(cell)));
      std::size_t seen = 0;
      visit_neighbours(view, cell, [&](CellIndex neighbour, const IntBox& box) {
        ++seen;
        EXPECT_TRUE(box == view.cell(neighbour));
        bool mutual = false;
        visit_neighbours(view, neighbour, [&](CellIndex back, const IntBox&) {
          mutual = mutual || back == cell;
          return true;
        });
        EXPECT_TRUE(mutual);
        return true;
      });
      std::size_t touching = 0;
      for (std::size_t j = 0; j < count; ++j) {
        const auto other = static_cast<CellIndex>(j);
        if (j == i || (j < view.cell_count() && rooms.blocked.cut(other) != nullptr)) continue;
        touching += is_passage(intersection(view.cell(cell), view.cell(other))) ? 1U : 0U;
      }
      EXPECT_EQ(seen, touching);
    }
  }
}

// Random obstacles: whatever is planned keeps the radius from each of them, and `meets` agrees with the samples.
TEST(BlockedSpace, EveryPlanKeepsTheRadiusFromEveryObstacle) {
  int planned = 0;
  const Real slack = kIsDouble ? Real(1e-5) : Real(3e-3);
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Rooms rooms;
    test::Random random(seed);
    std::array<Box, 3> obstacles;
    std::size_t count = 0;
    const Plan& free_plan = rooms.plan();
    ASSERT_EQ(free_plan.status, Status::kOk);
    for (std::uint32_t id = 0; id < 3; ++id) {
      obstacles[count] = random_obstacle(random);
      if (rooms.blocked.add(id, obstacles[count]) == Status::kOk) ++count;
    }
    Real nearest = 1000;
    for (std::size_t i = 0; i < count; ++i) nearest = std::min(nearest, clearance(free_plan, obstacles[i]));
    EXPECT_TRUE(nearest >= kRadius - slack || rooms.blocked.meets(free_plan.segments, 0));
    const Plan& plan = rooms.plan();
    if (plan.status != Status::kOk && plan.status != Status::kFallback) continue;
    ++planned;
    EXPECT_TRUE(plan.certificate.pass);
    for (std::size_t i = 0; i < count; ++i) EXPECT_GE(clearance(plan, obstacles[i]), kRadius - slack);
    EXPECT_FALSE(rooms.blocked.meets(plan.segments, 0));
  }
  EXPECT_GT(planned, static_cast<int>(kSeeds / 3));
}

}  // namespace
}  // namespace swiftlet
