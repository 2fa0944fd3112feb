#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "report/flight_report.hpp"
#include "report_test_flight.hpp"
#include "report_test_page.hpp"

namespace {

using Json = nlohmann::ordered_json;
using swiftlet::Vector3;
using swiftlet::tools::EventKind;
using swiftlet::tools::flight_report_html;
using swiftlet::tools::FlightRecord;
using swiftlet::tools::RecordedPlan;
using swiftlet::tools::RecordedSample;
using namespace swiftlet::tools::test;

const Json kFlight{{"format", "swiftlet-flight/1"},
                   {"status", "pilot_took_over"},
                   {"tracking", {{"rms", 0.031}, {"max", 0.16}}},
                   {"flown_clearance", 0.41},
                   {"flown_duration", 23.5}};

Json data_of_flight(const FlightRecord& record) { return data_of(flight_report_html({kFlight, record, "t"})); }

/// The integers of base64 text.
std::vector<int> integers_of(const std::string& base64) {
  static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<int> bytes;
  for (std::size_t i = 0; i + 3 < base64.size(); i += 4) {
    int four = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t digit = digits.find(base64[i + k]);
      four = 64 * four + (digit == std::string::npos ? 0 : static_cast<int>(digit));
    }
    for (int shift = 16; shift >= 0; shift -= 8) bytes.push_back(four >> shift & 255);
  }
  bytes.resize(bytes.size() - static_cast<std::size_t>(std::count(base64.begin(), base64.end(), '=')));
  std::vector<int> integers;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) integers.push_back(bytes[i] + 256 * bytes[i + 1]);
  return integers;
}

/// The values of a packed channel; -1e9 for those that do not exist.
std::vector<double> values_of(const Json& channel) {
  std::vector<double> values;
  for (const int integer : integers_of(channel["values"])) {
    values.push_back(integer == 65535 ? -1e9 : channel["low"].get<double>() + channel["step"].get<double>() * integer);
  }
  return values;
}

TEST(FlightReport, CarriesEverySampleToTheMillisecondAndTheMillimetre) {
  const FlightRecord record = flight_of_eight(80, 50);
  const Json samples = data_of_flight(record)["samples"];
  EXPECT_EQ(samples["count"], record.samples.size());
  EXPECT_EQ(samples["shown"], record.samples.size());
  const std::vector<int> low = integers_of(samples["t"]["low"]);
  const std::vector<int> high = integers_of(samples["t"]["high"]);
  const std::vector<double> x = values_of(samples["x"]);
  const std::vector<double> w = values_of(samples["qw"]);
  ASSERT_EQ(x.size(), record.samples.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_NEAR((65536 * high[i] + low[i]) / 1000.0, record.samples[i].t, 5.1e-4);
    EXPECT_NEAR(x[i], record.samples[i].position.x(), 1e-3);
    EXPECT_NEAR(w[i], record.samples[i].attitude.w(), 1e-4);
  }
}

TEST(FlightReport, MakesErrorsAndRatesOfWhatWasRecorded) {
  FlightRecord record;
  for (int i = 0; i <= 300; ++i) {
    RecordedSample sample;
    sample.t = 0.01 * i;
    sample.state = swiftlet::FlightState::kFlying;
    sample.has_reference = i >= 100;
    sample.reference = Vector3{0.03, 0.04, 0};
    sample.velocity = Vector3{-3, 4, 0};
    sample.setpoints = static_cast<std::uint64_t>(i) / 2;
    record.samples.push_back(sample);
  }
  record.speed_limit_per_axis = false;
  const Json samples = data_of_flight(record)["samples"];
  const std::vector<double> error = values_of(samples["tracking_error"]);
  EXPECT_EQ(error[99], -1e9);
  EXPECT_NEAR(error[100], 0.05, 1e-9);
  EXPECT_NEAR(values_of(samples["speed"])[0], 5, 1e-9);
  const std::vector<double> rate = values_of(samples["setpoint_rate"]);
  EXPECT_EQ(rate[20], -1e9) << "a fifth of a second is too short";
  EXPECT_NEAR(rate[300], 50, 1.1);
  record.speed_limit_per_axis = true;
  EXPECT_NEAR(values_of(data_of_flight(record)["samples"]["speed"])[0], 4, 1e-9);
}

TEST(FlightReport, ShowsTheErrorsOnlyWhereTheyMeanSomething) {
  FlightRecord record = flight_of_eight(30, 10);  // in control from 1 s to 28 s, on its mission from 3 s on
  const auto finite_from_to = [&](const char* name) {
    const std::vector<double> values = values_of(data_of_flight(record)["samples"][name]);
    std::size_t from = 0;
    while (from < values.size() && values[from] == -1e9) ++from;
    std::size_t to = values.size();
    while (to > from && values[to - 1] == -1e9) --to;
    return std::pair{record.samples[from].t, record.samples[to - 1].t};
  };
  EXPECT_EQ(finite_from_to("tracking_error"), std::pair(3.0, 27.9));
  EXPECT_EQ(finite_from_to("reference_z"), std::pair(1.0, 28.0));
  EXPECT_EQ(finite_from_to("estimate_error"), std::pair(1.0, 30.0));
  record.phases.clear();
  EXPECT_EQ(finite_from_to("tracking_error"), std::pair(1.0, 28.0));
}

TEST(FlightReport, KeepsTheWorstErrorAndEveryStateOfALongFlight) {
  FlightRecord record = flight_of_eight(700, 100);
  RecordedSample& worst = record.samples[40'001];
  worst.position.x() += 3;
  worst.state = swiftlet::FlightState::kHolding;
  const Json data = data_of_flight(record);
  EXPECT_EQ(data["samples"]["count"], record.samples.size());
  EXPECT_LE(data["samples"]["shown"], 30'001);
  const std::vector<double> error = values_of(data["samples"]["tracking_error"]);
  EXPECT_GT(*std::max_element(error.begin(), error.end()), 2.8);
  std::string states;
  for (const Json& state : data["states"]) states += state["name"].get<std::string>() + " ";
  EXPECT_EQ(states, "ready holding flying holding flying braking yielded ");
}

TEST(FlightReport, CarriesPlansWithBoxesAndPathAndTheEvents) {
  const FlightRecord record = flight_of_eight(30, 50);
  const Json data = data_of_flight(record);
  ASSERT_EQ(data["plans"]["count"], 2);
  const Json& plan = data["plans"]["shown"][1];
  EXPECT_EQ(plan["number"], 2);
  EXPECT_NEAR(plan["committed"], 14.8, 1e-9);
  EXPECT_NEAR(plan["duration"], 12, 1e-9);
  EXPECT_EQ(plan["boxes"].size(), 6U);
  EXPECT_NEAR(plan["boxes"][0][3], record.plans[1].boxes[0].hi.x(), 5.1e-5);
  const std::vector<double> x = values_of(plan["path"]["x"]);
  EXPECT_EQ(x.size(), 6U * 15 + 1);
  EXPECT_NEAR(x.front(), eight(15).position.x(), 1e-3);
  EXPECT_NEAR(x.back(), eight(27).position.x(), 1e-3);
  EXPECT_EQ(data["events"][3]["kind"], "fault");
  EXPECT_EQ(data["goals"].size(), 2U);
  EXPECT_EQ(data["flight"], kFlight);
}

TEST(FlightReport, LeavesOutThePlansThatWereSoonReplacedWhenThereAreTooMany) {
  FlightRecord record = flight_of_eight(30, 50);
  const RecordedPlan plan = record.plans[0];
  record.plans.assign(5000, plan);
  for (std::size_t i = 0; i < record.plans.size(); ++i) record.plans[i].committed = 0.001 * static_cast<double>(i);
  for (std::size_t i = 2001; i < record.plans.size(); ++i)
    record.plans[i].committed += 5;  // number 2001 is in force long
  const Json plans = data_of_flight(record)["plans"];
  EXPECT_EQ(plans["count"], 5000);
  EXPECT_EQ(plans["shown"].size(), 10'000U / 6);
  EXPECT_EQ(plans["shown"].back()["number"], 5000);
  const auto is_long = [](const Json& shown) { return shown["number"] == 2001; };
  EXPECT_TRUE(std::any_of(plans["shown"].begin(), plans["shown"].end(), is_long));
}

TEST(FlightReport, StaysBelowTenMegabytesWithMoreOfEverythingThanItShows) {
  FlightRecord record = flight_of_eight(1200, 100);
  std::vector<swiftlet::IntBox> scattered;
  for (int i = 0; i < 300'000; ++i) {
    const auto x = static_cast<std::uint16_t>(2 * (i % 1000));
    const auto y = static_cast<std::uint16_t>(2 * (i / 1000));
    scattered.push_back({{x, y, 0}, {static_cast<std::uint16_t>(x + 1), static_cast<std::uint16_t>(y + 1), 1}});
  }
  record.obstacles.boxes = scattered;
  const RecordedPlan plan = record.plans[0];
  record.plans.assign(4000, plan);
  const std::string html = flight_report_html({kFlight, record, "t"});
  EXPECT_LT(html.size(), 10'000'000U);
  EXPECT_EQ(data_of(html)["obstacles"]["shown"], 250'000);
}

TEST(FlightReport, WorksForAFlightThatNeverBegan) {
  const FlightRecord record;
  const Json data = data_of_flight(record);
  EXPECT_EQ(data["samples"]["shown"], 0);
  EXPECT_TRUE(data["tracking_tube"].is_null());
  EXPECT_TRUE(data["plans"]["shown"].empty());
}

TEST(FlightReport, LetsNoTextOfAFlightBecomeMarkup) {
  FlightRecord record = flight_of_eight(30, 10);
  const std::string clean = flight_report_html({kFlight, record, "t"});
  const std::string hostile = "</script><script>alert(1)</script><!--";
  record.events[0].what = record.phases[0].name = hostile;
  const std::string html = flight_report_html({kFlight, record, hostile});
  EXPECT_EQ(occurrences(html, "<script"), occurrences(clean, "<script"));
  EXPECT_EQ(data_of(html)["events"][0]["what"], hostile);
  expect_nothing_from_outside(html);
}

void expect_replay(const std::string& dom) {
  EXPECT_GE(occurrences(dom, "<polyline"), 10U);
  EXPECT_NE(dom.find("aria-valuetext=\"30.0 s, yielded, height"), std::string::npos);
  EXPECT_NE(dom.find("20 % of &lt;all&gt; frames &amp; \"more\" are lost"), std::string::npos);
  EXPECT_NE(dom.find("<dd>3.1<small>cm</small></dd>"), std::string::npos);
  EXPECT_EQ(dom.find("class=\"error\""), std::string::npos);
}

TEST(FlightReportInBrowser, ShowsTimelinePlotsAndNumbersWithoutWebGl) {
  if (!has_browser()) GTEST_SKIP() << "no chromium on this machine";
  const std::string html = flight_report_html({kFlight, flight_of_eight(30, 50), "t"});
  const std::string dom = opened_in_browser(html, kWithoutWebGl);
  expect_replay(dom);
  EXPECT_EQ(dom.find("<canvas"), std::string::npos);
}

TEST(FlightReportInBrowser, ShowsTheReplayWithWebGl) {
  if (!has_browser()) GTEST_SKIP() << "no chromium on this machine";
  const std::string html = flight_report_html({kFlight, flight_of_eight(30, 50), "t"});
  const std::string dom = opened_in_browser(html, kWithWebGl);
  expect_replay(dom);
  EXPECT_EQ(occurrences(dom, "<canvas"), 1U);
  EXPECT_NE(dom.find("data-camera=\"follow\""), std::string::npos);
}

TEST(FlightReportInBrowser, ShowsTheNumbersOfAFlightThatNeverBegan) {
  if (!has_browser()) GTEST_SKIP() << "no chromium on this machine";
  const FlightRecord record;
  const std::string dom = opened_in_browser(flight_report_html({{{"status", "no_path"}}, record, "t"}), kWithWebGl);
  EXPECT_NE(dom.find("no path"), std::string::npos);
  EXPECT_EQ(dom.find("class=\"error\""), std::string::npos);
}

}  // namespace
