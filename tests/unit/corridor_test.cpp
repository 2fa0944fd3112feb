#include "swiftlet/corridor.hpp"

#include <array>
#include <cmath>
#include <span>

#include "swiftlet_test.hpp"
#include "test_blob.hpp"

namespace {

using swiftlet::Box;
using swiftlet::BoxGraphView;
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

struct Built {
  Status status;
  std::array<IntBox, 8> int_boxes{};
  std::array<Box, 8> boxes{};
  std::array<Box, 8> gates{};
  std::array<Vector3, 9> points{};
  swiftlet::CorridorReport report;
};

Built build(const BoxGraphView& graph, const Vector3& start, const Vector3& goal, std::span<const CellIndex> cells,
            CorridorKind kind, bool relax = true, std::size_t capacity = 8) {
  Built built;
  std::array<TautNode, 9> nodes;
  built.status = build_corridor(
      graph, start, goal, cells, kind, relax,
      {std::span(built.int_boxes).first(capacity), built.boxes, built.gates, built.points, nodes}, built.report);
  return built;
}

const Vector3 kFirstArm{1, 1, 1};
const Vector3 kSecondArm{5, 5, 1};

TEST(BuildCorridor, DropsEveryBoxThatItsNeighboursCanDoWithout) {
  TestBlob blob = corner_blob();
  const Built built = build(blob.view(), kFirstArm, kSecondArm, kCornerPath, CorridorKind::kExtents);
  ASSERT_EQ(built.status, Status::kOk);
  ASSERT_EQ(built.report.box_count, 2);
  EXPECT_EQ(built.int_boxes[0], (IntBox{{0, 0, 0}, {6, 2, 2}}));
  EXPECT_EQ(built.int_boxes[1], (IntBox{{4, 0, 0}, {6, 6, 2}}));
  EXPECT_EQ(built.gates[0].lo, (Vector3{4, 0, 0}));
  EXPECT_EQ(built.gates[0].hi, (Vector3{6, 2, 2}));
  // Around the corner (4, 2), which lies on the straight line here.
  EXPECT_NEAR(built.report.taut.length, 2 * std::sqrt(10.0), 2 * std::sqrt(10.0) * kGap);
  EXPECT_EQ(built.points[0], kFirstArm);
  EXPECT_EQ(built.points[2], kSecondArm);
}

TEST(BuildCorridor, KeepsABoxThatSavesADetour) {
  // An empty hall. The extents of the first and the last cell run along two walls and meet in a corner at (1, 11): 20 m
  // that way, 14.5 m across.
  TestBlob blob({12, 12, 2}, {IntBox{{0, 0, 0}, {2, 2, 2}}, IntBox{{2, 0, 0}, {12, 10, 2}},
                              IntBox{{2, 10, 0}, {12, 12, 2}}, IntBox{{0, 2, 0}, {2, 12, 2}}});
  blob.set_extent(0, IntBox{{0, 0, 0}, {2, 12, 2}});
  blob.set_extent(1, IntBox{{1, 0, 0}, {12, 11, 2}});
  blob.set_extent(2, IntBox{{0, 10, 0}, {12, 12, 2}});
  const std::array<CellIndex, 3> path{CellIndex{0}, CellIndex{1}, CellIndex{2}};
  const Built built = build(blob.view(), {1, 1, 1}, {11, Real(11.5), 1}, path, CorridorKind::kExtents);
  ASSERT_EQ(built.status, Status::kOk);
  EXPECT_EQ(built.report.box_count, 3);
  const double straight = std::hypot(10.0, 10.5);
  EXPECT_NEAR(built.report.taut.length, straight, straight * kGap);
}

TEST(BuildCorridor, TheGoalLiesInTheLastBoxHoweverCloseItIsToAnEarlierOne) {
  // The goal is a millimetre beyond the first box: within the slack of the cover, but not in the box.
  TestBlob blob({20, 2, 2}, {IntBox{{0, 0, 0}, {10, 2, 2}}, IntBox{{10, 0, 0}, {20, 2, 2}}});
  const std::array<CellIndex, 2> path{CellIndex{0}, CellIndex{1}};
  const Built built = build(blob.view(), {1, 1, 1}, {Real(10.001), 1, 1}, path, CorridorKind::kExtents);
  ASSERT_EQ(built.status, Status::kOk);
  EXPECT_EQ(built.report.box_count, 2);
}

TEST(BuildCorridor, AnEdgeContactIsNoShortcut) {
  // The extents of the first and the third cell touch in an edge only, and the path runs close by.
  TestBlob blob({4, 4, 2}, {IntBox{{0, 0, 0}, {2, 2, 2}}, IntBox{{2, 0, 0}, {4, 2, 2}}, IntBox{{2, 2, 0}, {4, 4, 2}}});
  const std::array<CellIndex, 3> path{CellIndex{0}, CellIndex{1}, CellIndex{2}};
  const Built built = build(blob.view(), {1, 1, 1}, {3, 3, 1}, path, CorridorKind::kExtents);
  ASSERT_EQ(built.report.box_count, 3);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_TRUE(is_passage(intersection(built.int_boxes[i], built.int_boxes[i + 1])));
}

TEST(BuildCorridor, KeepsTheCellsOfThePaper) {
  TestBlob blob = corner_blob();
  const Built built = build(blob.view(), kFirstArm, kSecondArm, kCornerPath, CorridorKind::kCells, false);
  ASSERT_EQ(built.status, Status::kOk);
  ASSERT_EQ(built.report.box_count, 5);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(built.int_boxes[i], blob.view().cell(CellIndex(i)));
  EXPECT_EQ(built.gates[0].lo.x(), built.gates[0].hi.x());
}

TEST(BuildCorridor, RelaxesCellsWhenAsked) {
  TestBlob blob = corner_blob();
  const Built built = build(blob.view(), kFirstArm, kSecondArm, kCornerPath, CorridorKind::kCells, true);
  ASSERT_EQ(built.status, Status::kOk);
  ASSERT_EQ(built.report.box_count, 5);
  EXPECT_EQ(built.int_boxes[0], (IntBox{{0, 0, 0}, {4, 2, 2}}));
  for (std::size_t i = 0; i < 5; ++i) EXPECT_TRUE(contains(built.int_boxes[i], blob.view().cell(CellIndex(i))));
}

TEST(BuildCorridor, OneCellIsACorridorOfOneBox) {
  TestBlob blob = corner_blob();
  const std::array<CellIndex, 1> path{CellIndex{3}};
  for (const CorridorKind kind : {CorridorKind::kExtents, CorridorKind::kCells}) {
    const Built built = build(blob.view(), {5, 3, 1}, {5, Real(3.5), 1}, path, kind, true, 1);
    ASSERT_EQ(built.status, Status::kOk);
    EXPECT_EQ(built.report.box_count, 1);
    EXPECT_NEAR(built.report.taut.length, 0.5, 1e-6);
  }
}

TEST(BuildCorridor, CapacityMinusOneExactAndPlusOne) {
  TestBlob blob = corner_blob();
  const auto status = [&](CorridorKind kind, std::size_t capacity) {
    return build(blob.view(), kFirstArm, kSecondArm, kCornerPath, kind, true, capacity).status;
  };
  EXPECT_EQ(status(CorridorKind::kExtents, 0), Status::kCorridorCapacity);
  EXPECT_EQ(status(CorridorKind::kExtents, 1), Status::kCorridorCapacity);
  EXPECT_EQ(status(CorridorKind::kExtents, 2), Status::kOk);  // thinned out before it is pulled taut
  EXPECT_EQ(status(CorridorKind::kExtents, 3), Status::kOk);
  EXPECT_EQ(status(CorridorKind::kCells, 4), Status::kCorridorCapacity);
  EXPECT_EQ(status(CorridorKind::kCells, 5), Status::kOk);
  EXPECT_EQ(status(CorridorKind::kCells, 6), Status::kOk);
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
  // Two windows that meet in the edge x = 1, y = 0: the shortest way bends on the edge, where both points coincide.
  // Moving one point at a time stalls here.
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
  const std::array<Box, 3> gates{Box{{-1, -1, -1}, {1, 1, 1}}, Box{{5, -1, -1}, {6, 1, 1}},
                                 Box{{-1, -1, -1}, {1, 1, 1}}};
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
