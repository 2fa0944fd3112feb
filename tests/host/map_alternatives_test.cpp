// What would join a map's pieces, and whether it really does.
#include <gtest/gtest.h>

#include <random>

#include "map/alternatives.hpp"
#include "map_test_worlds.hpp"

namespace swiftlet::tools {
namespace {

using test::random_options;
using test::random_world;
using test::SmallWorld;
using test::voxel_map;
using test::world_of;

void ignore(std::string_view /*stage*/, double /*done*/) {}

double built_share(const SmallWorld& world, const MapBuildOptions& options) {
  const auto built = build_map(voxel_map(world), "world", options, ignore);
  EXPECT_TRUE(built.has_value());
  return built->report.largest_component;
}

std::vector<Alternative> alternatives(const SmallWorld& world, const MapBuildOptions& options) {
  return try_alternatives(voxel_map(world), "world", options, ignore);
}

/// The options that an alternative names.
MapBuildOptions changed(MapBuildOptions options, const std::string& option) {
  if (option == "no --coarsen") options.coarsen = 1;
  if (option == "--unknown avoid") options.unknown = UnknownPolicy::kAvoid;
  if (option == "--unknown free") options.unknown = UnknownPolicy::kFree;
  if (option.starts_with("--radius ")) options.radius = std::stod(option.substr(9));
  return options;
}

TEST(Alternatives, EachDoesToTheMapWhatItIsSaidToDo) {
  int tried = 0;
  for (unsigned run = 0; run < 60; ++run) {
    SCOPED_TRACE(run);
    std::mt19937 random(run);
    const SmallWorld world = random_world(random);
    MapBuildOptions options = random_options(random, world.resolution);
    options.coarsen = 1 + static_cast<int>(random() % 2);
    for (const Alternative& other : alternatives(world, options)) {
      EXPECT_NEAR(other.largest_component, built_share(world, changed(options, other.option)), 1e-12) << other.option;
      ++tried;
    }
  }
  EXPECT_GT(tried, 60);
}

TEST(Alternatives, EndWithTheSmallestChangeThatConnects) {
  MapBuildOptions options;
  options.unknown = UnknownPolicy::kOccupied;
  options.radius = 0.5;
  const SmallWorld gap = world_of({{"...??..."}});  // unseen space parts two rooms
  ASSERT_LT(built_share(gap, options), kGoodShare);
  const std::vector<Alternative> found = alternatives(gap, options);
  ASSERT_EQ(found.size(), 2U);  // without inflation of unseen space the rooms are still apart
  EXPECT_EQ(found[0].option, "--unknown avoid");
  EXPECT_LT(found[0].largest_component, kGoodShare);
  EXPECT_EQ(found[1].option, "--unknown free");
  EXPECT_EQ(found[1].largest_component, 1);
}

TEST(Alternatives, AreAllNamedWhenNoneConnects) {
  MapBuildOptions options;
  options.coarsen = 2;
  options.radius = 0.1;
  const std::vector<Alternative> found = alternatives(world_of({{"....#...."}}), options);
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].option, "no --coarsen");
  EXPECT_EQ(found[1].option, "--unknown free");
  EXPECT_EQ(found[2].option, "--radius 0.05");
  for (const Alternative& other : found) EXPECT_LT(other.largest_component, kGoodShare) << other.option;
}

}  // namespace
}  // namespace swiftlet::tools
