#include "map/map_builder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>
#include <set>

#include "board_config.hpp"
#include "map/board_fit.hpp"
#include "map/obstacles.hpp"
#include "map_test_worlds.hpp"
#include "swiftlet/box_graph_view.hpp"
#include "swiftlet_test.hpp"

namespace swiftlet::tools {
namespace {

using test::Known;
using test::random_options;
using test::random_world;
using test::SmallWorld;
using test::voxel_map;
using test::world_of;

struct Built {
  BuiltMap map;
  BoxGraphView view;
};

Built build(const SmallWorld& world, const MapBuildOptions& options) {
  auto map = build_map(voxel_map(world), "world", options, [](std::string_view, double) {});
  EXPECT_TRUE(map.has_value()) << map.error().message;
  Built built{std::move(*map), {}};
  built.view = *BoxGraphView::open(built.map.blob);
  return built;
}

/// Distance between a closed box and the cube of a voxel, both in metres.
double distance_to_voxel(const Vector3& lo, const Vector3& hi, int x, int y, int z, double resolution) {
  const Vector3 cube_lo = resolution * Vector3(x, y, z);
  const Vector3 cube_hi = resolution * Vector3(x + 1, y + 1, z + 1);
  return (lo - cube_hi).cwiseMax(cube_lo - hi).cwiseMax(0).norm();
}

/// The contract by brute force: is every point of the box, which lies in one voxel of the world, free?
bool is_free(const SmallWorld& world, const MapBuildOptions& options, const Vector3& lo, const Vector3& hi) {
  constexpr double kRounding = 1e-9;
  const Vector3 middle = (lo + hi) / 2 / world.resolution;
  const Known here = world.at(static_cast<int>(middle.x()), static_cast<int>(middle.y()), static_cast<int>(middle.z()));
  if (here == Known::kOccupied) return false;
  if (here == Known::kUnknown && options.unknown != UnknownPolicy::kFree) return false;
  for (int z = 0; z < world.size[2]; ++z) {
    for (int y = 0; y < world.size[1]; ++y) {
      for (int x = 0; x < world.size[0]; ++x) {
        const bool obstacle = world.at(x, y, z) == Known::kOccupied ||
                              (world.at(x, y, z) == Known::kUnknown && options.unknown == UnknownPolicy::kOccupied);
        if (obstacle && distance_to_voxel(lo, hi, x, y, z, world.resolution) < options.radius - kRounding) return false;
      }
    }
  }
  return true;
}

/// Runs the whole list of promises of a blob against brute force.
void expect_exact(const SmallWorld& world, const MapBuildOptions& options) {
  const Built built = build(world, options);
  const BoxGraphView& view = built.view;
  const BlobHeader& header = view.header();
  const auto size = header.size;

  // Cover: a unit cube lies in exactly one cell when all its points are free, in none otherwise.
  std::uint64_t free_units = 0;
  const auto to_box = [](unsigned x, unsigned y, unsigned z) {
    const auto u16 = [](unsigned i) { return static_cast<std::uint16_t>(i); };
    return IntBox{{u16(x), u16(y), u16(z)}, {u16(x + 1), u16(y + 1), u16(z + 1)}};
  };
  for (unsigned z = 0; z < size[2]; ++z) {
    for (unsigned y = 0; y < size[1]; ++y) {
      for (unsigned x = 0; x < size[0]; ++x) {
        const Box cube = view.to_world(to_box(x, y, z));
        const bool free = is_free(world, options, cube.lo, cube.hi);
        ASSERT_EQ(view.covered_volume(to_box(x, y, z)), free ? 1U : 0U) << x << ' ' << y << ' ' << z;
        free_units += free ? 1U : 0U;
      }
    }
  }
  EXPECT_EQ(view.covered_volume({{0, 0, 0},
                                 {static_cast<std::uint16_t>(size[0]), static_cast<std::uint16_t>(size[1]),
                                  static_cast<std::uint16_t>(size[2])}}),
            free_units);

  for (std::size_t i = 0; i < view.cell_count(); ++i) {
    const auto cell = static_cast<CellIndex>(i);
    const IntBox extent = view.extent(cell);
    const auto units = [](const IntBox& b) {
      return static_cast<std::uint64_t>(b.hi[0] - b.lo[0]) * static_cast<std::uint64_t>(b.hi[1] - b.lo[1]) *
             static_cast<std::uint64_t>(b.hi[2] - b.lo[2]);
    };
    ASSERT_EQ(view.covered_volume(extent), units(extent));  // all free
    for (std::size_t axis = 0; axis < 3; ++axis) {          // and maximal
      IntBox below = extent;
      IntBox above = extent;
      if (extent.lo[axis] > 0) {
        below.lo[axis] = static_cast<std::uint16_t>(extent.lo[axis] - 1);
        EXPECT_LT(view.covered_volume(below), units(below));
      }
      if (extent.hi[axis] < size[axis]) {
        above.hi[axis] = static_cast<std::uint16_t>(extent.hi[axis] + 1);
        EXPECT_LT(view.covered_volume(above), units(above));
      }
    }
    // Windows: exactly the pairs that touch with positive extent on two axes.
    std::vector<CellIndex> expected;
    for (std::size_t j = 0; j < view.cell_count(); ++j) {
      const auto other = static_cast<CellIndex>(j);
      if (j != i && is_passage(intersection(view.cell(cell), view.cell(other)))) expected.push_back(other);
    }
    const auto row = view.neighbours(cell);
    EXPECT_TRUE(std::equal(row.begin(), row.end(), expected.begin(), expected.end()));
  }

  // Components: labels agree exactly with a flood over windows.
  std::vector<int> flood(view.cell_count(), -1);
  int floods = 0;
  for (std::size_t seed = 0; seed < view.cell_count(); ++seed) {
    if (flood[seed] >= 0) continue;
    std::vector<std::size_t> stack{seed};
    flood[seed] = floods;
    while (!stack.empty()) {
      const std::size_t i = stack.back();
      stack.pop_back();
      for (const CellIndex next : view.neighbours(static_cast<CellIndex>(i))) {
        if (flood[to_size(next)] >= 0) continue;
        flood[to_size(next)] = floods;
        stack.push_back(to_size(next));
      }
    }
    ++floods;
  }
  EXPECT_EQ(header.component_count, static_cast<std::uint32_t>(floods));
  for (std::size_t i = 0; i < view.cell_count(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_EQ(flood[i] == flood[j],
                view.component(static_cast<CellIndex>(i)) == view.component(static_cast<CellIndex>(j)));
    }
  }
}

TEST(MapBuilder, CoversExactlyWhatTheContractCallsFreeInRandomWorlds) {
  for (int run = 0; run < std::max(20, test::kPropertyRuns / 10); ++run) {
    SCOPED_TRACE(run);
    std::mt19937 random(static_cast<unsigned>(run));
    const SmallWorld world = random_world(random);
    expect_exact(world, random_options(random, world.resolution));
    if (testing::Test::HasFailure()) break;
  }
}

TEST(MapBuilder, RandomPointsOfCellsAndExtentsAreFree) {
  for (int run = 0; run < std::max(20, test::kPropertyRuns / 10); ++run) {
    SCOPED_TRACE(run);
    std::mt19937 random(static_cast<unsigned>(run) + 1000);
    const SmallWorld world = random_world(random);
    const MapBuildOptions options = random_options(random, world.resolution);
    const Built built = build(world, options);
    for (std::size_t i = 0; i < built.view.cell_count(); ++i) {
      const Box box = built.view.to_world(built.view.extent(static_cast<CellIndex>(i)));
      for (int k = 0; k < 4; ++k) {
        Vector3 p;
        for (int axis = 0; axis < 3; ++axis) {
          p[axis] = box.lo[axis] +
                    (box.hi[axis] - box.lo[axis]) * std::uniform_real_distribution<double>(0.001, 0.999)(random);
        }
        ASSERT_TRUE(is_free(world, options, p, p));
        ASSERT_TRUE(built.view.locate(p).has_value());
      }
    }
    // And the other way round: a free point is lost only near an obstacle, within the stated loss.
    const double loss = built.map.report.worst_loss;
    MapBuildOptions wider = options;
    wider.radius += loss;
    for (int k = 0; k < 50; ++k) {
      Vector3 p;
      for (int axis = 0; axis < 3; ++axis) {
        p[axis] = world.resolution * world.size[static_cast<std::size_t>(axis)] *
                  std::uniform_real_distribution<double>(0, 1)(random);
      }
      const bool found = built.view.locate(p).has_value();
      EXPECT_LE(is_free(world, wider, p, p), found);
      EXPECT_LE(found, is_free(world, options, p, p));
    }
  }
}

TEST(MapBuilder, KeepsTheExactDistanceAcrossCorners) {
  // Radius 1.4 voxels, in units of a half: diagonal distance counts, not the larger of both axes.
  const SmallWorld world = world_of({{"#....", ".....", ".....", "....."}});
  MapBuildOptions options;
  options.radius = 1.4;
  expect_exact(world, options);
  const Built built = build(world, options);
  EXPECT_TRUE(built.view.locate(Vector3(2.5, 2.5, 0.5)).has_value());   // (1.5, 1.5) away
  EXPECT_FALSE(built.view.locate(Vector3(1.9, 1.9, 0.5)).has_value());  // 1.27 away
  EXPECT_FALSE(built.view.locate(Vector3(2.3, 0.5, 0.5)).has_value());  // 1.3 away
}

TEST(MapBuilder, TreatsUnknownSpaceAsThePolicySays) {
  const SmallWorld world = world_of({{"...?......"}});
  MapBuildOptions options;
  options.radius = 1;
  options.unknown = UnknownPolicy::kFree;
  EXPECT_EQ(build(world, options).map.report.free_volume, 10);
  options.unknown = UnknownPolicy::kAvoid;
  const Built avoid = build(world, options);
  EXPECT_EQ(avoid.map.report.free_volume, 9);
  EXPECT_EQ(avoid.map.report.lost_to_unknown, 1);
  EXPECT_EQ(avoid.map.report.components, 2U);
  EXPECT_NEAR(avoid.map.report.largest_component, 6.0 / 9, 1e-12);
  EXPECT_EQ(avoid.map.report.largest_component_point, (std::array<double, 3>{7, 0.5, 0.5}));
  EXPECT_TRUE(avoid.view.locate(Vector3(3, 0.5, 0.5)).has_value());  // the face of a free voxel is free
  options.unknown = UnknownPolicy::kOccupied;
  const Built occupied = build(world, options);
  EXPECT_EQ(occupied.map.report.free_volume, 7);  // what lies outside the box is not inflated
  EXPECT_EQ(occupied.map.report.lost_to_unknown, 3);
}

TEST(MapBuilder, CountsComponentsBeyondTheLabels) {
  SmallWorld world{{82, 82, 82}, 1, {}};  // 41^3 free voxels, none beside another
  for (int z = 0; z < 82; ++z) {
    for (int y = 0; y < 82; ++y) {
      for (int x = 0; x < 82; ++x) world.voxels.push_back((x | y | z) % 2 == 0 ? Known::kFree : Known::kUnknown);
    }
  }
  const Built built = build(world, {});
  EXPECT_EQ(built.view.header().component_count, kMostComponentLabels);
  EXPECT_EQ(built.map.report.cells, 68'921U);
  EXPECT_EQ(built.map.report.components, 68'921U);
  EXPECT_NEAR(built.map.report.largest_component, 1.0 / 68'921, 1e-12);
}

TEST(MapBuilder, AMapWithoutFreeSpaceIsStillABlob) {
  MapBuildOptions options;
  options.radius = 0.5;
  const Built built = build(world_of({{"##", "##"}}), options);
  EXPECT_EQ(built.view.cell_count(), 0U);
  EXPECT_EQ(built.map.report.components, 0U);
  EXPECT_EQ(map_report_json(built.map.report)["free_m3"], 0);
}

TEST(MapBuilder, BoundsCropTheMapButNotTheInflation) {
  const SmallWorld world = world_of({{"#.........", ".........."}});
  MapBuildOptions options;
  options.radius = 2;
  options.bounds = {1, 0.25, -5, 8.9, 2, 99};  // whole voxels inside: x 1 to 8, y 1 to 2, z 0 to 1
  const Built built = build(world, options);
  EXPECT_EQ(built.map.report.bounds, (std::array<double, 6>{1, 1, 0, 8, 2, 1}));
  EXPECT_FALSE(built.view.locate(Vector3(2, 1.5, 0.5)).has_value());
  EXPECT_TRUE(built.view.locate(Vector3(3.5, 1.5, 0.5)).has_value());
  EXPECT_FALSE(built.view.locate(Vector3(8.5, 1.5, 0.5)).has_value());
  options.bounds = {20, 0, 0, 30, 1, 1};
  const auto none = build_map(voxel_map(world), "world", options, [](std::string_view, double) {});
  ASSERT_FALSE(none.has_value());
  EXPECT_NE(none.error().message.find("--bounds"), std::string::npos);
}

TEST(MapBuilder, CoarseningKeepsWholeFreeBlocksOnly) {
  const SmallWorld world = world_of({{"....#...", "........"}, {"........", "........"}});
  MapBuildOptions options;
  options.radius = 0;
  options.coarsen = 2;
  const Built built = build(world, options);
  EXPECT_EQ(built.map.report.free_volume, 24);
  EXPECT_EQ(built.map.report.lost_to_coarsening, 7);
  EXPECT_FALSE(built.view.locate(Vector3(5.5, 1.5, 1.5)).has_value());
  EXPECT_TRUE(built.view.locate(Vector3(6.5, 0.5, 0.5)).has_value());
}

TEST(MapBuilder, RefusesAMapBeyondItsIntegersAndSuggestsBounds) {
  VoxelMap map;
  map.resolution = 0.1;
  map.size = {65'536, 1, 1};
  map.leaves = {{{0, 0, 0}, 0, false}, {{65'535, 0, 0}, 0, false}};
  MapBuildOptions options;
  options.radius = 0.3;
  const auto built = build_map(map, "long.bt", options, [](std::string_view, double) {});
  ASSERT_FALSE(built.has_value());
  EXPECT_EQ(built.error().exit_status, 3);
  EXPECT_NE(built.error().message.find("--bounds"), std::string::npos);
  map.size = {60'000, 60'000, 60'000};  // a hostile header: two voxels far apart must not take terabytes
  EXPECT_FALSE(build_map(map, "wide.bt", options, [](std::string_view, double) {}).has_value());
}

TEST(MapBuilder, SaysWhenWaysAreTooLongForLandmarks) {
  for (const std::uint16_t length : {std::uint16_t{30'000}, std::uint16_t{40'000}}) {
    VoxelMap map;  // a corridor with a niche at each end
    map.resolution = 0.1;
    map.size = {length, 2, 1};
    const auto last = static_cast<std::uint16_t>(length - 1);
    for (std::uint16_t x = 0; x < length; ++x) map.leaves.push_back({{x, 0, 0}, 0, false});
    map.leaves.push_back({{0, 1, 0}, 0, false});
    map.leaves.push_back({{last, 1, 0}, 0, false});
    const auto built = build_map(map, "long", {}, [](std::string_view, double) {});
    ASSERT_TRUE(built.has_value()) << built.error().message;
    EXPECT_EQ(built->report.landmarks_too_far, length > 32'767);
    EXPECT_EQ(built->report.landmarks == 0, length > 32'767);
  }
}

TEST(MapBuilder, TheSameMapGivesTheSameBytes) {
  std::mt19937 random(7);
  const SmallWorld world = random_world(random);
  MapBuildOptions options;
  options.radius = 0.2 * world.resolution;
  EXPECT_EQ(build(world, options).map.blob, build(world, options).map.blob);
  EXPECT_EQ(build(world, options).map.report.crc32.size(), 8U);
}

TEST(MapBuilder, TheReportHasTheFieldsOfTheContract) {
  MapBuildOptions options;
  options.radius = 0.5;
  const auto json = map_report_json(build(world_of({{"....#..."}}), options).map.report);
  for (const char* key : {"format", "source", "crc32", "resolution_m", "radius_m", "unknown", "bounds", "cells",
                          "windows", "blob_bytes", "free_m3", "components", "largest_component"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(json["format"], "swiftlet-map/1");
  EXPECT_EQ(json["source"], "world");
  EXPECT_EQ(json["unknown"], "avoid");
  EXPECT_EQ(json["free_m3"], 6);
}

TEST(BoardFit, KnowsEveryFolderBelowBoardsAndItsOwnBoardsPromises) {
  std::set<std::string> folders;
  for (const auto& entry : std::filesystem::directory_iterator(SWIFTLET_SOURCE_DIR "/boards")) {
    if (std::filesystem::exists(entry.path() / "board_config.hpp")) folders.insert(entry.path().filename().string());
  }
  std::set<std::string> names;
  for (const BoardFit& board : fit_to_boards(0, 0)) {
    names.insert(board.name);
    EXPECT_TRUE(board.holds_map);
    EXPECT_EQ(board.search_share, 1);
    if (board.name != "linux-x86_64") continue;
    EXPECT_EQ(board.capacity.search_nodes, kBoard.search_nodes);
    EXPECT_EQ(board.memory.map_bytes, kBoardMemory.map_bytes);
  }
  EXPECT_EQ(names, folders);
}

TEST(BoardFit, HoldsAMapOfItsRegionsSizeAndNoByteMoreAndSearchesAShareOfTooManyWindows) {
  for (const BoardFit& board : fit_to_boards(0, 0)) {
    const auto fit = [&](std::uint64_t bytes, std::uint64_t windows) {
      const std::vector<BoardFit> fits = fit_to_boards(bytes, windows);
      return *std::find_if(fits.begin(), fits.end(), [&](const BoardFit& other) { return other.name == board.name; });
    };
    const std::uint64_t nodes = board.capacity.search_nodes;
    EXPECT_TRUE(fit(board.memory.map_bytes, nodes).holds_map);
    EXPECT_EQ(fit(board.memory.map_bytes, nodes).search_share, 1);
    EXPECT_FALSE(fit(board.memory.map_bytes + 1, nodes).holds_map);
    EXPECT_EQ(fit(0, 4 * nodes).search_share, 0.25);
  }
}

TEST(Obstacles, ComeBackAsTheOccupiedVoxelsAndNothingElse) {
  for (int run = 0; run < 50; ++run) {
    SCOPED_TRACE(run);
    std::mt19937 random(static_cast<unsigned>(run));
    const SmallWorld world = random_world(random);
    const MapBuildOptions options = random_options(random, world.resolution);
    const Built built = build(world, options);
    const auto boxes = obstacle_boxes(built.view);
    ASSERT_TRUE(boxes.has_value());
    for (int z = 0; z < world.size[2]; ++z) {
      for (int y = 0; y < world.size[1]; ++y) {
        for (int x = 0; x < world.size[0]; ++x) {
          const Vector3 middle = world.resolution * Vector3(x + 0.5, y + 0.5, z + 0.5);
          const auto holds = [&](const IntBox& box) {
            const Box b = built.view.to_world(box);
            return (middle.array() > b.lo.array()).all() && (middle.array() < b.hi.array()).all();
          };
          EXPECT_EQ(std::count_if(boxes->begin(), boxes->end(), holds), world.at(x, y, z) == Known::kOccupied ? 1 : 0);
        }
      }
    }
  }
}

TEST(Obstacles, TellWhyAPointFartherAwayThanTheRadiusIsNotFree) {
  const auto reason = [](const SmallWorld& world, const MapBuildOptions& options, const Vector3& p) {
    const Built built = build(world, options);
    EXPECT_FALSE(built.view.locate(p).has_value());
    return why_not_free(built.view, *obstacle_boxes(built.view), p).reason;
  };
  MapBuildOptions options;
  options.radius = 1.2;  // units of a whole voxel: a flat wall keeps 2
  EXPECT_EQ(reason(world_of({{"#...."}}), options, {2.5, 0.5, 0.5}), NotFree::kLostToGrid);
  EXPECT_EQ(reason(world_of({{"#...."}}), options, {2.1, 0.5, 0.5}), NotFree::kTooClose);
  EXPECT_EQ(reason(world_of({{"#..?."}}), options, {3.5, 0.5, 0.5}), NotFree::kUnknown);

  options.radius = 0;
  options.coarsen = 2;
  const SmallWorld world = world_of({{"....#...", "........"}, {"........", "........"}});
  EXPECT_EQ(reason(world, options, {5.5, 1.5, 1.5}), NotFree::kUnknownOrLeftOut);
  options.unknown = UnknownPolicy::kFree;
  EXPECT_EQ(reason(world, options, {5.5, 1.5, 1.5}), NotFree::kLeftOut);

  options.radius = 2;
  options.coarsen = 1;
  options.bounds = {1, 0, 0, 9, 1, 1};  // the obstacle lies beyond
  EXPECT_EQ(reason(world_of({{"#........"}}), options, {2.5, 0.5, 0.5}), NotFree::kLeftOut);
}

TEST(Obstacles, TellWhyAPointIsNotFree) {
  const SmallWorld world = world_of({{"#...???."}});
  MapBuildOptions options;
  options.radius = 0.5;
  const Built built = build(world, options);
  const auto boxes = *obstacle_boxes(built.view);
  const auto reason = [&](double x) { return why_not_free(built.view, boxes, Vector3(x, 0.5, 0.5)).reason; };
  EXPECT_EQ(reason(-0.1), NotFree::kOutside);
  EXPECT_EQ(reason(8.1), NotFree::kOutside);
  EXPECT_EQ(reason(0.5), NotFree::kOccupied);
  EXPECT_EQ(reason(1.25), NotFree::kTooClose);
  EXPECT_EQ(reason(5.5), NotFree::kUnknown);
  EXPECT_NEAR(why_not_free(built.view, boxes, Vector3(1.25, 0.5, 0.5)).obstacle_distance, 0.25, 1e-12);
}

}  // namespace
}  // namespace swiftlet::tools
