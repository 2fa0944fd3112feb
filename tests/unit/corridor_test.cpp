#include "swiftlet/corridor.hpp"

#include <array>
#include <cmath>
#include <span>

#include "swiftlet_test.hpp"
#include "test_blob.hpp"

namespace {

using swiftlet::Box;
using swiftlet::build_corridor;
using swiftlet::CellIndex;
using swiftlet::contains;
using swiftlet::CorridorKind;
using swiftlet::IntBox;
using swiftlet::intersection;
using swiftlet::is_passage;
using swiftlet::kTautGap;
using swiftlet::pull_taut;
using swiftlet::Real;
using swiftlet::Status;
using swiftlet::TautNode;
using swiftlet::TautReport;
using swiftlet::Vector3;
using swiftlet::test::TestBlob;

constexpr double kGap = static_cast<double>(kTautGap);

/// Five cells around a corner: three along x, two along y. Extents reach over the whole arm.
TestBlob corner_blob() {
  TestBlob blob({6, 6, 2}, {IntBox{{0, 0, 0}, {2, 2, 2}}, IntBox{{2, 0, 0}, {4, 2, 2}}, IntBox{{4, 0, 0}, {6, 2, 2}},
                            IntBox{{4, 2, 0}, {6, 4, 2}}, IntBox{{4, 4, 0}, {6, 6, 2}}});
  for (std::size_t cell = 0; cell < 3; ++cell) blob.set_extent(cell, IntBox{{0, 0, 0}, {6, 2, 2}});
  for (std::size_t cell = 3; cell < 5; ++cell) blob.set_extent(cell, IntBox{{4, 0, 0}, {6, 6, 2}});
  return blob;
}
constexpr std::array<CellIndex, 5> kCornerPath{CellIndex{0}, CellIndex{1}, CellIndex{2}, CellIndex{3}, CellIndex{4}};

TEST(BuildCorridor, DropsEveryBoxThatItsNeighboursCanDoWithout) {
  TestBlob blob = corner_blob();
  std::array<IntBox, 8> boxes{};
  std::size_t count = 0;
  ASSERT_EQ(build_corridor(blob.view(), kCornerPath, CorridorKind::kExtents, true, boxes, count), Status::kOk);
  ASSERT_EQ(count, 2);
  EXPECT_EQ(boxes[0], (IntBox{{0, 0, 0}, {6, 2, 2}}));
  EXPECT_EQ(boxes[1], (IntBox{{4, 0, 0}, {6, 6, 2}}));
}

TEST(BuildCorridor, AnEdgeContactIsNoShortcut) {
  // The extents of the first and the third cell touch in an edge only.
  TestBlob blob({4, 4, 2},
                {IntBox{{0, 0, 0}, {2, 2, 2}}, IntBox{{2, 0, 0}, {4, 2, 2}}, IntBox{{2, 2, 0}, {4, 4, 2}}});
  const std::array<CellIndex, 3> path{CellIndex{0}, CellIndex{1}, CellIndex{2}};
  std::array<IntBox, 3> boxes{};
  std::size_t count = 0;
  ASSERT_EQ(build_corridor(blob.view(), path, CorridorKind::kExtents, true, boxes, count), Status::kOk);
  ASSERT_EQ(count, 3);
  for (std::size_t i = 0; i + 1 < count; ++i) EXPECT_TRUE(is_passage(intersection(boxes[i], boxes[i + 1])));
}

TEST(BuildCorridor, KeepsTheCellsOfThePaper) {
  TestBlob blob = corner_blob();
  std::array<IntBox, 5> boxes{};
  std::size_t count = 0;
  ASSERT_EQ(build_corridor(blob.view(), kCornerPath, CorridorKind::kCells, false, boxes, count), Status::kOk);
  ASSERT_EQ(count, 5);
  for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(boxes[i], blob.view().cell(CellIndex(i)));
}

TEST(BuildCorridor, RelaxesCellsWhenAsked) {
  TestBlob blob = corner_blob();
  std::array<IntBox, 5> boxes{};
  std::size_t count = 0;
  ASSERT_EQ(build_corridor(blob.view(), kCornerPath, CorridorKind::kCells, true, boxes, count), Status::kOk);
  ASSERT_EQ(count, 5);
  EXPECT_EQ(boxes[0], (IntBox{{0, 0, 0}, {4, 2, 2}}));
  for (std::size_t i = 0; i < count; ++i) EXPECT_TRUE(contains(boxes[i], blob.view().cell(CellIndex(i))));
}

TEST(BuildCorridor, OneCellIsACorridorOfOneBox) {
  TestBlob blob = corner_blob();
  const std::array<CellIndex, 1> path{CellIndex{3}};
  for (const CorridorKind kind : {CorridorKind::kExtents, CorridorKind::kCells}) {
    std::array<IntBox, 1> boxes{};
    std::size_t count = 0;
    ASSERT_EQ(build_corridor(blob.view(), path, kind, true, boxes, count), Status::kOk);
    EXPECT_EQ(count, 1);
  }
}

TEST(BuildCorridor, CapacityMinusOneExactAndPlusOne) {
  TestBlob blob = corner_blob();
  std::array<IntBox, 6> boxes{};
  std::size_t count = 0;
  const auto build = [&](CorridorKind kind, std::size_t capacity) {
    return build_corridor(blob.view(), kCornerPath, kind, true, std::span(boxes).first(capacity), count);
  };
  EXPECT_EQ(build(CorridorKind::kExtents, 0), Status::kCorridorCapacity);
  EXPECT_EQ(build(CorridorKind::kExtents, 1), Status::kCorridorCapacity);
  EXPECT_EQ(build(CorridorKind::kExtents, 2), Status::kOk);
  EXPECT_EQ(build(CorridorKind::kExtents, 3), Status::kOk);
  EXPECT_EQ(build(CorridorKind::kCells, 4), Status::kCorridorCapacity);
  EXPECT_EQ(build(CorridorKind::kCells, 5), Status::kOk);
  EXPECT_EQ(build(CorridorKind::kCells, 6), Status::kOk);
}

template <std::size_t kGates>
struct Pulled {
  std::array<Vector3, kGates + 2> points;
  TautReport report;
};

template <std::size_t kGates>
Pulled<kGates> pull(const Vector3& start, const Vector3& goal, const std::array<Box, kGates>& gates) {
  Pulled<kGates> pulled;
  std::array<TautNode, kGates + 2> nodes;
  pulled.report = pull_taut(start, goal, gates, pulled.points, nodes);
  return pulled;
}

TEST(PullTaut, WithoutGatesThePathIsTheLegFromStartToGoal) {
  const auto pulled = pull<0>({1, 2, 3}, {4, 6, 3}, {});
  EXPECT_NEAR(pulled.report.length, 5, 1e-5);
  EXPECT_EQ(pulled.report.steps, 0);
  EXPECT_EQ(pulled.points[1], (Vector3{4, 6, 3}));
}

TEST(PullTaut, AStraightWayThroughThinGatesIsFoundStraight) {
  const std::array<Box, 2> gates{Box{{1, -1, -1}, {1, 1, 1}}, Box{{2, -1, -1}, {2, 1, 1}}};
  const auto pulled = pull({0, Real(0.5), 0}, {3, Real(-0.5), 0}, gates);
  const double straight = std::sqrt(10.0);
  EXPECT_LE(pulled.report.length, straight / (1 - kGap));
  EXPECT_EQ(pulled.points[1].x(), 1);
  EXPECT_EQ(pulled.points[2].x(), 2);
}

TEST(PullTaut, BendsAtTheInnerCorner) {
  // The window ends at y = 0, right below the goal: two metres along x, two up along y.
  const std::array<Box, 1> gates{Box{{2, -1, 0}, {2, 0, 2}}};
  const auto pulled = pull({0, 0, 1}, {2, 2, 1}, gates);
  EXPECT_NEAR(pulled.report.length, 4, 4 * kGap);
  EXPECT_GE(pulled.report.length, 4 - 1e-5);
  EXPECT_LE(pulled.report.lower_bound, 4 + 1e-5);
}

TEST(PullTaut, MovesCoincidentPointsOfWindowsThatShareAnEdge) {
  // Two windows that meet in the edge x = 1, y = 0: the shortest way bends on the edge, where both points coincide. Moving
  // one point at a time stalls here.
  const std::array<Box, 2> gates{Box{{1, -4, 0}, {1, 0, 8}}, Box{{1, 0, 0}, {5, 0, 8}}};
  const auto pulled = pull({0, -1, 1}, {2, 1, 7}, gates);
  const double by_hand = std::sqrt(8.0 + 36.0);  // both legs straight in the unfolded plane, here the straight line
  EXPECT_NEAR(pulled.report.length, by_hand, by_hand * kGap);
  EXPECT_NEAR(pulled.points[1].z(), 4, 0.2);
  EXPECT_NEAR(pulled.points[2].z(), 4, 0.2);
}

TEST(PullTaut, FindsTheBestPlaceAlongAnEdgeByReflection) {
  // Over a wall of height 3 and on: the bend lies on the wall's edge, where the unfolded path is straight.
  const std::array<Box, 1> gates{Box{{0, -10, 3}, {0, 10, 9}}};
  const auto pulled = pull({-4, -3, 0}, {4, 3, 0}, gates);
  const double by_hand = std::sqrt(10.0 * 10.0 + 6.0 * 6.0);  // each side 5 m away from the edge in its own plane
  EXPECT_NEAR(pulled.report.length, by_hand, by_hand * kGap);
  EXPECT_NEAR(pulled.points[1].y(), 0, 0.1);
  EXPECT_NEAR(pulled.points[1].z(), 3, 0.05);
}

TEST(PullTaut, ALoopThroughAFarGateIsOutAndBack) {
  const std::array<Box, 3> gates{Box{{-1, -1, -1}, {1, 1, 1}}, Box{{5, -1, -1}, {6, 1, 1}}, Box{{-1, -1, -1}, {1, 1, 1}}};
  const auto pulled = pull({0, 0, 0}, {0, 0, 0}, gates);
  EXPECT_NEAR(pulled.report.length, 10, 10 * kGap);
  EXPECT_LE(pulled.report.lower_bound, 10 + 1e-5);
}

TEST(PullTaut, StayingInPlaceIsALengthOfZero) {
  const std::array<Box, 2> gates{Box{{-1, -1, -1}, {1, 1, 1}}, Box{{0, -1, -1}, {0, 1, 1}}};
  const auto pulled = pull({0, 0, 0}, {0, 0, 0}, gates);
  EXPECT_EQ(pulled.report.length, 0);
  EXPECT_EQ(pulled.report.steps, 0);
}

TEST(PullTaut, GatesThatAreSinglePointsPinThePath) {
  const std::array<Box, 2> gates{Box{{1, 1, 0}, {1, 1, 0}}, Box{{2, 0, 0}, {2, 0, 0}}};
  const auto pulled = pull({0, 0, 0}, {3, 1, 0}, gates);
  EXPECT_NEAR(pulled.report.length, 3 * std::sqrt(2.0), 1e-5);
  EXPECT_LT(pulled.report.steps, swiftlet::kTautSteps);
}

}  // namespace
