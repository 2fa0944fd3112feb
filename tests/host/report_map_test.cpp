#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "map/map_builder.hpp"
#include "map/map_report.hpp"
#include "map/voxel_map.hpp"
#include "report/map_report_page.hpp"
#include "report_test_page.hpp"
#include "unit/test_blob.hpp"

namespace {

using Json = nlohmann::ordered_json;
using swiftlet::BoxGraphView;
using swiftlet::IntBox;
using swiftlet::test::TestBlob;
using swiftlet::tools::map_info;
using swiftlet::tools::map_report_html;
using swiftlet::tools::map_report_json;
using namespace swiftlet::tools::test;

const std::vector<IntBox> kWalls{{{0, 0, 0}, {8, 8, 1}}};

/// Two cells that share a window of 2 x 4, and a third apart from them.
TestBlob three_cells() {
  TestBlob blob({16, 8, 8}, {{{0, 0, 1}, {4, 4, 5}}, {{4, 2, 1}, {6, 4, 5}}, {{10, 0, 1}, {12, 2, 3}}});
  blob.set_extent(1, {{0, 2, 1}, {6, 4, 5}});
  return blob;
}

std::string page_of(const BoxGraphView& graph, const std::string& note = "", const std::string& title = "small") {
  return map_report_html({map_report_json(map_info(graph)), graph, kWalls, note, title});
}

TEST(MapReportPage, CarriesTheReportUnchanged) {
  TestBlob blob = three_cells();
  const Json data = data_of(page_of(blob.view(), "look here"));
  EXPECT_EQ(data["kind"], "map");
  EXPECT_EQ(data["title"], "small");
  EXPECT_EQ(data["note"], "look here");
  EXPECT_EQ(data["map"], map_report_json(map_info(blob.view())));
}

TEST(MapReportPage, CarriesCellsExtentsComponentsAndWindowsAsLittleEndianBase64) {
  TestBlob blob({16, 8, 8}, {{{0, 0, 1}, {4, 4, 5}}, {{4, 2, 1}, {6, 4, 5}}});
  blob.set_extent(1, {{0, 2, 1}, {6, 4, 5}});
  const Json data = data_of(page_of(blob.view()));
  EXPECT_EQ(data["cells"]["boxes"], "AAAAAAEABAAEAAUABAACAAEABgAEAAUA");
  EXPECT_EQ(data["cells"]["extents"], "AAAAAAEABAAEAAUAAAACAAEABgAEAAUA");
  EXPECT_EQ(data["cells"]["components"], "AAAAAA==");
  EXPECT_EQ(data["windows"]["boxes"], "BAACAAEABAAEAAUA");  // x 4 to 4, y 2 to 4, z 1 to 5
  EXPECT_EQ(data["windows"]["count"], 1);
  EXPECT_EQ(data["obstacles"]["boxes"], "AAAAAAAACAAIAAEA");
}

TEST(MapReportPage, ListsComponentsByVolume) {
  TestBlob blob({16, 8, 8}, {{{0, 0, 0}, {1, 1, 1}}, {{4, 4, 0}, {8, 8, 4}}});
  const Json components = data_of(page_of(blob.view()))["components"];
  ASSERT_EQ(components.size(), 2U);
  EXPECT_EQ(components[0]["label"], 1);
  EXPECT_EQ(components[0]["cells"], 1);
  EXPECT_EQ(components[0]["free_m3"], 64.0);
  EXPECT_EQ(components[0]["share"], 64.0 / 65.0);
}

TEST(MapReportPage, WorksWithoutACell) {
  TestBlob blob({16, 8, 8}, {});
  const Json data = data_of(page_of(blob.view()));
  EXPECT_EQ(data["cells"]["count"], 0);
  EXPECT_EQ(data["cells"]["shown_share"], 0);
  EXPECT_TRUE(data["components"].empty());
}

TEST(MapReportPage, LetsNoTextOfATitleANoteOrASourceBecomeMarkup) {
  TestBlob blob = three_cells();
  const std::string hostile = "</script><script>alert(1)</script><!--";
  Json map = map_report_json(map_info(blob.view()));
  map["source"] = hostile;
  const std::string clean = page_of(blob.view());
  const std::string html = map_report_html({map, blob.view(), kWalls, hostile, hostile});
  EXPECT_EQ(occurrences(html, "<script"), occurrences(clean, "<script"));
  EXPECT_EQ(occurrences(html, "</script"), occurrences(clean, "</script"));
  EXPECT_EQ(data_of(html)["note"], hostile);
}

TEST(MapReportPage, AsksForNothingOutsideItself) {
  TestBlob blob = three_cells();
  expect_nothing_from_outside(page_of(blob.view()));
}

TEST(MapReportPage, StaysBelowTenMegabytesAndShowsTheLargestOfMoreCellsThanItHolds) {
  swiftlet::tools::VoxelMap world;  // cubes of eight voxels, one of them occupied, so that the others stay single
  world.resolution = 0.5;
  world.size = {80, 52, 52};
  for (std::uint16_t x = 0; x < 52; ++x) {
    for (std::uint16_t y = 0; y < 52; ++y) {
      for (std::uint16_t z = 0; z < 52; ++z) world.leaves.push_back({{x, y, z}, 0, (x & y & z & 1) == 1});
    }
  }
  world.leaves.push_back({{64, 0, 0}, 4, false});
  constexpr int kSingle = 26 * 26 * 26 * 7;
  swiftlet::tools::MapBuildOptions options;
  options.partition = swiftlet::tools::Partition::kOctree;
  options.landmarks = 0;  // most of the time of the build, and the page shows none
  const auto built = build_map(world, "world", options, [](std::string_view, double) {});
  ASSERT_TRUE(built.has_value());
  std::vector<IntBox> obstacles;  // more than a map could hold beside these cells: the worst case in bytes
  for (std::uint32_t i = 0; i < 250'000; ++i) {
    const auto at = static_cast<std::uint16_t>(i % 60'000);
    obstacles.push_back({{at, at, at}, {60'000, 60'000, 60'000}});
  }
  const BoxGraphView graph = *BoxGraphView::open(built->blob);
  const std::string html = map_report_html({map_report_json(built->report), graph, obstacles, "", "t"});
  EXPECT_LT(html.size(), 10'000'000U);
  const Json data = data_of(html);
  EXPECT_EQ(data["cells"]["count"], kSingle + 1);
  EXPECT_EQ(data["cells"]["shown"], 100'000);
  EXPECT_EQ(data["cells"]["shown_share"], (4096.0 + 99'999) / (4096 + kSingle));
  EXPECT_EQ(data["cells"]["boxes"].get<std::string>().substr(0, 16), "QAAAAAAAUAAQABAA");  // the largest comes first
  EXPECT_EQ(data["windows"]["count"], built->report.windows);
  EXPECT_EQ(data["windows"]["shown"], 100'000);
  EXPECT_EQ(data["obstacles"]["shown"], 200'000);
}

void expect_numbers_and_section(const std::string& dom) {
  EXPECT_NE(dom.find("<dd>88<small>m³</small></dd>"), std::string::npos) << "free volume";
  EXPECT_NE(dom.find("<dd>90.9 %</dd>"), std::string::npos) << "largest component";
  EXPECT_NE(dom.find("connected</span>"), std::string::npos);
  EXPECT_NE(dom.find("record offsets"), std::string::npos) << "bytes by section";
  EXPECT_EQ(occurrences(between(dom, "class=\"section card\"", "</section>"), "<canvas"), 1U);
  EXPECT_EQ(dom.find("class=\"error\""), std::string::npos);
}

TEST(MapReportPageInBrowser, ShowsSectionAndNumbersWithoutWebGl) {
  if (!has_browser()) GTEST_SKIP() << "no chromium on this machine";
  TestBlob blob = three_cells();
  const std::string dom = opened_in_browser(page_of(blob.view()), kWithoutWebGl);
  expect_numbers_and_section(dom);
  EXPECT_NE(dom.find("class=\"view missing\""), std::string::npos);
  EXPECT_EQ(occurrences(dom, "<canvas"), 1U);
}

TEST(MapReportPageInBrowser, ShowsTheViewWithWebGl) {
  if (!has_browser()) GTEST_SKIP() << "no chromium on this machine";
  TestBlob blob = three_cells();
  const std::string dom = opened_in_browser(page_of(blob.view()), kWithWebGl);
  expect_numbers_and_section(dom);
  EXPECT_EQ(occurrences(dom, "<canvas"), 2U);
  for (const char* layer : {"obstacles", "cells", "windows", "rulers"}) {
    EXPECT_NE(dom.find("<input type=\"checkbox\" name=\"" + std::string(layer)), std::string::npos) << layer;
  }
}

TEST(MapReportPageInBrowser, SaysWhenTheFreeSpaceIsInPieces) {
  if (!has_browser()) GTEST_SKIP() << "no chromium on this machine";
  TestBlob blob({16, 8, 8}, {{{0, 0, 0}, {2, 2, 2}}, {{4, 4, 0}, {6, 6, 2}}});
  const std::string dom = opened_in_browser(page_of(blob.view(), "a <b>policy</b> would connect it"), kWithoutWebGl);
  EXPECT_NE(dom.find("in pieces</span>"), std::string::npos);
  EXPECT_NE(dom.find("a &lt;b&gt;policy&lt;/b&gt; would connect it"), std::string::npos);
}

TEST(MapReportPageInBrowser, OpensWithoutACell) {
  if (!has_browser()) GTEST_SKIP() << "no chromium on this machine";
  TestBlob blob({16, 8, 8}, {});
  const std::string dom = opened_in_browser(page_of(blob.view()), kWithWebGl);
  EXPECT_NE(dom.find("nothing free</span>"), std::string::npos);
  EXPECT_EQ(dom.find("class=\"error\""), std::string::npos);
}

}  // namespace
