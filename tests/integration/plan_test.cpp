// `swiftlet plan`, `map` and `world` as the contract describes them.
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <string>

#include "program.hpp"
#include "two_rooms.hpp"

namespace swiftlet::tools {
namespace {

class Program : public FolderTest {
 protected:
  void SetUp() override {
    write_two_rooms(path("rooms.bt"));
    ASSERT_EQ(swiftlet({"map", "build", path("rooms.bt"), "-o", path("rooms.swm"), "--radius", "0.15", "--json",
                        path("map.json")})
                  .status,
              0);
  }
  Outcome plan(const std::vector<std::string>& extra) {
    std::vector<std::string> arguments{"plan", path("rooms.swm"), "--vmax", "1", "--amax", "2"};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    return swiftlet(arguments);
  }
  /// The plan between two points, read from standard output.
  Json planned(const std::string& start, const std::string& goal, std::vector<std::string> extra = {}) {
    extra.insert(extra.end(), {"--start", start, "--goal", goal, "--json", "-"});
    const Outcome run = plan(extra);
    EXPECT_FALSE(run.out.empty()) << run.err;
    return run.out.empty() ? Json::object() : Json::parse(run.out);
  }
};

double at(const Json& coefficients, double t) {
  double value = 0;
  for (std::size_t j = coefficients.size(); j-- > 0;) value = value * t + coefficients[j].get<double>();
  return value;
}

TEST_F(Program, PlanHasEveryFieldOfTheContract) {
  const Json json = planned(kLeft, kLeftToo);
  EXPECT_EQ(json["format"], "swiftlet-plan/1");
  EXPECT_EQ(json["status"], "optimal");
  EXPECT_EQ(json["map"]["path"], path("rooms.swm"));
  const std::string crc = json["map"]["crc32"].get<std::string>();
  EXPECT_EQ(crc.size(), 8U);
  EXPECT_EQ(crc.find_first_not_of("0123456789abcdef"), std::string::npos) << crc;
  EXPECT_EQ(json["map"]["resolution_m"], 0.1);
  EXPECT_EQ(json["map"]["radius_m"], 0.15);
  EXPECT_EQ(json["request"]["start"]["position"], Json::array({-0.75, -0.75, 0.5}));
  EXPECT_EQ(json["request"]["goal"]["velocity"], Json::array({0.0, 0.0, 0.0}));
  EXPECT_EQ(json["request"]["vmax"], 1.0);
  EXPECT_EQ(json["request"]["amax"], 2.0);
  EXPECT_EQ(json["request"]["norm"], "axis");
  EXPECT_EQ(json["request"]["corridor"], "extents");
  EXPECT_EQ(json["request"]["relax"], true);
  ASSERT_GE(json["corridor"].size(), 1U);
  EXPECT_EQ(json["gates"].size() + 1, json["corridor"].size());
  EXPECT_EQ(json["segments"].size(), json["corridor"].size());
  EXPECT_EQ(json["corridor"][0].size(), 6U);
  EXPECT_EQ(json["jerk_cost"].size(), 3U);
  EXPECT_EQ(json["qp"]["vmax"].size(), 3U);
  EXPECT_EQ(json["qp"]["margins"]["position"], 0.0);
  for (const char* key : {"tolerance", "box_margin", "max_speed", "max_speed_norm", "max_acceleration",
                          "max_acceleration_norm", "pass"}) {
    EXPECT_TRUE(json["certificate"].contains(key)) << key;
  }
  EXPECT_EQ(json["certificate"]["pass"], true);
  for (const char* key : {"search_us", "trajectory_us", "total_us", "expanded", "qp_iterations", "constraints_added",
                          "active", "time_scale"}) {
    EXPECT_TRUE(json["stats"][key].is_number()) << key;
  }
  EXPECT_GE(json["stats"]["total_us"].get<double>(),
            json["stats"]["search_us"].get<double>() + json["stats"]["trajectory_us"].get<double>());
  EXPECT_FALSE(json.contains("blocking"));
  EXPECT_FALSE(json.contains("fallback_reason"));
  EXPECT_FALSE(json.contains("snapped"));
  double duration = 0;
  for (const Json& segment : json["segments"]) duration += segment["duration"].get<double>();
  EXPECT_DOUBLE_EQ(json["duration"].get<double>(), duration);
  EXPECT_NEAR(at(json["segments"].back()["x"], json["segments"].back()["duration"].get<double>()), 0.55, 1e-6);
}

TEST_F(Program, GatesAreTheIntersectionsOfTheirBoxesBitForBit) {
  for (const char* corridor : {"extents", "cells"}) {
    const Json json = planned(kLeft, kLeftToo, {"--corridor", corridor});
    for (std::size_t i = 0; i < json["gates"].size(); ++i) {
      int wide = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const double lo = std::max(json["corridor"][i][k].get<double>(), json["corridor"][i + 1][k].get<double>());
        const double hi =
            std::min(json["corridor"][i][k + 3].get<double>(), json["corridor"][i + 1][k + 3].get<double>());
        EXPECT_EQ(json["gates"][i][k].get<double>(), lo);
        EXPECT_EQ(json["gates"][i][k + 3].get<double>(), hi);
        wide += lo < hi ? 1 : 0;
      }
      EXPECT_GE(wide, 2) << corridor;
    }
  }
}

TEST_F(Program, EveryChoiceOfCorridorNormAndSearchGivesACertifiedPlan) {
  for (const std::vector<std::string>& extra :
       std::vector<std::vector<std::string>>{{"--corridor", "cells"},
                                             {"--corridor", "cells", "--relax", "off"},
                                             {"--norm", "euclidean"},
                                             {"--search", "plain"},
                                             {"--search", "landmarks"},
                                             {"--search-weight", "1.5"}}) {
    const Json json = planned(kLeft, kLeftToo, extra);
    EXPECT_TRUE(json["status"] == "optimal" || json["status"] == "fallback") << extra[1];
    EXPECT_EQ(json["certificate"]["pass"], true) << extra[1];
    if (extra[0] == "--norm") {
      EXPECT_EQ(json["request"]["norm"], "euclidean");
      EXPECT_LE(json["certificate"]["max_speed_norm"].get<double>(), 1 + 1e-6);
    }
  }
}

TEST_F(Program, AnOptimalPlanFedBackToSolveCostsTheSame) {
  const Json json = planned(kLeft, kLeftToo);
  ASSERT_EQ(json["status"], "optimal");
  Json problem{
      {"format", "swiftlet-case/1"},   {"boxes", json["corridor"]},         {"gates", json["gates"]},
      {"durations", Json::array()},    {"start", json["request"]["start"]}, {"goal", json["request"]["goal"]},
      {"vmax", json["qp"]["vmax"][0]}, {"amax", json["qp"]["amax"][0]},     {"margins", json["qp"]["margins"]}};
  for (const Json& segment : json["segments"]) problem["durations"].push_back(segment["duration"]);
  write_text(path("case.json"), problem.dump());
  const Outcome run = swiftlet({"solve", path("case.json"), "--json", "-"});
  ASSERT_EQ(run.status, 0) << run.err;
  const Json again = Json::parse(run.out);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double cost = json["jerk_cost"][axis].get<double>();
    EXPECT_NEAR(again["jerk_cost"][axis].get<double>(), cost, 1e-5 * std::max(cost, 1e-5));
  }
}

TEST_F(Program, StartEqualToGoalIsOneSegmentOfPositiveDuration) {
  const Json json = planned(kLeft, kLeft);
  ASSERT_EQ(json["segments"].size(), 1U);
  EXPECT_GT(json["duration"].get<double>(), 0.0);
  EXPECT_NEAR(json["length"].get<double>(), 0.0, 1e-9);
}

TEST_F(Program, TheSameQuestionGetsTheSameBytesButForTheTimes) {
  Json first = planned(kLeft, kLeftToo);
  Json second = planned(kLeft, kLeftToo);
  for (Json* json : {&first, &second}) {
    for (const char* key : {"search_us", "trajectory_us", "total_us"}) (*json)["stats"].erase(key);
  }
  EXPECT_EQ(first.dump(), second.dump());
}

TEST_F(Program, ARefusalKeepsTheRequestAndNothingOfATrajectory) {
  const Outcome run = plan({"--start", kLeft, "--goal", kRight, "--json", path("p.json"), "--csv", path("p.csv")});
  EXPECT_TRUE(refused(run, 1, {"no_path"}));
  const Json json = Json::parse(read_text(path("p.json")));
  EXPECT_EQ(json["status"], "no_path");
  EXPECT_EQ(json["request"]["goal"]["position"], Json::array({2.05, 0.05, 0.5}));
  for (const char* key : {"corridor", "gates", "segments", "duration", "certificate", "qp", "blocking"}) {
    EXPECT_FALSE(json.contains(key)) << key;
  }
  EXPECT_FALSE(std::filesystem::exists(path("p.csv")));
}

TEST_F(Program, SnapMovesAnEndThatIsNotFreeAndSaysByHowMuch) {
  EXPECT_EQ(planned(kNearPillar, kLeftToo)["status"], "start_not_free");
  EXPECT_EQ(planned(kNearPillar, kLeftToo, {"--snap", "0.01"})["status"], "start_not_free");
  const Outcome run = plan({"--start", kNearPillar, "--goal", kLeftToo, "--snap", "0.2", "--json", path("p.json")});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.err.find("moved"), std::string::npos);
  const Json json = Json::parse(read_text(path("p.json")));
  EXPECT_EQ(json["request"]["start"]["position"], Json::array({0.1, 0.05, 0.5}));
  const double moved = json["snapped"]["start"]["moved"].get<double>();
  EXPECT_GT(moved, 0.04);
  EXPECT_LT(moved, 0.2);
  EXPECT_FALSE(json["snapped"].contains("goal"));
}

TEST_F(Program, CsvHasARowEveryHundredthAndTheLastExactlyAtTheEnd) {
  const Outcome run = plan({"--start", kLeft, "--goal", kLeftToo, "--csv", "-", "--json", path("p.json")});
  ASSERT_EQ(run.status, 0) << run.err;
  const double duration = Json::parse(read_text(path("p.json")))["duration"].get<double>();
  std::istringstream csv(run.out);
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line, "t,x,y,z,vx,vy,vz,ax,ay,az,jx,jy,jz");
  std::vector<std::vector<double>> rows;
  while (std::getline(csv, line)) {
    rows.emplace_back();
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) rows.back().push_back(std::stod(field));
    ASSERT_EQ(rows.back().size(), 13U);
  }
  ASSERT_EQ(rows.size(), static_cast<std::size_t>(std::ceil(duration * 100)) + 1);
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) EXPECT_EQ(rows[i][0], static_cast<double>(i) / 100);
  EXPECT_EQ(rows.back()[0], duration);
  EXPECT_NEAR(rows.front()[1], -0.75, 1e-9);
  EXPECT_NEAR(rows.back()[1], 0.55, 1e-6);
  EXPECT_NEAR(rows.back()[4], 0, 1e-6);
}

TEST_F(Program, ABatchAnswersEveryLineInOrderWhateverTheStatus) {
  write_text(path("q.csv"),
             "\xef\xbb\xbfname,x1,y1,z1,x0,y0,z0\r\n"
             "there,0.55,0.55,0.5,-0.75,-0.75,0.5\r\n"
             "\r\n"
             "wall,2.05,0.05,0.5,-0.75,-0.75,0.5\r\n"
             "not finite,nan,0,0,-0.75,-0.75,0.5\r\n"
             "infinite,0,0,0,1e999,-inf,0.5\r\n"
             "pillar,0.55,0.55,0.5,-0.1,0.05,0.5\r\n"
             "back,-0.75,-0.75,0.5,0.55,0.55,0.5");
  const Outcome run = plan({"--queries", path("q.csv"), "--jsonl", path("out.jsonl")});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_TRUE(run.out.empty());
  const std::vector<Json> plans = read_lines(path("out.jsonl"));
  ASSERT_EQ(plans.size(), 6U);
  EXPECT_EQ(plans[0]["status"], "optimal");
  EXPECT_EQ(plans[1]["status"], "no_path");
  EXPECT_EQ(plans[2]["status"], "bad_request");
  EXPECT_TRUE(plans[2]["request"]["goal"]["position"][0].is_null());
  EXPECT_EQ(plans[3]["status"], "bad_request");
  EXPECT_EQ(plans[4]["status"], "start_not_free");
  EXPECT_EQ(plans[5]["status"], "optimal");
  EXPECT_EQ(plans[5]["request"]["goal"]["position"], Json::array({-0.75, -0.75, 0.5}));
  const Outcome on_terminal = plan({"--queries", path("q.csv"), "--jsonl", "-"});
  EXPECT_EQ(std::count(on_terminal.out.begin(), on_terminal.out.end(), '\n'), 6);
}

TEST_F(Program, ABatchReadsOverQuotedFieldsOfOtherColumns) {
  write_text(path("q.csv"),
             "\"x0\",y0,z0,x1,y1,z1,note\n"
             "-0.75,-0.75,0.5,0.55,0.55,0.5,\"there, and back\"\n"
             "-0.75,-0.75,0.5,0.55,0.55,\"0.5\",\"said \"\"go\"\", went\"\n");
  const Outcome run = plan({"--queries", path("q.csv"), "--jsonl", path("out.jsonl")});
  ASSERT_EQ(run.status, 0) << run.err;
  const std::vector<Json> plans = read_lines(path("out.jsonl"));
  ASSERT_EQ(plans.size(), 2U);
  for (const Json& json : plans) EXPECT_EQ(json["status"], "optimal");
}

TEST_F(Program, LongWorkShowsProgressOnATerminalAndTakesItAway) {
  write_text(path("q.csv"), "x0,y0,z0,x1,y1,z1\n-0.75,-0.75,0.5,0.55,0.55,0.5\n");
  const auto last_column = [](const Outcome& run) { return run.err.substr(run.err.rfind('\r') + 1); };
  const std::vector<std::string> batch{"plan", path("rooms.swm"), "--queries", path("q.csv"), "--vmax",
                                       "1",    "--amax",          "1",         "--jsonl",     path("out.jsonl")};
  const Outcome planned = swiftlet_on_terminal(batch);
  EXPECT_EQ(planned.status, 0) << planned.err;
  EXPECT_NE(planned.err.find("plan "), std::string::npos) << planned.err;
  EXPECT_NE(planned.err.find("100 %"), std::string::npos) << planned.err;
  EXPECT_EQ(last_column(planned), "\033[K");
  const Outcome world =
      swiftlet_on_terminal({"world", "classroom", "--seed", "1", "-o", path("w.bt"), "--query", path("w.csv")});
  EXPECT_NE(world.err.find("queries "), std::string::npos) << world.err;
  EXPECT_NE(world.err.find(" 50 %"), std::string::npos) << world.err;
  EXPECT_EQ(last_column(world), "\033[K");
  EXPECT_EQ(swiftlet(batch).err, "");
}

TEST_F(Program, MapShowWritesAPageOfTheMap) {
  ASSERT_EQ(swiftlet({"map", "show", path("rooms.swm"), "--report", path("map.html")}).status, 0);
  const std::string page = read_text(path("map.html"));
  EXPECT_TRUE(page.starts_with("<!doctype html>")) << page.substr(0, 40);
  const std::string crc = Json::parse(read_text(path("map.json")))["crc32"].get<std::string>();
  EXPECT_NE(page.find(crc), std::string::npos);
  EXPECT_NE(page.find("tries what would connect it"), std::string::npos);
  EXPECT_TRUE(refused(swiftlet({"map", "show", path("none.swm"), "--report", path("no.html")}), 3, {"none.swm"}));
  EXPECT_TRUE(refused(swiftlet({"map", "show", path("rooms.swm")}), 2, {"--report"}));
  EXPECT_TRUE(refused(swiftlet({"map", "show", path("rooms.swm"), "--report", path("rooms.swm")}), 2, {"input"}));
  EXPECT_FALSE(std::filesystem::exists(path("no.html")));
}

TEST_F(Program, AMovingStartKeepsItsVelocityOrIsInfeasibleWithTheBlockingBound) {
  const Json moving = planned(kLeft, kLeftToo, {"--start-velocity", "0.4,0.2,0"});
  ASSERT_EQ(moving["status"], "optimal");
  EXPECT_NEAR(moving["segments"][0]["x"][1].get<double>(), 0.4, 1e-9);
  EXPECT_EQ(moving["request"]["start"]["velocity"], Json::array({0.4, 0.2, 0.0}));

  const Json crashing =
      planned(kLeft, kLeftToo, {"--start-velocity", "-1,0,0"});  // 0.25 m to the wall, 0.25 m/s^2 short
  EXPECT_EQ(crashing["status"], "infeasible");
  EXPECT_TRUE(crashing["blocking"]["axis"].is_string());
  EXPECT_TRUE(crashing["blocking"].contains("stretch"));
  EXPECT_FALSE(crashing.contains("segments"));
}

TEST_F(Program, BudgetsAreCountsAndAUsedUpDeadlineFallsBack) {
  const Json whole = planned(kLeft, kLeftToo);
  const Json plain = planned(kLeft, kLeftToo, {"--refine-us", "0"});
  EXPECT_EQ(plain["status"], "optimal");
  EXPECT_LT(plain["stats"]["work"], whole["stats"]["work"]);
  EXPECT_GT(plain["duration"], whole["duration"]);
  const Json late = planned(kLeft, kLeftToo, {"--deadline-us", "0"});
  EXPECT_EQ(late["status"], "fallback");
  EXPECT_EQ(late["fallback_reason"], "deadline");
  EXPECT_EQ(late["certificate"]["pass"], true);
}

TEST_F(Program, JerkAndVehicleLimitsStandInRequestAndCertificate) {
  const Json without = planned(kLeft, kLeftToo);
  EXPECT_TRUE(without["request"]["jmax"].is_null());
  EXPECT_TRUE(without["request"]["vehicle"].is_null());
  EXPECT_TRUE(without["certificate"]["max_rate"].is_null());
  EXPECT_GT(without["certificate"]["max_jerk_norm"], 3.0);
  write_text(path("vehicle.json"), R"({"format": "swiftlet-vehicle/1", "mass_kg": 1.5, "thrust_min_n": 3,
                                      "thrust_max_n": 25, "rate_max_rad_s": 0.3})");
  const Json json = planned(kLeft, kLeftToo, {"--jmax", "3", "--vehicle", path("vehicle.json")});
  EXPECT_EQ(json["request"]["jmax"], 3.0);
  EXPECT_EQ(json["request"]["vehicle"]["mass_kg"], 1.5);
  for (const Json& jerk : json["certificate"]["max_jerk"]) EXPECT_LE(jerk, 3.0 + 1e-6);
  EXPECT_LE(json["certificate"]["max_rate"], 0.3 + 1e-6);
  EXPECT_GE(json["certificate"]["min_thrust"], 3.0);
  EXPECT_LE(json["certificate"]["max_thrust"], 25.0);
}

TEST_F(Program, MapReportsAgreeBetweenBuildAndInfo) {
  const Json built = Json::parse(read_text(path("map.json")));
  const Outcome run = swiftlet({"map", "info", path("rooms.swm"), "--json", "-"});
  ASSERT_EQ(run.status, 0) << run.err;
  const Json info = Json::parse(run.out);
  for (const Json& report : {built, info}) {
    EXPECT_EQ(report["format"], "swiftlet-map/1");
    EXPECT_EQ(report["resolution_m"], 0.1);
    EXPECT_EQ(report["radius_m"], 0.15);
    EXPECT_EQ(report["unknown"], "avoid");
    EXPECT_EQ(report["components"], 2);
    EXPECT_EQ(report["bounds"].size(), 6U);
    EXPECT_NEAR(report["bounds"][0].get<double>(), -1, 1e-6);
    EXPECT_NEAR(report["bounds"][3].get<double>(), 3, 1e-6);
    EXPECT_EQ(report["blob_bytes"], std::filesystem::file_size(path("rooms.swm")));
    EXPECT_GT(report["cells"].get<int>(), 1);
    EXPECT_GT(report["windows"].get<int>(), 0);
    EXPECT_GT(report["free_m3"].get<double>(), 3.0);
    EXPECT_GT(report["largest_component"].get<double>(), 0.5);
    EXPECT_LT(report["largest_component"].get<double>(), 0.6);
    ASSERT_GE(report["boards"].size(), 3U);
    for (const Json& board : report["boards"]) {
      EXPECT_EQ(board["holds_map"], true) << board;
      EXPECT_EQ(board["search_share"], 1) << board;
    }
  }
  EXPECT_EQ(built["boards"], info["boards"]);
  EXPECT_EQ(built["alternatives"].size(), 2U);  // a wall parts the rooms whatever the policy
  EXPECT_EQ(info["alternatives"].size(), 0U);
  EXPECT_NE(run.err.find("'swiftlet map build' tries what would connect it"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("mps2-an500"), std::string::npos);
  const auto text = [](const Json& number) { return number.dump(); };
  EXPECT_NE(run.err.find(text(info["degree"]["max"]) + " at most"), std::string::npos) << run.err;
  for (const auto& [name, bytes] : info["section_bytes"].items()) {
    EXPECT_NE(run.err.find(name + " " + text(bytes)), std::string::npos) << name;
  }
  EXPECT_NE(run.err.find("worst loss     free points within 0.323 m of an obstacle"), std::string::npos) << run.err;
  EXPECT_EQ(built["crc32"], info["crc32"]);
  EXPECT_EQ(built["crc32"], planned(kLeft, kLeftToo)["map"]["crc32"]);
}

TEST_F(Program, AMapInPiecesThatNoOptionJoinsSaysSo) {
  const Outcome run = swiftlet(
      {"map", "build", path("rooms.bt"), "-o", path("open.swm"), "--radius", "0", "--unknown", "free", "--no-verify"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.err.find("no option is left that could connect it"), std::string::npos) << run.err;
  EXPECT_EQ(run.err.find("map build"), std::string::npos) << run.err;
}

TEST_F(Program, MapVerifyPassesEveryMapThatBuildMakes) {
  for (const std::vector<std::string>& extra :
       std::vector<std::vector<std::string>>{{},
                                             {"--unknown", "free"},
                                             {"--unknown", "occupied", "--partition", "octree"},
                                             {"--coarsen", "2"},
                                             {"--drop-slivers", "0.2"},
                                             {"--bounds", "-0.9,-0.9,0,0.9,0.9,1"}}) {
    std::vector<std::string> build{"map", "build", path("rooms.bt"), "-o", path("v.swm"), "--radius", "0.15"};
    build.insert(build.end(), extra.begin(), extra.end());
    ASSERT_EQ(swiftlet(build).status, 0);
    const Outcome run = swiftlet({"map", "verify", path("v.swm"), path("rooms.bt")});
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_EQ(run.out, "");
  }
}

TEST_F(Program, MapVerifyNamesWhatAnotherSourceContradictsAndWhere) {
  octomap::OcTree tree(path("rooms.bt"));
  tree.updateNode(-0.75, -0.75, 0.55, true);
  tree.updateNode(-0.75, -0.75, 0.55, true);
  tree.updateNode(-0.75, -0.75, 0.55, true);
  tree.writeBinary(path("changed.bt"));
  const Outcome run = swiftlet({"map", "verify", path("rooms.swm"), path("changed.bt")});
  EXPECT_EQ(run.status, 1);
  for (const char* word : {"SHA-256", "lies in an obstacle", "(-0.8, -0.8, 0.5)", "defects"}) {
    EXPECT_NE(run.err.find(word), std::string::npos) << word << " is missing in " << run.err;
  }
}

TEST_F(Program, ABuildWithoutVerificationGivesTheSameBytes) {
  ASSERT_EQ(
      swiftlet({"map", "build", path("rooms.bt"), "-o", path("quick.swm"), "--radius", "0.15", "--no-verify"}).status,
      0);
  EXPECT_EQ(read_text(path("rooms.swm")), read_text(path("quick.swm")));
}

TEST_F(Program, AnImportedCloudBecomesAMapToPlanOn) {
  std::string cloud;  // the inside of a cube of 4 m around the sensor
  for (int i = -20; i <= 20; ++i) {
    for (int j = -20; j <= 20; ++j) {
      for (const double side : {-2.0, 2.0}) {
        const std::array<double, 3> p{side, 0.1 * i, 0.1 * j};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          cloud += std::to_string(p[axis]) + " " + std::to_string(p[(axis + 1) % 3]) + " " +
                   std::to_string(p[(axis + 2) % 3]) + "\n";
        }
      }
    }
  }
  write_text(path("cube.xyz"), cloud + "nan 0 0\n");
  const auto plan_on = [&](const std::vector<std::string>& extra, const char* unknown) {
    std::vector<std::string> import{"map", "import", path("cube.xyz"), "--resolution", "0.1", "-o", path("cube.bt")};
    import.insert(import.end(), extra.begin(), extra.end());
    const Outcome imported = swiftlet(import);
    EXPECT_EQ(imported.status, 0) << imported.err;
    EXPECT_NE(imported.err.find("10086 points, 1 without numbers"), std::string::npos) << imported.err;
    EXPECT_EQ(imported.out, "");
    EXPECT_EQ(
        swiftlet({"map", "build", path("cube.bt"), "-o", path("cube.swm"), "--radius", "0.3", "--unknown", unknown})
            .status,
        0);
    const Outcome run = swiftlet({"plan", path("cube.swm"), "--start", "-1,-1,-1", "--goal", "1,1,1", "--vmax", "1",
                                  "--amax", "1", "--json", "-"});
    return Json::parse(run.out)["status"].get<std::string>();
  };
  EXPECT_EQ(plan_on({"--origin-rays"}, "avoid"), "optimal");
  EXPECT_EQ(plan_on({}, "avoid"), "start_not_free");
  EXPECT_EQ(plan_on({}, "free"), "optimal");
}

TEST_F(Program, UnknownPoliciesDecideOverTheHole) {
  const auto status = [&](const std::string& policy) {
    const Outcome built = swiftlet({"map", "build", path("rooms.bt"), "-o", path(policy + ".swm"), "--radius", "0.15",
                                    "--unknown", policy, "--partition", "octree"});
    EXPECT_EQ(built.status, 0) << built.err;
    EXPECT_EQ(built.out, "");
    const Outcome run = swiftlet({"plan", path(policy + ".swm"), "--vmax", "1", "--amax", "1", "--start", kLeft,
                                  "--goal", kInHole, "--json", "-"});
    return Json::parse(run.out)["status"].get<std::string>();
  };
  EXPECT_EQ(status("free"), "optimal");
  EXPECT_EQ(status("avoid"), "goal_not_free");
  EXPECT_EQ(status("occupied"), "goal_not_free");
}

TEST_F(Program, SameMapSameBytes) {
  ASSERT_EQ(swiftlet({"map", "build", path("rooms.bt"), "-o", path("again.swm"), "--radius", "0.15"}).status, 0);
  EXPECT_EQ(read_text(path("rooms.swm")), read_text(path("again.swm")));
}

TEST_F(Program, HelpAndVersionWorkEverywhere) {
  for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{{},
                                                                                       {"map"},
                                                                                       {"map", "build"},
                                                                                       {"map", "info"},
                                                                                       {"map", "show"},
                                                                                       {"map", "verify"},
                                                                                       {"map", "import"},
                                                                                       {"plan"},
                                                                                       {"solve"},
                                                                                       {"verify"},
                                                                                       {"world"}}) {
    for (const char* flag : {"--help", "--version"}) {
      std::vector<std::string> arguments = command;
      arguments.emplace_back(flag);
      const Outcome run = swiftlet(arguments);
      EXPECT_EQ(run.status, 0);
      EXPECT_NE((run.out + run.err).find("swiftlet"), std::string::npos);
    }
  }
}

TEST_F(Program, WorldsComeOutTheSameForTheSameSeedAndOnlyThoseThatExist) {
  const auto world = [&](const std::string& kind, const std::string& seed, const std::string& name) {
    return swiftlet({"world", kind, "--seed", seed, "-o", path(name + ".bt"), "--query", path(name + ".csv")});
  };
  for (const char* kind : {"maze", "classroom", "forest"}) {
    ASSERT_EQ(world(kind, "1", "a").status, 0);
    ASSERT_EQ(world(kind, "1", "b").status, 0);
    ASSERT_EQ(world(kind, "2", "c").status, 0);
    EXPECT_EQ(read_text(path("a.bt")), read_text(path("b.bt")));
    EXPECT_EQ(read_text(path("a.csv")), read_text(path("b.csv")));
    EXPECT_NE(read_text(path("a.bt")), read_text(path("c.bt")));
  }
  EXPECT_TRUE(refused(world("moon", "1", "d"), 2, {"moon", "maze"}));
  EXPECT_TRUE(refused(world("maze", "-1", "d"), 2, {"--seed"}));
  EXPECT_TRUE(refused(world("maze", "1.5", "d"), 2, {"--seed"}));
  const auto scaled = [&](const std::string& kind, const std::string& scale) {
    return swiftlet({"world", kind, "--seed", "1", "--scale", scale, "-o", path("d.bt")});
  };
  EXPECT_TRUE(refused(scaled("maze", "2"), 2, {"--scale", "office", "maze"}));
  EXPECT_TRUE(refused(scaled("office", "3"), 2, {"--scale", "3", "1, 2, 4 and 8"}));
  EXPECT_TRUE(refused(scaled("office", "x"), 2, {"--scale", "x"}));
  EXPECT_FALSE(std::filesystem::exists(path("d.bt")));
  EXPECT_EQ(scaled("maze", "1").status, 0);
}

TEST_F(Program, EveryQueryOfTheGeneratedWorldsGetsATrajectory) {
  for (const char* kind : {"maze", "classroom"}) {
    ASSERT_EQ(swiftlet({"world", kind, "--seed", "1", "-o", path("w.bt"), "--query", path("w.csv")}).status, 0);
    ASSERT_EQ(swiftlet({"map", "build", path("w.bt"), "-o", path("w.swm"), "--radius", "0.15"}).status, 0);
    const Outcome run = swiftlet(
        {"plan", path("w.swm"), "--queries", path("w.csv"), "--vmax", "1", "--amax", "2", "--jsonl", path("w.jsonl")});
    ASSERT_EQ(run.status, 0) << run.err;
    const std::vector<Json> plans = read_lines(path("w.jsonl"));
    ASSERT_EQ(plans.size(), 100U);
    for (const Json& json : plans) {
      ASSERT_TRUE(json.contains("certificate")) << kind << " " << json["status"];
      EXPECT_EQ(json["certificate"]["pass"], true);
    }
  }
}

}  // namespace
}  // namespace swiftlet::tools
