// Dropping thin cells: what stays connected, what is lost, and how long the ways become.
#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <random>
#include <set>

#include "map/audit.hpp"
#include "map/box_graph.hpp"
#include "map/slivers.hpp"
#include "map_test_worlds.hpp"
#include "swiftlet/box_graph_view.hpp"

namespace swiftlet::tools {
namespace {

using test::random_options;
using test::random_world;
using test::SmallWorld;
using test::voxel_map;
using test::world_of;

void ignore(std::string_view /*stage*/, double /*done*/) {}

BuiltMap build(const SmallWorld& world, const MapBuildOptions& options) {
  auto built = build_map(voxel_map(world), "world", options, ignore);
  EXPECT_TRUE(built.has_value());
  return std::move(*built);
}

/// Two rooms joined by two passages of one voxel each, 1 m a voxel, two voxels high.
SmallWorld two_passages() {
  const std::vector<std::string> layer{"....###....",  //
                                       "...........",  //
                                       "....###....",  //
                                       "....###....",  //
                                       "...........",  //
                                       "....###...."};
  return world_of({layer, layer});
}

TEST(Slivers, KeepAWayWhoseDetourIsTooLongAndTheLastWayInAnyCase) {
  MapBuildOptions options;
  const double whole = build(two_passages(), options).report.free_volume;
  options.sliver_tolerance = 2;  // from passage to passage it is 3 m
  EXPECT_EQ(build(two_passages(), options).report.lost_to_slivers, 0);
  options.sliver_tolerance = 50;
  const MapReport report = build(two_passages(), options).report;
  EXPECT_EQ(report.lost_to_slivers, 6);  // one passage of 3 x 1 x 2
  EXPECT_EQ(report.free_volume, whole - 6);
  EXPECT_EQ(report.components, 1U);
}

TEST(Slivers, DropDeadEndsButNoCellThatStandsAlone) {
  std::vector<GridBox> cells{{{0, 0, 0}, {4, 4, 4}}, {{4, 0, 0}, {5, 4, 4}}, {{9, 0, 0}, {10, 4, 4}}};
  EXPECT_EQ(drop_slivers(cells, 1, 0, [](double) {}), 16U);
  ASSERT_EQ(cells.size(), 2U);
  EXPECT_EQ(cells[1].lo[0], 9);
}

TEST(Slivers, LoseNoConnectionOfAnyWorldAndWhatTheAuditFinds) {
  int dropping = 0;
  for (unsigned run = 0; run < 80; ++run) {
    SCOPED_TRACE(run);
    std::mt19937 random(run);
    const SmallWorld world = random_world(random);
    MapBuildOptions options = random_options(random, world.resolution);
    const BuiltMap before = build(world, options);
    options.sliver_tolerance = static_cast<double>(random() % 4) * world.resolution;
    const BuiltMap after = build(world, options);
    const BoxGraphView view = *BoxGraphView::open(after.blob);
    const AuditReport audit = audit_map(view, voxel_map(world), ignore);
    EXPECT_EQ(audit.defects, 0U) << (audit.findings.empty() ? "" : audit.findings[0]);
    EXPECT_NEAR(after.report.free_volume + after.report.lost_to_slivers, before.report.free_volume, 1e-9);
    EXPECT_EQ(after.report.components, before.report.components);

    // Two cells that are left are connected exactly when they were before.
    const BoxGraphView old_view = *BoxGraphView::open(before.blob);
    std::map<std::uint16_t, std::uint16_t> old_label;
    std::set<std::uint16_t> seen;
    for (std::size_t i = 0; i < view.cell_count(); ++i) {
      const auto cell = static_cast<CellIndex>(i);
      const Box box = view.to_world(view.cell(cell));
      const auto old_cell = old_view.locate((box.lo + box.hi) / 2);
      ASSERT_TRUE(old_cell.has_value());
      EXPECT_EQ(old_label.try_emplace(view.component(cell), old_view.component(*old_cell)).first->second,
                old_view.component(*old_cell));
      seen.insert(old_view.component(*old_cell));
    }
    EXPECT_EQ(seen.size(), old_label.size());
    dropping += after.report.lost_to_slivers > 0 ? 1 : 0;
  }
  EXPECT_GT(dropping, 10);
}

TEST(Slivers, AreFoundByTheAuditWhenMoreIsMissingThanTheMapSays) {
  MapBuildOptions options;
  options.sliver_tolerance = 50;
  const BuiltMap built = build(two_passages(), options);
  std::vector<std::byte> blob = built.blob;
  BlobHeader header{};
  std::memcpy(&header, blob.data(), sizeof(header));
  header.lost_to_slivers -= 1;
  header.crc32 = 0;
  std::memcpy(blob.data(), &header, sizeof(header));
  header.crc32 = blob_crc32(blob);
  std::memcpy(blob.data(), &header, sizeof(header));
  const AuditReport audit = audit_map(*BoxGraphView::open(blob), voxel_map(two_passages()), ignore);
  ASSERT_EQ(audit.defects, 1U);
  EXPECT_NE(audit.findings[0].find("lie in no cell"), std::string::npos);
}

TEST(Slivers, ComeOutTheSameEveryTime) {
  std::mt19937 random(3);
  const SmallWorld world = random_world(random);
  MapBuildOptions options;
  options.sliver_tolerance = 0.5;
  EXPECT_EQ(build(world, options).blob, build(world, options).blob);
}

}  // namespace
}  // namespace swiftlet::tools
