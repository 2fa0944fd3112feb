#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "map/audit.hpp"
#include "map/free_space.hpp"
#include "map_test_worlds.hpp"
#include "swiftlet_test.hpp"
#include "unit/test_blob.hpp"

namespace swiftlet::tools {
namespace {

using test::SmallWorld;
using test::TestBlob;

const Progress kSilent = [](std::string_view, double) {};

BuiltMap build(const VoxelMap& map, const MapBuildOptions& options) {
  auto built = build_map(map, "world", options, kSilent);
  EXPECT_TRUE(built.has_value());
  return std::move(*built);
}

bool same_cells(const BitGrid& a, const BitGrid& b) {
  for (std::int32_t z = 0; z < a.size()[2]; ++z) {
    for (std::int32_t y = 0; y < a.size()[1]; ++y) {
      const auto row = a.row(y, z);
      const auto other = b.row(y, z);
      if (!std::equal(row.begin(), row.end(), other.begin(), other.end())) return false;
    }
  }
  return true;
}

std::string first_finding(const AuditReport& report) { return report.findings.empty() ? "none" : report.findings[0]; }

/// Audits a hand-made blob against its world and expects a finding that contains `what`.
void expect_finding(TestBlob& blob, const SmallWorld& world, const std::string& what) {
  const auto view = BoxGraphView::open(blob.bytes());
  ASSERT_TRUE(view.ok());
  const AuditReport report = audit_map(*view, test::voxel_map(world), kSilent);
  bool found = false;
  for (const std::string& finding : report.findings) found = found || finding.find(what) != std::string::npos;
  EXPECT_TRUE(found) << what << "; first of " << report.defects << ": " << first_finding(report);
}

TEST(MapAudit, FindsNothingInWhatTheBuilderMakesOfRandomWorlds) {
  for (int run = 0; run < std::max(20, test::kPropertyRuns / 4); ++run) {
    SCOPED_TRACE(run);
    std::mt19937 random(static_cast<unsigned>(run));
    const SmallWorld world = test::random_world(random);
    MapBuildOptions options = test::random_options(random, world.resolution);
    if (run % 5 == 0) options.coarsen = 2;
    if (run % 3 == 0) options.bounds = {world.resolution, 0, 0, 6 * world.resolution, 99, 99};
    if (run % 3 == 0 && world.size[0] < 2) continue;
    const VoxelMap map = test::voxel_map(world);
    const BuiltMap built = build(map, options);
    const AuditReport report = audit_map(*BoxGraphView::open(built.blob), map, kSilent);
    EXPECT_EQ(report.defects, 0U) << first_finding(report);
  }
}

/// Whether anything but the stored obstacles contradicts the source.
bool geometry_is_wrong(const AuditReport& report) {
  return std::any_of(report.findings.begin(), report.findings.end(), [](const std::string& finding) {
    return finding.find("the stored obstacle") == std::string::npos;
  });
}

TEST(MapAudit, FindsEveryVoxelThatTheSourceHasChanged) {
  int changing = 0;
  int indifferent = 0;
  for (int run = 0; run < std::max(20, test::kPropertyRuns / 20); ++run) {
    SCOPED_TRACE(run);
    std::mt19937 random(static_cast<unsigned>(run));
    const SmallWorld world = test::random_world(random);
    const MapBuildOptions options = test::random_options(random, world.resolution);
    const auto free_space = [&](const SmallWorld& of) {
      return compute_free_space(test::voxel_map(of), "world", options, kSilent)->free;
    };
    const BuiltMap built = build(test::voxel_map(world), options);
    const BitGrid before = free_space(world);
    for (std::size_t i = 0; i < world.voxels.size(); ++i) {
      SmallWorld changed = world;
      if (world.voxels[i] == test::Known::kUnknown) continue;
      const bool occupied = world.voxels[i] == test::Known::kOccupied;
      changed.voxels[i] = occupied ? test::Known::kFree : test::Known::kOccupied;
      const AuditReport report = audit_map(*BoxGraphView::open(built.blob), test::voxel_map(changed), kSilent);
      EXPECT_GT(report.defects, 0U);  // the stored obstacles disagree at least
      const bool changes = !same_cells(before, free_space(changed));
      EXPECT_EQ(geometry_is_wrong(report), changes) << first_finding(report);
      (changes ? changing : indifferent) += 1;
    }
  }
  EXPECT_GT(changing, 100);
  EXPECT_GT(indifferent, 100);
}

TEST(MapAudit, SaysWhatIsWrongInHandMadeBlobs) {
  const SmallWorld open_space = test::world_of({{"....", "...."}});
  const auto blob = [](std::initializer_list<IntBox> cells) { return TestBlob({4, 2, 1}, cells); };
  const IntBox left{{0, 0, 0}, {2, 2, 1}};
  const IntBox right{{2, 0, 0}, {4, 2, 1}};
  TestBlob good = blob({left, right});
  const AuditReport report = audit_map(good.view(), test::voxel_map(open_space), kSilent);
  ASSERT_EQ(report.defects, 0U) << first_finding(report);

  TestBlob overlap = blob({left, IntBox{{1, 0, 0}, {4, 2, 1}}});
  expect_finding(overlap, open_space, "overlaps another");
  TestBlob hole = blob({left, IntBox{{2, 0, 0}, {4, 1, 1}}});
  expect_finding(hole, open_space, "lie in no cell");
  TestBlob no_window = blob({left, right});
  no_window.set_adjacent(0, 1, false);
  no_window.set_adjacent(1, 0, false);
  expect_finding(no_window, open_space, "lists 0 windows, not the 1");
  TestBlob split = blob({IntBox{{0, 0, 0}, {1, 2, 1}}, IntBox{{3, 0, 0}, {4, 2, 1}}});
  split.section<std::uint16_t>(BlobSection::kComponents)[1] = 0;
  split.seal();
  expect_finding(split, test::world_of({{".??.", ".??."}}), "component 0 is not connected");
  expect_finding(split, test::world_of({{".??.", ".??."}}), "label has no cell");

  TestBlob marked = blob({left, IntBox{{2, 0, 0}, {3, 2, 1}}, IntBox{{3, 0, 0}, {4, 2, 1}}});
  marked.set_landmarks(2);
  ASSERT_EQ(audit_map(marked.view(), test::voxel_map(open_space), kSilent).defects, 0U);
  marked.set_every_second_distance(257);  // one unit and a 256th, where it is one
  expect_finding(marked, open_space, "units from landmark 0, the map says");
  marked.set_every_second_distance(0);
  expect_finding(marked, open_space, "landmark 0 lies at 2 windows, not at one");

  const SmallWorld obstacle = test::world_of({{"...#", "...."}});
  expect_finding(good, obstacle, "lies in an obstacle");
  expect_finding(good, obstacle, "less than the radius");
  expect_finding(good, obstacle, "not all of the source's");
  expect_finding(good, test::world_of({{"...?", "...."}}), "lies in unknown space");
  TestBlob part = blob({left});
  part.set_extent(0, {{0, 0, 0}, {3, 2, 1}});
  expect_finding(part, open_space, "leaves the free space");
  expect_finding(good, test::world_of({{"....", "...."}}, 0.5), "resolution");
  expect_finding(good, test::world_of({{"..", ".."}}), "does not lie on the voxels");
}

TEST(MapAudit, NoticesAnotherSourceFile) {
  const SmallWorld world = test::world_of({{"...."}});
  VoxelMap map = test::voxel_map(world);
  const BuiltMap built = build(map, {});
  map.source_digest[3] = 1;
  const AuditReport report = audit_map(*BoxGraphView::open(built.blob), map, kSilent);
  ASSERT_EQ(report.defects, 1U);
  EXPECT_NE(report.findings[0].find("another file"), std::string::npos);
}

TEST(MapAudit, PassesTheRealScansAtTheRadiusOfTheirQueries) {
  const std::string maps = std::string(SWIFTLET_SOURCE_DIR) + "/../shared/maps/";
  const auto map = read_octree(maps + "geb079/geb079.bt");
  if (!map) GTEST_SKIP() << map.error().message;
  MapBuildOptions options;
  options.radius = 0.3;
  const BuiltMap built = build(*map, options);
  const std::size_t graph_bytes = built.report.blob_bytes - built.report.landmark_bytes -
                                  built.report.section_bytes[static_cast<std::size_t>(BlobSection::kObstacles)];
  EXPECT_GT(built.report.landmarks, 0U);
  EXPECT_LE(static_cast<double>(built.report.landmark_bytes), 0.6 * static_cast<double>(graph_bytes));
  const AuditReport report = audit_map(*BoxGraphView::open(built.blob), *map, kSilent);
  EXPECT_EQ(report.defects, 0U) << first_finding(report);
}

TEST(MapAudit, EverySingleFlippedBitOfARealMapIsRefused) {
  const std::string maps = std::string(SWIFTLET_SOURCE_DIR) + "/../shared/maps/";
  const auto map = read_octree(maps + "geb079/geb079.bt");
  if (!map) GTEST_SKIP() << map.error().message;
  MapBuildOptions options;
  options.radius = 0.3;
  BuiltMap built = build(*map, options);
  std::mt19937 random(1);
  for (int flip = 0; flip < 5 * test::kPropertyRuns; ++flip) {  // 10,000 in host-release
    const std::size_t bit = std::uniform_int_distribution<std::size_t>(0, 8 * built.blob.size() - 1)(random);
    std::byte& byte = built.blob[bit / 8];
    const auto mask = static_cast<std::byte>(1U << (bit % 8));
    byte ^= mask;
    ASSERT_FALSE(BoxGraphView::open(built.blob).ok()) << "bit " << bit;
    byte ^= mask;
  }
  EXPECT_TRUE(BoxGraphView::open(built.blob).ok());
}

}  // namespace
}  // namespace swiftlet::tools
