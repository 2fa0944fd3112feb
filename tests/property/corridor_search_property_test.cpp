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

/// The paper's graph written down in full, both sides of every window, and relaxed until nothing changes.
double shortest_by_relaxation(const std::vector<IntBox>& cells, std::size_t start_cell, const Eigen::Vector3d& start,
                              std::size_t goal_cell, const Eigen::Vector3d& goal) {
  struct Vertex {
    Eigen::Vector3d point;
    std::size_t a, b;
  };
  std::vector<Vertex> vertices{{start, start_cell, start_cell}, {goal, goal_cell, goal_cell}};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const IntBox window = intersection(cells[i], cells[j]);
      if (!is_passage(window)) continue;
      vertices.push_back(
          {Eigen::Vector3d(window.lo[0] + window.hi[0], window.lo[1] + window.hi[1], window.lo[2] + window.hi[2]) / 2,
           i, j});
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

TEST(CorridorSearchProperty, PlainAndLandmarksFindTheShortestPathOfThePaperAndWeightsKeepTheirBound) {
  int paths = 0;
  int longer_by_weight = 0;
  std::uint64_t plain_expanded = 0;
  std::uint64_t landmarks_expanded = 0;
  std::uint64_t unused = 0;
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
    const double shortest = shortest_by_relaxation(cells, from, start.cast<double>(), to, goal.cast<double>());

    std::vector<CellIndex> path(40);
    std::size_t length = 0;
    SearchReport report;
    const auto search = [&](const SearchOptions& options) {
      return swiftlet::find_cell_path(*graph, static_cast<CellIndex>(from), start, static_cast<CellIndex>(to), goal,
                                      options, memory.scratch(), path, length, report);
    };
    for (const SearchMode mode : {SearchMode::kPlain, SearchMode::kLandmarks, SearchMode::kDefault}) {
      const Status status = search({.mode = mode});
      if (shortest == std::numeric_limits<double>::infinity()) {
        ASSERT_EQ(status, Status::kNoPath);
        continue;
      }
      ASSERT_EQ(status, Status::kOk);
      if (mode != SearchMode::kDefault) {
        ASSERT_NEAR(report.cost, shortest, 2e-6 * shortest);
      }
      (mode == SearchMode::kPlain       ? plain_expanded
       : mode == SearchMode::kLandmarks ? landmarks_expanded
                                        : unused) += report.expanded;
      ASSERT_EQ(path[0], static_cast<CellIndex>(from));
      ASSERT_EQ(path[length - 1], static_cast<CellIndex>(to));
      for (std::size_t i = 0; i + 1 < length; ++i) {
        ASSERT_TRUE(is_passage(intersection(graph->cell(path[i]), graph->cell(path[i + 1]))));
      }
    }
    if (shortest == std::numeric_limits<double>::infinity()) continue;
    ++paths;
    for (const Real weight : {Real(1.2), Real(2), Real(10)}) {
      ASSERT_EQ(search({.mode = run % 2 == 0 ? SearchMode::kPlain : SearchMode::kLandmarks, .weight = weight}),
                Status::kOk);
      ASSERT_LE(report.cost, static_cast<double>(weight) * shortest * (1 + 2e-6));
      longer_by_weight += report.cost > shortest * (1 + 1e-4) ? 1 : 0;
    }
  }
  EXPECT_GT(paths, swiftlet::test::kPropertyRuns / 2);
  EXPECT_LT(landmarks_expanded, plain_expanded * 4 / 5);
  EXPECT_GT(longer_by_weight, 0) << "no weight ever mattered";
}

}  // namespace
