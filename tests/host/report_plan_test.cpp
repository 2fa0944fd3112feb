#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "report/plan_report.hpp"
#include "report_test_page.hpp"

namespace {

using Json = nlohmann::ordered_json;
using swiftlet::IntBox;
using swiftlet::tools::GridBoxes;
using swiftlet::tools::plan_report_html;
using namespace swiftlet::tools::test;

Json small_plan() {
  std::ifstream file(SWIFTLET_SOURCE_DIR "/tests/data/plan_small.json");
  return Json::parse(file);
}

const std::vector<IntBox> kWalls{{{0, 0, 0}, {8, 8, 1}}, {{0, 0, 1}, {1, 8, 8}}, {{256, 300, 1}, {257, 301, 8}}};

GridBoxes walls() { return {{-1, -1, 0}, 0.125, 0.25, kWalls}; }

TEST(PlanReport, CarriesThePlanUnchanged) {
  const Json plan = small_plan();
  const Json data = data_of(plan_report_html({plan, walls(), "small"}));
  EXPECT_EQ(data["kind"], "plan");
  EXPECT_EQ(data["title"], "small");
  EXPECT_EQ(data["plan"], plan);
}

TEST(PlanReport, CarriesObstaclesAsLittleEndianBase64) {
  const std::vector<IntBox> one{{{1, 2, 3}, {258, 5, 65535}}};
  const Json plan = small_plan();
  const Json data = data_of(plan_report_html({plan, {{-1, -2, 0.5}, 0.25, 0.5, one}, ""}));
  EXPECT_EQ(data["obstacles"]["boxes"], "AQACAAMAAgEFAP//");  // 01 00 02 00 03 00 02 01 05 00 ff ff
  EXPECT_EQ(data["obstacles"]["origin"], Json({-1, -2, 0.5}));
  EXPECT_EQ(data["obstacles"]["unit"], 0.25);
  EXPECT_EQ(data["obstacles"]["voxel"], 0.5);
  EXPECT_EQ(data["obstacles"]["count"], 1);
}

TEST(PlanReport, WorksWithoutObstaclesAndWithoutATrajectory) {
  const Json plan{{"format", "swiftlet-plan/1"}, {"status", "no_path"}};
  const Json data = data_of(plan_report_html({plan, {}, "none"}));
  EXPECT_TRUE(data["obstacles"].is_null());
  EXPECT_EQ(data["plan"], plan);
}

TEST(PlanReport, LetsNoTextOfATitleOrAPlanBecomeMarkup) {
  Json plan = small_plan();
  const std::string hostile = "</script><script>alert(1)</script><!--";
  plan["map"]["path"] = hostile;
  const std::string clean = plan_report_html({small_plan(), walls(), "t"});
  const std::string html = plan_report_html({plan, walls(), hostile});
  EXPECT_EQ(occurrences(html, "<script"), occurrences(clean, "<script"));
  EXPECT_EQ(occurrences(html, "</script"), occurrences(clean, "</script"));
  EXPECT_EQ(data_of(html)["plan"]["map"]["path"], hostile);
}

TEST(PlanReport, ReplacesBytesThatAreNotUtf8) {
  Json plan = small_plan();
  plan["map"]["path"] = "bad\xff.swm";
  EXPECT_EQ(data_of(plan_report_html({plan, walls(), "t"}))["plan"]["map"]["path"], "bad\xEF\xBF\xBD.swm");
}

TEST(PlanReport, AsksForNothingOutsideItselfAndShowsTheLicenceOfThreeJs) {
  const std::string html = plan_report_html({small_plan(), walls(), "t"});
  expect_nothing_from_outside(html);
  EXPECT_NE(html.find("The MIT License"), std::string::npos);
  EXPECT_NE(html.find("three.js authors"), std::string::npos);
}

TEST(PlanReport, StaysBelowTenMegabytesWithMoreBoxesThanItShows) {
  std::vector<IntBox> scattered;  // no two of them touch
  for (std::uint16_t z = 0; z < 160; z += 2) {
    for (std::uint16_t y = 0; y < 160; y += 2) {
      for (std::uint16_t x = 0; x < 160; x += 2) {
        scattered.push_back({{x, y, z}, {std::uint16_t(x + 1), std::uint16_t(y + 1), std::uint16_t(z + 1)}});
      }
    }
  }
  scattered.push_back({{500, 500, 500}, {510, 510, 510}});
  const std::string html = plan_report_html({small_plan(), {{0, 0, 0}, 0.05, 0.05, scattered}, "t"});
  EXPECT_LT(html.size(), 10'000'000U);
  const Json data = data_of(html);
  EXPECT_EQ(data["obstacles"]["count"], scattered.size());
  EXPECT_EQ(data["obstacles"]["shown"], 400'000);
  EXPECT_EQ(data["obstacles"]["boxes"].get<std::string>().substr(0, 16),
            "9AH0AfQB/gH+Af4B");  // the largest comes first
}

void expect_plots_and_numbers(const std::string& dom) {
  EXPECT_EQ(occurrences(dom, "<polyline"), 12U);
  EXPECT_NE(dom.find("<dd>2.00<small>m</small></dd>"), std::string::npos) << "length";
  EXPECT_NE(dom.find("<dd>4.00<small>s</small></dd>"), std::string::npos) << "duration";
  EXPECT_NE(dom.find("&lt;small&gt; &amp; \"quoted\".swm"), std::string::npos) << "map file";
  EXPECT_EQ(dom.find("class=\"error\""), std::string::npos);
}

TEST(PlanReportInBrowser, ShowsPlotsAndNumbersWithoutWebGl) {
  if (!has_browser()) GTEST_SKIP() << "no chromium on this machine";
  const std::string html = plan_report_html({small_plan(), walls(), "t"});
  const std::string dom = opened_in_browser(html, kWithoutWebGl);
  expect_plots_and_numbers(dom);
  EXPECT_NE(dom.find("class=\"view missing\""), std::string::npos);
  EXPECT_EQ(dom.find("<canvas"), std::string::npos);
}

TEST(PlanReportInBrowser, ShowsTheViewWithWebGl) {
  if (!has_browser()) GTEST_SKIP() << "no chromium on this machine";
  const std::string html = plan_report_html({small_plan(), walls(), "t"});
  const std::string dom = opened_in_browser(html, kWithWebGl);
  expect_plots_and_numbers(dom);
  EXPECT_EQ(occurrences(dom, "<canvas"), 1U);
  EXPECT_NE(dom.find("data-direction=\"top\""), std::string::npos);
}

TEST(PlanReportInBrowser, ShowsWhyThereIsNoTrajectory) {
  if (!has_browser()) GTEST_SKIP() << "no chromium on this machine";
  Json plan = small_plan();
  for (const char* key : {"corridor", "gates", "segments", "duration", "length", "jerk_cost", "qp", "certificate"})
    plan.erase(key);
  plan["request"]["start"]["position"] = {1e9, 0, 0};
  plan["status"] = "no_path";
  plan["reason"] = "start lies in component 0, goal in component 3";
  const std::string dom = opened_in_browser(plan_report_html({plan, walls(), "t"}), kWithWebGl);
  EXPECT_NE(dom.find("start lies in component 0, goal in component 3"), std::string::npos);
  EXPECT_EQ(occurrences(dom, "<polyline"), 0U);
  EXPECT_EQ(occurrences(dom, "<canvas"), 1U);
  EXPECT_NE(dom.find("max=\"1\" step="), std::string::npos) << "an end far outside stretches the heights";
  EXPECT_EQ(dom.find("class=\"error\""), std::string::npos);
}

}  // namespace
