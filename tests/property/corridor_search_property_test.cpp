#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "search_memory.hpp"
#include "swiftlet/corridor_search.hpp"
#include "swiftlet_test.hpp"
#include "unit/test_blob.hpp"

namespace {

using swiftlet::BoxGraphView;
using swiftlet::CellIndex;
using swiftlet::IntBox;
using swiftlet::intersection;
using swiftlet::is_passage;
using swiftlet::Real;
using swiftlet::SearchMode;
using swiftlet::SearchOptions;
using swiftlet::SearchPoints;
using swiftlet::SearchReport;
using swiftlet::Status;
using swiftlet::Vector3;

constexpr std::uint16_t kSize = 12;

/// A cube cut by random planes into at most 32 boxes, a quarter of them taken out.
std::vector<IntBox> random_cells(std::mt19937& random) {
  std::vector<IntBox> boxes{IntBox{{0, 0, 0}, {kSize, kSize, kSize}}};
  for (int cut = 0; cut < 120 && boxes.size() < 32; ++cut) {
    IntBox& low = boxes[random() % boxes.size()];
    const std::size_t axis = random() % 3;
    const int edge = low.hi[axis] - low.lo[axis];
    if (edge < 2) continue;
    IntBox high = low;
    low.hi[axis] = high.lo[axis] =
        static_cast<std::uint16_t>(low.lo[axis] + 1 + static_cast<int>(random() % (edge - 1)));
    boxes.push_back(high);
  }
  std::shuffle(boxes.begin(), boxes.end(), random);
  boxes.resize(boxes.size() - boxes.size() / 4);
  return boxes;
}

/// The point of a window that is nearest to where the straight line from start to goal passes its centre.
Eigen::Vector3d point_on_line(const IntBox& window, const Eigen::Vector3d& start, const Eigen::Vector3d& goal) {
  const Eigen::Vector3d lo(window.lo[0], window.lo[1], window.lo[2]);
  const Eigen::Vector3d hi(window.hi[0], window.hi[1], window.hi[2]);
  const Eigen::Vector3d along = goal - start;
  const double squared = along.squaredNorm();
  const double share = squared > 0 ? std::clamp(((lo + hi) / 2 - start).dot(along) / squared, 0.0, 1.0) : 0;
  return (start + share * along).cwiseMax(lo).cwiseMin(hi);
}

/// A mode's graph written down in full, both sides of every window, and relaxed until nothing changes.
double shortest_by_relaxation(const std::vector<IntBox>& cells, SearchPoints points, std::size_t start_cell,
                              const Eigen::Vector3d& start, std::size_t goal_cell, const Eigen::Vector3d& goal) {
  struct Vertex {
    Eigen::Vector3d point;
    std::size_t a, b;
  };
  std::vector<Vertex> vertices{{start, start_cell, start_cell}, {goal, goal_cell, goal_cell}};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const IntBox window = intersection(cells[i], cells[j]);
      if (!is_passage(window)) continue;
      const Eigen::Vector3d centre =
          Eigen::Vector3d(window.lo[0] + window.hi[0], window.lo[1] + window.hi[1], window.lo[2] + window.hi[2]) / 2;
      vertices.push_back({points == SearchPoints::kCentres ? centre : point_on_line(window, start, goal), i, j});
    }
  }
  std::vector<double> cost(vertices.size(), std::numeric_limits<double>::infinity());
  cost[0] = 0;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      for (std::size_t w = 0; w < vertices.size(); ++w) {
        const bool adjacent = vertices[v].a == vertices[w].a || vertices[v].a == vertices[w].b ||
                              vertices[v].b == vertices[w].a || vertices[v].b == vertices[w].b;
        const double through = cost[v] + (vertices[v].point - vertices[w].point).norm();
        if (!adjacent || through >= cost[w] - 1e-12) continue;
        cost[w] = through;
        changed = true;
      }
    }
  }
  return cost[1];
}

Vector3 random_point(const IntBox& box, std::mt19937& random) {
  Vector3 point;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    point[axis] = box.lo[i] + static_cast<Real>(random() % 65) / 64 * static_cast<Real>(box.hi[i] - box.lo[i]);
  }
  return point;
}

TEST(CorridorSearchProperty, EveryModeFindsTheShortestPathOfItsGraphAndWeightsKeepTheirBound) {
  int paths = 0;
  int line_differs = 0;
  int longer_by_weight = 0;
  std::uint64_t plain_expanded = 0;
  std::uint64_t landmarks_expanded = 0;
  swiftlet::test::SearchMemory<512> memory;
  for (int run = 0; run < swiftlet::test::kPropertyRuns; ++run) {
    SCOPED_TRACE("seed " + std::to_string(run));
    std::mt19937 random(static_cast<unsigned>(run));
    const std::vector<IntBox> cells = random_cells(random);
    swiftlet::test::TestBlob blob({kSize, kSize, kSize}, cells);
    blob.set_landmarks(1 + static_cast<unsigned>(run) % 4);
    blob.set_search_points(run % 2 == 0 ? SearchPoints::kLine : SearchPoints::kCentres);
    const auto graph = BoxGraphView::open(blob.bytes());
    ASSERT_TRUE(graph.ok());
    const std::size_t from = random() % cells.size();
    const std::size_t to = random() % cells.size();
    const Vector3 start = random_point(cells[from], random);
    const Vector3 goal = random_point(cells[to], random);
    const auto shortest = [&](SearchPoints points) {
      return shortest_by_relaxation(cells, points, from, start.cast<double>(), to, goal.cast<double>());
    };
    const double over_centres = shortest(SearchPoints::kCentres);
    const bool on_line = run % 2 == 0 || graph->component(static_cast<CellIndex>(from)) != 0;  // others: no landmarks
    const double by_default = on_line ? shortest(SearchPoints::kLine) : over_centres;
    line_differs += by_default < over_centres * (1 - 1e-3) ? 1 : 0;

    std::vector<CellIndex> path(40);
    std::size_t length = 0;
    SearchReport report;
    const auto search = [&](const SearchOptions& options) {
      return swiftlet::find_cell_path(*graph, static_cast<CellIndex>(from), start, static_cast<CellIndex>(to), goal,
                                      options, memory.scratch(), path, length, report);
    };
    for (const SearchMode mode : {SearchMode::kPlain, SearchMode::kLandmarks, SearchMode::kDefault}) {
      const Status status = search({.mode = mode});
      if (over_centres == std::numeric_limits<double>::infinity()) {
        ASSERT_EQ(status, Status::kNoPath);
        continue;
      }
      ASSERT_EQ(status, Status::kOk);
      const double best = mode == SearchMode::kDefault ? by_default : over_centres;
      ASSERT_NEAR(report.cost, best, 2e-6 * best);
      if (mode == SearchMode::kPlain) plain_expanded += report.expanded;
      if (mode == SearchMode::kLandmarks) landmarks_expanded += report.expanded;
      ASSERT_EQ(path[0], static_cast<CellIndex>(from));
      ASSERT_EQ(path[length - 1], static_cast<CellIndex>(to));
      for (std::size_t i = 0; i + 1 < length; ++i) {
        ASSERT_TRUE(is_passage(intersection(graph->cell(path[i]), graph->cell(path[i + 1]))));
      }
      for (const Real weight : {Real(1.2), Real(2), Real(10)}) {
        ASSERT_EQ(search({.mode = mode, .weight = weight}), Status::kOk);
        ASSERT_LE(report.cost, static_cast<double>(weight) * best * (1 + 2e-6));
        longer_by_weight += report.cost > best * (1 + 1e-4) ? 1 : 0;
      }
    }
    if (over_centres < std::numeric_limits<double>::infinity()) ++paths;
  }
  EXPECT_GT(paths, swiftlet::test::kPropertyRuns / 2);
  EXPECT_GT(line_differs, swiftlet::test::kPropertyRuns / 10);
  EXPECT_LT(landmarks_expanded, plain_expanded * 4 / 5);
  EXPECT_GT(longer_by_weight, 0) << "no weight ever mattered";
}

}  // namespace
