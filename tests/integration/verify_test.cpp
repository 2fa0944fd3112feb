// `swiftlet verify`: plans that hold, and one test for each way in which a stored plan can be wrong.
#include <algorithm>
#include <functional>
#include <string>

#include "program.hpp"
#include "two_rooms.hpp"

namespace swiftlet::tools {
namespace {

class Verify : public FolderTest {
 protected:
  void SetUp() override {
    write_two_rooms(path("rooms.bt"));
    ASSERT_EQ(swiftlet({"map", "build", path("rooms.bt"), "-o", path("rooms.swm"), "--radius", "0.15"}).status, 0);
    write_text(path("vehicle.json"), R"({"format": "swiftlet-vehicle/1", "mass_kg": 1.5, "thrust_min_n": 3,
                                        "thrust_max_n": 25, "rate_max_rad_s": 2})");
    good_ = planned({});
  }
  Json planned(const std::vector<std::string>& extra) {
    std::vector<std::string> arguments{"plan", path("rooms.swm"), "--start", kLeft,    "--vmax",
                                       "1",    "--amax",          "2",       "--json", path("plan.json")};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    if (std::find(extra.begin(), extra.end(), "--goal") == extra.end()) {
      arguments.insert(arguments.end(), {"--goal", kLeftToo});
    }
    (void)swiftlet(arguments);
    return Json::parse(read_text(path("plan.json")));
  }
  Outcome verify(const std::string& text) {
    write_text(path("plan.json"), text);
    return swiftlet({"verify", path("plan.json"), path("rooms.swm")});
  }
  /// Verification of the good plan with one change finds a defect and says so in these words.
  testing::AssertionResult finds(const std::function<void(Json&)>& change, const std::vector<std::string>& words) {
    Json plan = good_;
    change(plan);
    const Outcome run = verify(plan.dump());
    if (run.status != 1) return testing::AssertionFailure() << "status " << run.status << ": " << run.err;
    for (const std::string& word : words) {
      if (run.err.find(word) == std::string::npos) {
        return testing::AssertionFailure() << "'" << word << "' is missing in: " << run.err;
      }
    }
    return testing::AssertionSuccess();
  }
  static void add(Json& number, double difference) { number = number.get<double>() + difference; }

  Json good_;
};

TEST_F(Verify, EveryPlanOfThePlannerHolds) {
  for (const std::vector<std::string>& extra :
       std::vector<std::vector<std::string>>{{},
                                             {"--corridor", "cells"},
                                             {"--corridor", "cells", "--relax", "off"},
                                             {"--norm", "euclidean"},
                                             {"--start-velocity", "0.4,0.2,0"},
                                             {"--jmax", "3"},
                                             {"--jmax", "3", "--norm", "euclidean"},
                                             {"--vehicle", path("vehicle.json")},
                                             {"--refine-us", "0"},
                                             {"--deadline-us", "0"},
                                             {"--goal", kNearPillar, "--snap", "0.5"},
                                             {"--goal", kLeft}}) {
    const Json plan = planned(extra);
    ASSERT_TRUE(plan.contains("segments")) << plan.dump();
    const Outcome run = verify(plan.dump());
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_NE(run.err.find("free boxes"), std::string::npos);
    EXPECT_EQ(run.out, "");
  }
}

TEST_F(Verify, ABoxThatReachesIntoSpaceOfNoCellHoldsWhereACellsExtentDoes) {
  ASSERT_EQ(swiftlet({"world", "classroom", "--seed", "1", "-o", path("w.bt"), "--query", path("w.csv")}).status, 0);
  ASSERT_EQ(swiftlet({"map", "build", path("w.bt"), "-o", path("rooms.swm"), "--radius", "0.15", "--drop-slivers", "1"})
                .status,
            0);
  ASSERT_EQ(swiftlet({"plan", path("rooms.swm"), "--queries", path("w.csv"), "--vmax", "1", "--amax", "1", "--jsonl",
                      path("w.jsonl")})
                .status,
            0);
  std::vector<Json> plans = read_lines(path("w.jsonl"));
  plans.resize(20);
  for (const Json& plan : plans) {
    ASSERT_TRUE(plan.contains("segments")) << plan.dump();
    const Outcome run = verify(plan.dump());
    EXPECT_EQ(run.status, 0) << run.err;
  }
}

TEST_F(Verify, AChangedCoefficientBreaksContinuityOrTheEndsOrTheLimits) {
  EXPECT_TRUE(finds([](Json& p) { add(p["segments"][0]["x"][0], 1e-3); }, {"position", "at the start"}));
  EXPECT_TRUE(finds([](Json& p) { add(p["segments"][0]["y"][1], 1e-3); }, {"velocity", "at the start"}));
  EXPECT_TRUE(finds([](Json& p) { add(p["segments"].back()["z"][5], 1e-3); }, {"at the goal"}));
  EXPECT_TRUE(finds([](Json& p) { add(p["segments"][0]["x"][3], 10); }, {"segment 0: acceleration", "limit 2 m/s^2"}));
  ASSERT_GE(good_["segments"].size(), 2U);
  EXPECT_TRUE(finds([](Json& p) { add(p["segments"][1]["x"][0], 1e-3); }, {"between segments 0 and 1"}));
  EXPECT_TRUE(finds([](Json& p) { add(p["segments"][0]["z"][2], 100); }, {"segment 0: it leaves its box"}));
}

TEST_F(Verify, JerkThrustAndBodyRatesAreHeldAgainstTheRequest) {
  good_ = planned({"--jmax", "3", "--vehicle", path("vehicle.json")});
  ASSERT_TRUE(good_["certificate"]["max_rate"].is_number());
  EXPECT_TRUE(finds([](Json& p) { p["request"]["jmax"] = 0.5; }, {"jerk", "limit 0.5 m/s^3"}));
  EXPECT_TRUE(finds([](Json& p) { p["request"]["vehicle"]["thrust_max_n"] = 14.72; }, {"thrust", "limit 14.72 N"}));
  EXPECT_TRUE(
      finds([](Json& p) { p["request"]["vehicle"]["rate_max_rad_s"] = 0.01; }, {"body rate", "limit 0.01 rad/s"}));
  for (const char* claim : {"max_jerk_norm", "min_thrust", "max_thrust", "max_rate"}) {
    EXPECT_TRUE(finds([&](Json& p) { add(p["certificate"][claim], 0.1); }, {claim})) << claim;
  }
  EXPECT_TRUE(finds([](Json& p) { add(p["certificate"]["max_jerk"][1], 0.1); }, {"max_jerk[1]"}));
}

TEST_F(Verify, AChangedDurationIsFound) {
  EXPECT_TRUE(finds([](Json& p) { add(p["segments"][0]["duration"], 0.1); }, {"between segments 0 and 1"}));
  EXPECT_TRUE(finds([](Json& p) { p["segments"][0]["duration"] = 0; }, {"segment 0", "not positive"}));
  EXPECT_TRUE(finds([](Json& p) { add(p["duration"], 1e-6); }, {"'duration'"}));
}

TEST_F(Verify, ABoxThatIsNotFreeOrNotOnTheGridIsFound) {
  EXPECT_TRUE(finds([](Json& p) { add(p["corridor"][0][3], 1e-9); }, {"box 0: its faces are none of the map's"}));
  EXPECT_TRUE(finds([](Json& p) { p["corridor"][0][0] = -50; }, {"box 0: its faces are none of the map's"}));
  EXPECT_TRUE(finds([](Json& p) { p["corridor"][0][3] = p["corridor"][0][0]; }, {"box 0: it has no volume"}));
  // The whole map as one box: faces on the grid, but full of obstacles.
  const Json info = Json::parse(swiftlet({"map", "info", path("rooms.swm"), "--json", "-"}).out);
  EXPECT_TRUE(finds([&](Json& p) { p["corridor"][0] = info["bounds"]; }, {"box 0:", "m^3 of it are not free"}));
}

TEST_F(Verify, AGateThatIsNotTheIntersectionOfItsBoxesIsFound) {
  ASSERT_GE(good_["gates"].size(), 1U);
  EXPECT_TRUE(finds([](Json& p) { add(p["gates"][0][0], 1e-9); }, {"gate 0: it is not the intersection"}));
  EXPECT_TRUE(finds([](Json& p) { p["gates"][0] = {7, 7, 7, 8, 8, 8}; }, {"segment 0: it ends", "outside its gate"}));
  EXPECT_TRUE(finds([](Json& p) { p["gates"].erase(0); }, {"gates"}));
  EXPECT_TRUE(finds([](Json& p) { p["corridor"].erase(0); }, {"boxes"}));
}

TEST_F(Verify, ATrajectoryBeyondTheRequestIsFound) {
  EXPECT_TRUE(finds([](Json& p) { p["request"]["vmax"] = 0.1; }, {"speed", "limit 0.1 m/s"}));
  EXPECT_TRUE(finds([](Json& p) { p["request"]["amax"] = 0.1; }, {"acceleration", "limit 0.1 m/s^2"}));
  EXPECT_TRUE(finds([](Json& p) { p["request"]["amax"] = -1; }, {"limit -1"}));
  EXPECT_TRUE(finds([](Json& p) { add(p["request"]["goal"]["position"][2], 0.01); }, {"position", "at the goal"}));
  EXPECT_TRUE(finds([](Json& p) { add(p["request"]["start"]["velocity"][0], 0.01); }, {"velocity", "at the start"}));
}

TEST_F(Verify, AnythingThatThePlanSaysOfItselfAndIsNotSoIsFound) {
  EXPECT_TRUE(finds([](Json& p) { add(p["length"], 0.01); }, {"'length'"}));
  EXPECT_TRUE(finds([](Json& p) { add(p["jerk_cost"][1], 0.01); }, {"'jerk_cost[1]'"}));
  EXPECT_TRUE(finds([](Json& p) { add(p["certificate"]["box_margin"], 0.01); }, {"'certificate.box_margin'"}));
  EXPECT_TRUE(finds([](Json& p) { add(p["certificate"]["max_speed"][0], -0.01); }, {"'certificate.max_speed[0]'"}));
  EXPECT_TRUE(finds([](Json& p) { p["certificate"]["tolerance"] = 1; }, {"'certificate.tolerance'"}));
  EXPECT_TRUE(finds([](Json& p) { p["certificate"]["pass"] = false; }, {"'certificate.pass'"}));
  EXPECT_TRUE(finds(
      [](Json& p) {
        p["snapped"]["goal"] = {{"position", p["request"]["goal"]["position"]}, {"moved", 0.2}};
      },
      {"the goal was moved by 0 m"}));
}

TEST_F(Verify, AnotherMapIsFound) {
  EXPECT_TRUE(finds([](Json& p) { p["map"]["crc32"] = "00000000"; }, {"another map", "00000000"}));
  EXPECT_TRUE(finds([](Json& p) { p["map"]["radius_m"] = 0.1; }, {"radius"}));
  ASSERT_EQ(swiftlet({"map", "build", path("rooms.bt"), "-o", path("wide.swm"), "--radius", "0.2"}).status, 0);
  write_text(path("plan.json"), good_.dump());
  const Outcome run = swiftlet({"verify", path("plan.json"), path("wide.swm")});
  EXPECT_EQ(run.status, 1);
  EXPECT_NE(run.err.find("another map"), std::string::npos) << run.err;
}

TEST_F(Verify, APlanWithoutTrajectoryHasNothingToVerify) {
  EXPECT_TRUE(refused(verify(planned({"--goal", kRight}).dump()), 1, {"no trajectory", "no_path"}));
}

TEST_F(Verify, RefusesFilesThatAreNoPlanNamingFileAndFault) {
  const auto refuses = [&](const std::string& text, const std::string& word) {
    return refused(verify(text), 3, {"plan.json", word});
  };
  const auto refuses_change = [&](const std::function<void(Json&)>& change, const std::string& word) {
    Json plan = good_;
    change(plan);
    return refuses(plan.dump(), word);
  };
  EXPECT_TRUE(refuses("", "empty"));
  EXPECT_TRUE(refuses("{\n\"format\":", ":2: not valid JSON"));
  EXPECT_TRUE(refuses("[]", "object"));
  EXPECT_TRUE(refuses("{}", "'format' is missing"));
  EXPECT_TRUE(refuses("{\"a\": 1e999}", "out of range"));
  EXPECT_TRUE(refuses_change([](Json& p) { p["format"] = "swiftlet-plan/2"; }, "'format'"));
  EXPECT_TRUE(refuses_change([](Json& p) { p["status"] = "perfect"; }, "perfect"));
  EXPECT_TRUE(refuses_change([](Json& p) { p["request"]["norm"] = "manhattan"; }, "'request.norm'"));
  EXPECT_TRUE(refuses_change([](Json& p) { p["request"]["vmax"] = nullptr; }, "'request.vmax' is not a number"));
  EXPECT_TRUE(refuses_change([](Json& p) { p["segments"][0]["y"].push_back(0); }, "'segments[0].y' has 7 numbers"));
  EXPECT_TRUE(refuses_change([](Json& p) { p["segments"][0]["x"][2] = nullptr; }, "'segments[0].x' is not a number"));
  EXPECT_TRUE(refuses_change([](Json& p) { p["corridor"][0].erase(5); }, "'corridor[0]' has 5 numbers"));
  EXPECT_TRUE(refuses_change([](Json& p) { p["gates"] = 1; }, "'gates' is not a list"));
  EXPECT_TRUE(refuses_change([](Json& p) { p["certificate"]["pass"] = 1; }, "'certificate.pass'"));
  for (const char* key : {"map", "request", "corridor", "gates", "segments", "duration", "length", "jerk_cost",
                          "certificate", "status"}) {
    EXPECT_TRUE(refuses_change([&](Json& p) { p.erase(key); }, std::string("'") + key + "' is missing"));
  }
  EXPECT_TRUE(refused(swiftlet({"verify", path("none.json"), path("rooms.swm")}), 3, {"none.json"}));
  write_text(path("plan.json"), good_.dump());
  EXPECT_TRUE(refused(swiftlet({"verify", path("plan.json"), path("none.swm")}), 3, {"none.swm"}));
  EXPECT_TRUE(refused(swiftlet({"verify", path("plan.json")}), 2, {"map"}));
}

}  // namespace
}  // namespace swiftlet::tools
