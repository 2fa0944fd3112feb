#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <cmath>
#include <optional>
#include <set>
#include <sstream>

#include "world/random.hpp"
#include "world/voxel_path.hpp"
#include "world/worlds.hpp"

namespace swiftlet::tools {
namespace {

constexpr std::size_t kQueries = 100;

/// Distance from a voxel's centre to the nearest occupied cube by looking at every cube [m].
double clearance(const VoxelGrid& grid, const Voxel& voxel) {
  double nearest = 1e9;
  const std::array<double, 3> p = grid.centre(voxel);
  for (std::size_t i = 0; i < grid.voxel_count(); ++i) {
    if (!grid.occupied(grid.voxel(i))) continue;
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double lo = grid.voxel(i)[axis] * grid.resolution();
      const double gap = std::max({lo - p[axis], p[axis] - lo - grid.resolution(), 0.0});
      squared += gap * gap;
    }
    nearest = std::min(nearest, std::sqrt(squared));
  }
  return nearest;
}

TEST(World, TheMazeHasThePapersSizeAndAVerticalMainQueryOfItsLength) {
  for (const std::uint64_t seed : {0U, 1U, 2U, 3U, 77U}) {
    const World maze = make_maze(seed);
    EXPECT_EQ(maze.grid.size(), (Voxel{32, 32, 32})) << seed;
    EXPECT_EQ(maze.grid.occupied_count(), 6774U) << seed;
    const std::vector<WorldQuery> queries = make_queries(maze, seed, 1);
    EXPECT_NEAR(queries.front().astar, 34.4, 2) << seed;
    EXPECT_GT(queries.front().goal[2] - queries.front().start[2], 28) << seed;
  }
}

TEST(World, TheClassroomHasThePapersSizeAndAConnectedMainQuery) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const World room = make_classroom(seed);
    EXPECT_EQ(room.grid.size(), (Voxel{13, 10, 5})) << seed;
    EXPECT_EQ(room.grid.occupied_count(), 54U) << seed;
    const std::vector<WorldQuery> queries = make_queries(room, seed, 1);
    EXPECT_GT(queries.front().astar, queries.front().euclid) << seed;
  }
}

TEST(World, TheOfficeHasThePapersSizeAndAMainQueryOfItsLengthToAHigherFloor) {
  for (const std::uint64_t seed : {1U}) {
    const World office = make_office(seed);
    EXPECT_EQ(office.grid.size(), (Voxel{390, 250, 100})) << seed;
    EXPECT_EQ(office.grid.occupied_count(), 259'237U) << seed;
    EXPECT_LT(office.main_start[2], 25) << seed;
    EXPECT_GT(office.main_goal[2], 25) << seed;
    EXPECT_NEAR(*VoxelPathFinder(office.grid, office.radius).shortest(office.main_start, office.main_goal), 42, 1);
  }
}

TEST(World, AnOfficeOfTwiceTheAreaHasWaysBetweenItsTwoBuildings) {
  const World office = make_office(1, 2);
  EXPECT_EQ(office.grid.size(), (Voxel{390, 500, 100}));
  EXPECT_GE(office.grid.occupied_count(), 2 * 259'237U);
  EXPECT_LE(office.grid.occupied_count(), 2 * 259'237U + 390 * 48);  // the wall between them
  const std::vector<std::uint8_t> roomy = roomy_voxels(office.grid, office.radius);
  const auto share = [&](int y_low, int y_high) {
    double connected = 0;
    for (int y = y_low; y < y_high; ++y) {
      for (int x = 0; x < 390; ++x) connected += roomy[office.grid.index({x, y, 10})];
    }
    return connected / (390 * (y_high - y_low));
  };
  EXPECT_GT(share(0, 250), 0.8);  // of the air at 2 m, less walls and what is near them
  EXPECT_GT(share(250, 500), 0.8);
}

TEST(World, TheForestHasTrunksFromGroundToTopAndAMainQueryFromCornerToCorner) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const World forest = make_forest(seed);
    ASSERT_EQ(forest.grid.size(), (Voxel{200, 200, 25})) << seed;
    std::size_t feet = 0;
    for (int y = 0; y < 200; ++y) {
      for (int x = 0; x < 200; ++x) feet += forest.grid.occupied({x, y, 0}) ? 1 : 0;
    }
    EXPECT_EQ(forest.grid.occupied_count(), 25 * feet) << seed;
    EXPECT_GT(feet, 500U) << seed;
    const std::vector<WorldQuery> queries = make_queries(forest, seed, 1);
    EXPECT_GT(queries.front().astar, 53) << seed;
  }
}

TEST(World, TheSameSeedGivesTheSameBytesAndAnotherSeedOthers) {
  const World maze = make_maze(5);
  EXPECT_EQ(to_bt(maze.grid), to_bt(make_maze(5).grid));
  EXPECT_NE(to_bt(maze.grid), to_bt(make_maze(6).grid));
  EXPECT_EQ(queries_csv(maze, make_queries(maze, 5, 10)), queries_csv(maze, make_queries(maze, 5, 10)));
}

TEST(World, EveryVoxelOfTheOctoMapIsFreeOrOccupiedWithTheLowCornerAtTheOrigin) {
  const World room = make_classroom(1);
  std::istringstream bytes(to_bt(room.grid));
  octomap::OcTree tree(1.0);
  ASSERT_TRUE(tree.readBinary(bytes));
  EXPECT_DOUBLE_EQ(tree.getResolution(), room.grid.resolution());
  std::array<double, 3> low{};
  std::array<double, 3> high{};
  tree.getMetricMin(low[0], low[1], low[2]);
  tree.getMetricMax(high[0], high[1], high[2]);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(low[axis], 0, 1e-9);
    EXPECT_NEAR(high[axis], room.grid.size()[axis] * room.grid.resolution(), 1e-9);
  }
  for (std::size_t i = 0; i < room.grid.voxel_count(); ++i) {
    const std::array<double, 3> p = room.grid.centre(room.grid.voxel(i));
    const octomap::OcTreeNode* node = tree.search(p[0], p[1], p[2]);
    ASSERT_NE(node, nullptr) << i;
    EXPECT_EQ(tree.isNodeOccupied(node), room.grid.occupied(room.grid.voxel(i))) << i;
  }
}

TEST(World, AnOctoMapMayLeaveVoxelsUnknown) {
  const Voxel size{5, 4, 3};
  std::vector<std::uint8_t> codes(60);
  for (std::size_t i = 0; i < codes.size(); ++i) codes[i] = static_cast<std::uint8_t>(i * i % 7 % 3);
  std::istringstream bytes(to_bt(size, 0.5, codes));
  octomap::OcTree tree(1.0);
  ASSERT_TRUE(tree.readBinary(bytes));
  for (int i = 0; i < 60; ++i) {
    const int x = i % 5;
    const int y = i / 5 % 4;
    const int z = i / 20;
    const octomap::OcTreeNode* node = tree.search(0.25 + 0.5 * x, 0.25 + 0.5 * y, 0.25 + 0.5 * z);
    const VoxelCode found = node == nullptr ? kUnknownVoxel : tree.isNodeOccupied(node) ? kOccupiedVoxel : kFreeVoxel;
    EXPECT_EQ(found, codes[static_cast<std::size_t>(i)]) << i;
  }
}

TEST(World, QueriesHaveRoomAtBothEndsAndPathsNoShorterThanTheStraightLine) {
  for (const World& world : {make_maze(1), make_classroom(1)}) {
    const std::vector<WorldQuery> queries = make_queries(world, 1, kQueries);
    ASSERT_EQ(queries.size(), kQueries);
    EXPECT_EQ(queries.front().start, world.main_start);
    EXPECT_EQ(queries.front().goal, world.main_goal);
    for (const WorldQuery& query : queries) {
      EXPECT_GE(query.astar, query.euclid - 1e-9);
      EXPECT_GE(clearance(world.grid, query.start), world.radius + 0.1);
      EXPECT_GE(clearance(world.grid, query.goal), world.radius + 0.1);
    }
  }
}

TEST(World, QueriesCsvHasOneLineAQueryBelowTheHeader) {
  const World room = make_classroom(1);
  const std::string csv = queries_csv(room, make_queries(room, 1, kQueries));
  EXPECT_EQ(csv.substr(0, csv.find('\n')), "x0,y0,z0,x1,y1,z1,euclid_m,astar_m");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 101);
  EXPECT_NE(csv.find("\n0.480,0.480,0.800,3.680,2.720,0.800,"), std::string::npos);
}

/// Dijkstra's algorithm as the contract words it, by looking at every step: 26 neighbours, and no voxel of the box that
/// a step crosses may be blocked.
std::optional<double> plain_shortest(const VoxelGrid& grid, const std::vector<bool>& blocked, const Voxel& from,
                                     const Voxel& to) {
  std::set<std::pair<double, std::size_t>> open{{0, grid.index(from)}};
  std::vector<double> cost(grid.voxel_count(), 1e9);
  cost[grid.index(from)] = 0;
  if (blocked[grid.index(from)]) return std::nullopt;
  while (!open.empty()) {
    const auto [so_far, index] = *open.begin();
    open.erase(open.begin());
    if (index == grid.index(to)) return so_far * grid.resolution();
    const Voxel v = grid.voxel(index);
    for (int step = 0; step < 27; ++step) {
      const Voxel next{v[0] + step % 3 - 1, v[1] + step / 3 % 3 - 1, v[2] + step / 9 - 1};
      if (!grid.contains(next)) continue;
      bool is_free = true;
      for (int corner = 0; corner < 8; ++corner) {
        const auto either = [&](std::size_t axis) { return (corner >> axis & 1) != 0 ? next[axis] : v[axis]; };
        is_free = is_free && !blocked[grid.index({either(0), either(1), either(2)})];
      }
      const double length = so_far + std::hypot(next[0] - v[0], next[1] - v[1], next[2] - v[2]);
      if (!is_free || length >= cost[grid.index(next)] - 1e-12) continue;
      cost[grid.index(next)] = length;
      open.emplace(length, grid.index(next));
    }
  }
  return std::nullopt;
}

TEST(VoxelPath, IsAsLongAsThePathOfAPlainSearchThatTriesEveryStep) {
  SplitMix64 random(7);
  const Voxel size{9, 8, 7};
  const auto draw = [&] { return Voxel{random.between(0, 8), random.between(0, 7), random.between(0, 6)}; };
  int joined = 0;
  for (int world = 0; world < 100; ++world) {
    VoxelGrid grid(size, 0.25);
    for (int cubes = random.between(0, 120); cubes > 0; --cubes) {
      const Voxel voxel = draw();
      grid.fill({voxel, voxel}, true);
    }
    const double radius = world % 3 == 0 ? 0.2 : 0.1;
    std::vector<bool> blocked(grid.voxel_count());
    for (std::size_t i = 0; i < grid.voxel_count(); ++i) blocked[i] = clearance(grid, grid.voxel(i)) < radius - 1e-9;
    VoxelPathFinder finder(grid, radius);
    for (int query = 0; query < 5; ++query) {
      const Voxel from = draw();
      const Voxel to = draw();
      const std::optional<double> expected = plain_shortest(grid, blocked, from, to);
      const std::optional<double> found = finder.shortest(from, to);
      ASSERT_EQ(found.has_value(), expected.has_value()) << world;
      if (!expected) continue;
      EXPECT_NEAR(*found, *expected, 1e-8) << world;
      ++joined;
    }
  }
  EXPECT_GT(joined, 200);
}

TEST(VoxelPath, GoesRoundAWallWithoutCuttingItsCorner) {
  VoxelGrid grid({5, 5, 1}, 1.0);
  grid.fill({{2, 0, 0}, {2, 3, 0}}, true);  // only the column y = 4 is open
  VoxelPathFinder finder(grid, 0.4);
  // (1, 3) to (3, 3): up, two across, down; a diagonal past (2, 3) would cut its corner.
  EXPECT_DOUBLE_EQ(*finder.shortest({1, 3, 0}, {3, 3, 0}), 4.0);
  EXPECT_FALSE(finder.shortest({1, 3, 0}, {2, 3, 0}).has_value());
}

TEST(VoxelPath, FindsNoWayThroughAGapThatIsTighterThanTheRadius) {
  VoxelGrid grid({5, 3, 1}, 1.0);
  grid.fill({{2, 0, 0}, {2, 0, 0}}, true);
  grid.fill({{2, 2, 0}, {2, 2, 0}}, true);
  EXPECT_DOUBLE_EQ(*VoxelPathFinder(grid, 0.5).shortest({0, 1, 0}, {4, 1, 0}), 4.0);
  EXPECT_FALSE(VoxelPathFinder(grid, 0.51).shortest({0, 1, 0}, {4, 1, 0}).has_value());
}

TEST(VoxelPath, ClearanceCountsTheCubeNotItsCentre) {
  VoxelGrid grid({4, 4, 4}, 0.32);
  grid.fill({{0, 0, 0}, {0, 0, 0}}, true);
  const auto clear = [&](const Voxel& voxel, double distance) {
    return voxels_with_clearance(grid, distance)[grid.index(voxel)] != 0;
  };
  EXPECT_TRUE(clear({1, 0, 0}, 0.16));
  EXPECT_FALSE(clear({1, 0, 0}, 0.161));
  EXPECT_TRUE(clear({1, 1, 0}, 0.226));
  EXPECT_FALSE(clear({1, 1, 0}, 0.227));
  EXPECT_FALSE(clear({0, 0, 0}, 0.01));
}

TEST(SplitMix64, GivesThePublishedFirstNumbersOfSeedZero) {
  SplitMix64 random(0);
  EXPECT_EQ(random.next(), 0xe220a8397b1dcdafU);
  EXPECT_EQ(random.next(), 0x6e789e6aa1b965f4U);
}

}  // namespace
}  // namespace swiftlet::tools
