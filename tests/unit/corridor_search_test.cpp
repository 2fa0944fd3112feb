#include "swiftlet/corridor_search.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "search_memory.hpp"
#include "swiftlet_test.hpp"
#include "test_blob.hpp"

namespace {

using swiftlet::BoxGraphView;
using swiftlet::CellIndex;
using swiftlet::find_cell_path;
using swiftlet::IntBox;
using swiftlet::Real;
using swiftlet::SearchMode;
using swiftlet::SearchOptions;
using swiftlet::SearchReport;
using swiftlet::SearchScratch;
using swiftlet::Status;
using swiftlet::Vector3;
using swiftlet::test::SearchMemory;
using swiftlet::test::TestBlob;

constexpr double kTolerance = 1e-5;

struct Found {
  Status status = Status::kOk;
  std::array<CellIndex, 32> path{};
  std::size_t length = 0;
  SearchReport report;
};

Found find(const BoxGraphView& graph, const Vector3& start, const Vector3& goal, const SearchOptions& options,
           const SearchScratch& scratch, std::size_t path_capacity = 32) {
  Found found;
  found.status = find_cell_path(graph, *graph.locate(start), start, *graph.locate(goal), goal, options, scratch,
                                std::span(found.path).first(path_capacity), found.length, found.report);
  return found;
}

Found find(const BoxGraphView& graph, const Vector3& start, const Vector3& goal, SearchMode mode) {
  SearchMemory<64> memory;
  return find(graph, start, goal, {.mode = mode}, memory.scratch());
}

/// A ring around a pillar: the way over the cells 1 and 2 is short, the one over 3, 4 and 5 long.
///   y 6  | 3 3 3 3 |
///   y 4  | 0 # # 4 |
///   y 2  | 1 1 2 5 |  (0 below 3, above 1; 5 below 4)
TestBlob ring() {
  return {{8, 6, 2},
          {IntBox{{0, 2, 0}, {2, 4, 2}}, IntBox{{0, 0, 0}, {4, 2, 2}}, IntBox{{4, 0, 0}, {6, 2, 2}},
           IntBox{{0, 4, 0}, {8, 6, 2}}, IntBox{{6, 2, 0}, {8, 4, 2}}, IntBox{{6, 0, 0}, {8, 2, 2}}}};
}

TEST(CorridorSearch, ACellToItselfIsTheStraightLeg) {
  TestBlob blob = ring();
  const Found found = find(blob.view(), {1, 5, 1}, {4, 5, 1}, SearchMode::kPlain);
  ASSERT_EQ(found.status, Status::kOk);
  ASSERT_EQ(found.length, 1);
  EXPECT_EQ(found.path[0], CellIndex{3});
  EXPECT_NEAR(found.report.cost, 3, kTolerance);
  EXPECT_EQ(found.report.reached, 0);
}

TEST(CorridorSearch, PlainCostIsTheSumOverWindowCentres) {
  TestBlob blob = ring();
  const Found found = find(blob.view(), {1, 3, 1}, {7, 1, 1}, SearchMode::kPlain);
  ASSERT_EQ(found.status, Status::kOk);
  ASSERT_EQ(found.length, 4);
  EXPECT_EQ(found.path[0], CellIndex{0});
  EXPECT_EQ(found.path[1], CellIndex{1});
  EXPECT_EQ(found.path[2], CellIndex{2});
  EXPECT_EQ(found.path[3], CellIndex{5});
  // Centres: (1, 2, 1), (4, 1, 1), (6, 1, 1).
  EXPECT_NEAR(found.report.cost, 1 + std::sqrt(10.0) + 2 + 1, kTolerance);
}

TEST(CorridorSearch, DefaultPointsLieWhereTheStraightLinePasses) {
  // Two cells side by side: through the centre of the window it is 2 sqrt(2), along the wall 2.
  TestBlob blob({4, 3, 2}, {IntBox{{0, 0, 0}, {2, 3, 2}}, IntBox{{2, 0, 0}, {4, 3, 2}}});
  const Vector3 start{1, Real(0.5), 1};
  const Vector3 goal{3, Real(0.5), 1};
  EXPECT_NEAR(find(blob.view(), start, goal, SearchMode::kPlain).report.cost, 2 * std::sqrt(2.0), kTolerance);
  EXPECT_NEAR(find(blob.view(), start, goal, SearchMode::kDefault).report.cost, 2, kTolerance);
}

TEST(CorridorSearch, CostsAreMetresWhateverTheUnit) {
  TestBlob blob({8, 6, 2}, {IntBox{{0, 0, 0}, {4, 6, 2}}, IntBox{{4, 0, 0}, {8, 6, 2}}}, 0.25);
  blob.set_origin({-10, 20, 5});
  const Vector3 start{Real(-9.5), Real(20.75), Real(5.25)};
  const Vector3 goal{Real(-8.5), Real(20.75), Real(5.25)};
  EXPECT_NEAR(find(blob.view(), start, goal, SearchMode::kPlain).report.cost, 1, kTolerance);
}

TEST(CorridorSearch, WithoutAWayThereIsNoPath) {
  TestBlob blob({9, 2, 2}, {IntBox{{0, 0, 0}, {2, 2, 2}}, IntBox{{2, 0, 0}, {4, 2, 2}}, IntBox{{5, 0, 0}, {9, 2, 2}}});
  const Found found = find(blob.view(), {1, 1, 1}, {6, 1, 1}, SearchMode::kPlain);
  EXPECT_EQ(found.status, Status::kNoPath);
  EXPECT_EQ(found.length, 0);
  // Also when a hostile map claims one component.
  blob.section<std::uint16_t>(swiftlet::BlobSection::kComponents)[2] = 0;
  blob.seal();
  const auto graph = BoxGraphView::open(blob.bytes());
  ASSERT_TRUE(graph.ok());
  EXPECT_EQ(find(*graph, {1, 1, 1}, {6, 1, 1}, SearchMode::kPlain).status, Status::kNoPath);
}

TEST(CorridorSearch, TiesAreBrokenByIndex) {
  // Two ways of equal length around a pillar; whatever the goal's side, the lower cell index wins.
  TestBlob blob({6, 6, 1}, {IntBox{{0, 2, 0}, {2, 4, 1}}, IntBox{{0, 0, 0}, {6, 2, 1}}, IntBox{{0, 4, 0}, {6, 6, 1}},
                            IntBox{{4, 2, 0}, {6, 4, 1}}});
  const Vector3 start{1, 3, Real(0.5)};
  const Vector3 goal{5, 3, Real(0.5)};
  for (const SearchMode mode : {SearchMode::kDefault, SearchMode::kLandmarks, SearchMode::kPlain}) {
    const Found there = find(blob.view(), start, goal, mode);
    const Found back = find(blob.view(), goal, start, mode);
    ASSERT_EQ(there.length, 3);
    ASSERT_EQ(back.length, 3);
    EXPECT_EQ(there.path[1], CellIndex{1});
    EXPECT_EQ(back.path[1], CellIndex{1});
  }
}

TEST(CorridorSearch, NodesMinusOneExactAndPlusOne) {
  TestBlob blob = ring();
  SearchMemory<64> memory;
  const Vector3 start{1, 3, 1};
  const Vector3 goal{7, 1, 1};
  const SearchOptions plain{.mode = SearchMode::kPlain};
  const Found roomy = find(blob.view(), start, goal, plain, memory.scratch());
  ASSERT_EQ(roomy.status, Status::kOk);
  const std::size_t needed = roomy.report.reached;
  ASSERT_GT(needed, 2);
  EXPECT_EQ(find(blob.view(), start, goal, plain, memory.scratch(needed - 1)).status, Status::kSearchCapacity);
  for (const std::size_t capacity : {needed, needed + 1}) {
    const Found found = find(blob.view(), start, goal, plain, memory.scratch(capacity));
    EXPECT_EQ(found.status, Status::kOk);
    EXPECT_EQ(found.report.cost, roomy.report.cost);
    EXPECT_EQ(found.report.expanded, roomy.report.expanded);
  }
}

TEST(CorridorSearch, PathMinusOneExactAndPlusOne) {
  TestBlob blob = ring();
  SearchMemory<64> memory;
  const auto search = [&](std::size_t capacity) {
    return find(blob.view(), {1, 3, 1}, {7, 1, 1}, {}, memory.scratch(), capacity);
  };
  EXPECT_EQ(search(3).status, Status::kCorridorCapacity);
  EXPECT_EQ(search(3).length, 0);
  EXPECT_EQ(search(4).status, Status::kOk);
  EXPECT_EQ(search(5).status, Status::kOk);
  EXPECT_EQ(search(5).length, 4);
}

TEST(CorridorSearch, RefusesWeightsThatAreNone) {
  TestBlob blob = ring();
  SearchMemory<64> memory;
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  const Real infinity = std::numeric_limits<Real>::infinity();
  for (const Real weight : {Real(0), Real(-1), Real(0.999), nan, infinity, Real(1e7)}) {
    const SearchOptions options{.mode = SearchMode::kPlain, .weight = weight};
    EXPECT_EQ(find(blob.view(), {1, 3, 1}, {7, 1, 1}, options, memory.scratch()).status, Status::kBadRequest);
  }
}

TEST(CorridorSearch, AWeightNeverCostsMoreThanItself) {
  TestBlob blob = ring();
  SearchMemory<64> memory;
  const auto cost = [&](Real weight) {
    const SearchOptions options{.mode = SearchMode::kPlain, .weight = weight};
    return find(blob.view(), {1, 3, 1}, {7, 3, 1}, options, memory.scratch()).report.cost;
  };
  for (const Real weight : {Real(1.5), Real(3), Real(1000)})
    EXPECT_LE(cost(weight), weight * cost(1) + Real(kTolerance));
}

TEST(CorridorSearch, LandmarksKeepTheCostAndExpandLess) {
  TestBlob blob = ring();
  const Found plain = find(blob.view(), {1, 3, 1}, {7, 3, 1}, SearchMode::kPlain);
  EXPECT_EQ(find(blob.view(), {1, 3, 1}, {7, 3, 1}, SearchMode::kLandmarks).report.expanded, plain.report.expanded);
  blob.set_landmarks(4);
  const Found found = find(blob.view(), {1, 3, 1}, {7, 3, 1}, SearchMode::kLandmarks);
  ASSERT_EQ(found.status, Status::kOk);
  EXPECT_NEAR(found.report.cost, plain.report.cost, kTolerance);
  EXPECT_LT(found.report.expanded, plain.report.expanded);
}

TEST(CorridorSearch, TheMapSaysWhereTheDefaultSeesWindows) {
  TestBlob blob({4, 3, 2}, {IntBox{{0, 0, 0}, {2, 3, 2}}, IntBox{{2, 0, 0}, {4, 3, 2}}});
  const Vector3 start{1, Real(0.5), 1};
  const Vector3 goal{3, Real(0.5), 1};
  blob.set_search_points(swiftlet::SearchPoints::kCentres);
  EXPECT_NEAR(find(blob.view(), start, goal, SearchMode::kDefault).report.cost, 2, kTolerance);  // no landmarks
  blob.set_landmarks(1);
  EXPECT_NEAR(find(blob.view(), start, goal, SearchMode::kDefault).report.cost, 2 * std::sqrt(2.0), kTolerance);
}

TEST(CorridorSearch, LandmarkDistancesThatLieCostLengthOrRoomButNeverTheEnd) {
  SearchMemory<64> memory;
  const Vector3 start{1, 3, 1};
  const Vector3 goal{7, 3, 1};
  TestBlob honest = ring();
  honest.set_landmarks(4);
  const Found truth = find(honest.view(), start, goal, {.mode = SearchMode::kLandmarks}, memory.scratch());
  int lies_that_cost = 0;
  for (const std::uint16_t lie : {std::uint16_t{0}, std::uint16_t{1}, std::uint16_t{0xFFFF}}) {
    TestBlob blob = ring();
    blob.set_landmarks(4);
    blob.set_every_second_distance(lie);
    const Found found = find(blob.view(), start, goal, {.mode = SearchMode::kLandmarks}, memory.scratch());
    ASSERT_EQ(found.status, Status::kOk);
    EXPECT_LE(found.report.expanded, found.report.reached);  // no node twice
    EXPECT_GE(found.report.cost, truth.report.cost - Real(kTolerance));
    for (std::size_t i = 0; i + 1 < found.length; ++i) {
      EXPECT_TRUE(is_passage(intersection(blob.view().cell(found.path[i]), blob.view().cell(found.path[i + 1]))));
    }
    const bool costs = found.report.cost > truth.report.cost || found.report.expanded > truth.report.expanded;
    lies_that_cost += costs ? 1 : 0;
    for (const std::size_t capacity : {std::size_t{1}, std::size_t{2}, std::size_t{3}}) {
      const Found starved = find(blob.view(), start, goal, {.mode = SearchMode::kLandmarks}, memory.scratch(capacity));
      EXPECT_LE(starved.report.reached, capacity);
      EXPECT_TRUE(starved.status == Status::kSearchCapacity || starved.status == Status::kOk);
    }
  }
  EXPECT_GT(lies_that_cost, 0);
}

TEST(CorridorSearch, StartAndGoalOnWindowsAreFine) {
  TestBlob blob = ring();
  const Found found = find(blob.view(), {4, 1, 1}, {6, 1, 1}, SearchMode::kPlain);
  ASSERT_EQ(found.status, Status::kOk);
  EXPECT_NEAR(found.report.cost, 2, kTolerance);
}

}  // namespace
