// `swiftlet fly`: the closed loop of companion and simulated autopilot, its report, and every kind of fault.
#include <algorithm>
#include <set>
#include <string>

#include "program.hpp"
#include "two_rooms.hpp"

namespace swiftlet::tools {
namespace {

using Words = std::vector<std::string>;

class FlyTest : public FolderTest {
 protected:
  void SetUp() override {
    ASSERT_EQ(swiftlet({"world", "classroom", "--seed", "1", "-o", path("room.bt")}).status, 0);
    ASSERT_EQ(swiftlet({"map", "build", path("room.bt"), "-o", path("room.swm"), "--radius", "0.3"}).status, 0);
  }

  [[nodiscard]] Words flight(const Words& extra) const {
    Words words{"fly",    path("room.swm"), "--start", "0.48,0.48,0.8", "--goal",      "3.68,2.72,0.8",
                "--goal", "1,2.6,1.2",      "--goal",  "3.36,0.8,0.8",  "--in-process"};
    words.insert(words.end(), extra.begin(), extra.end());
    return words;
  }
  [[nodiscard]] Outcome replay(const Words& extra = {}) const {
    Words words{"replay", path("flight.ulg"), "--map", path("room.swm")};
    words.insert(words.end(), extra.begin(), extra.end());
    return swiftlet(words);
  }
  Json fly(const Words& extra, int status = 0) {
    Words words = flight(extra);
    words.insert(words.end(), {"--json", path("flight.json")});
    const Outcome run = swiftlet(words);
    EXPECT_EQ(run.status, status) << run.err;
    return Json::parse(read_text(path("flight.json")));
  }
};

TEST_F(FlyTest, ArrivesAtEveryGoalLandsAndReportsAsTheContractSays) {
  for (const char* form : {"attitude", "rates"}) {
    const Json report = fly({"--setpoint", form});
    EXPECT_EQ(report["format"], "swiftlet-flight/1");
    EXPECT_EQ(report["status"], "arrived");
    EXPECT_TRUE(report["landed"]);
    EXPECT_EQ(report["plan"]["format"], "swiftlet-plan/1");
    EXPECT_EQ(report["plan"]["status"], "optimal");
    EXPECT_EQ(report["plan"]["request"]["goal"]["position"], Json::array({3.68, 2.72, 0.8}));
    EXPECT_TRUE(report["plan"]["certificate"]["pass"]);
    EXPECT_GT(report["link"]["messages_in"], 1000);
    EXPECT_GT(report["link"]["messages_out"], 1000);
    EXPECT_EQ(report["link"]["crc_errors"], 0);
    EXPECT_LT(report["link"]["load_in"], 0.3);
    EXPECT_LT(report["link"]["load_out"], 0.3);
    EXPECT_GT(report["tracking"]["rms"], 0);
    EXPECT_LE(report["tracking"]["rms"], report["tracking"]["max"]);
    EXPECT_LT(report["tracking"]["max"], 0.3);
    EXPECT_GT(report["flown_clearance"], report["margins"]["vehicle_radius"]);
    EXPECT_GT(report["flown_duration"], report["plan"]["duration"]);
    EXPECT_EQ(report["arrivals"].size(), 3);
    EXPECT_EQ(report["setpoints"]["stale"], 0);
    EXPECT_EQ(report["setpoints"]["repeated"], 0);
    double last = 0;
    std::size_t arrivals = 0;
    for (const Json& event : report["events"]) {
      EXPECT_LE(last, event["t"]);
      last = event["t"];
      ASSERT_TRUE(event["what"].is_string());
      if (!event["what"].get<std::string>().ends_with(" reached")) continue;
      ASSERT_LT(arrivals, report["arrivals"].size());
      EXPECT_EQ(event["t"], report["arrivals"][arrivals++]);
    }
    EXPECT_EQ(arrivals, 3);
    for (const Json& speed : report["reference"]["max_speed"]) EXPECT_LE(speed, 1.001);
    for (const Json& acceleration : report["reference"]["max_acceleration"]) EXPECT_LE(acceleration, 2.001);
  }
}

TEST_F(FlyTest, KeepsItsTrackingBarInCalmAndInGustsBehindALink) {
  struct Air {
    Words words;
    double rms;   // [m]
    double most;  // [m]
  };
  for (const Air& air : {Air{{}, 0.06, 0.15}, Air{{"--gust", "3", "--link-delay", "0.02"}, 0.10, 0.30}}) {
    for (const char* form : {"attitude", "rates"}) {
      for (const char* seed : {"1", "2", "3"}) {
        Words words = air.words;
        words.insert(words.end(), {"--setpoint", form, "--seed", seed});
        const Json report = fly(words);
        EXPECT_EQ(report["status"], "arrived");
        EXPECT_LE(report["tracking"]["rms"], air.rms) << form << " " << seed;
        EXPECT_LE(report["tracking"]["max"], air.most) << form << " " << seed;
      }
    }
  }
}

/// The report without what planning took, which is measured.
std::string timeless(Json report) {
  for (const char* time : {"search_us", "trajectory_us", "total_us"}) report["plan"]["stats"].erase(time);
  for (Json& plan : report["plans"]) plan.erase("total_us");
  return report.dump();
}

TEST_F(FlyTest, TheSameSeedGivesTheSameReportAndAnotherOneDoesNot) {
  const Words windy{"--wind", "1,1,0", "--gust", "2", "--fault", "loss@12", "--seed"};
  const auto with_seed = [&](const char* seed) {
    Words words = windy;
    words.emplace_back(seed);
    return timeless(fly(words));
  };
  const std::string first = with_seed("3");
  EXPECT_EQ(first, with_seed("3"));
  EXPECT_NE(first, with_seed("4"));
}

struct FaultCase {
  const char* fault;
  bool noticed;
  double latest;         // [s] of the reaction
  const char* reaction;  // part of its text
  std::set<std::string> ends;
};

TEST_F(FlyTest, EveryFaultEndsArrivedHoldingOrYieldedWithItsReason) {
  const std::vector<FaultCase> cases{
      {"cut@14", true, 0.25, "odometry too old", {"yielded"}},
      {"corrupt@14", false, 0, "", {"arrived"}},
      {"loss@14", false, 0, "", {"arrived"}},
      {"stall@14", true, 0.25, "odometry too old", {"arrived"}},
      {"starve@14", true, 1.1, "", {"yielded"}},
      {"odometry-stale@14", true, 0.25, "odometry too old", {"arrived"}},
      {"odometry-nan@14", true, 0.25, "impossible numbers", {"arrived"}},
      {"position-jump@14", true, 0.05, "position jumped", {"holding"}},
      {"restart@14", true, 0.25, "odometry too old", {"yielded"}},
      {"pilot@14", true, 0.05, "mode was changed", {"yielded"}},
      {"clock-jump@14", false, 0, "", {"arrived"}},
      {"sleep@14", true, 0.55, "held up", {"arrived"}},
      {"clock-step@14", true, 0.02, "clock jumped", {"arrived"}},
      {"map-replaced@14", true, 0.02, "map was replaced", {"arrived"}},
      {"storage-full@14", true, 0.02, "no room left to log", {"arrived"}},
  };
  for (const FaultCase& test : cases) {
    Words words = flight({"--fault", test.fault, "--json", path("flight.json"), "--log", path("flight.ulg")});
    const Outcome run = swiftlet(words);
    EXPECT_EQ(replay().status, 0) << test.fault;
    const Json report = Json::parse(read_text(path("flight.json")));
    const bool arrived = report["status"] == "arrived";
    const std::string end = arrived ? "arrived" : report["state"].get<std::string>();
    EXPECT_EQ(run.status, arrived ? 0 : 1) << test.fault;
    EXPECT_TRUE(test.ends.count(end) == 1) << test.fault << " ends " << end << ": " << report["status"];
    EXPECT_EQ(arrived, !report.contains("reason")) << test.fault;
    EXPECT_EQ(report["setpoints"]["stale"], 0) << test.fault;
    EXPECT_EQ(report["setpoints"]["repeated"], 0) << test.fault;
    EXPECT_GT(report["flown_clearance"], report["margins"]["vehicle_radius"]) << test.fault;
    EXPECT_EQ(report["state"], test.ends.count("yielded") == 1 ? "yielded" : "holding") << test.fault;
    ASSERT_EQ(report["faults"].size(), 1) << test.fault;
    const Json& answer = report["faults"][0];
    if (!test.noticed) continue;  // flown through; a brake for another reason is none of its business
    ASSERT_FALSE(answer["after"].is_null()) << test.fault;
    EXPECT_LE(answer["after"], test.latest) << test.fault;
    EXPECT_NE(answer["what"].get<std::string>().find(test.reaction), std::string::npos) << test.fault << answer;
  }
}

TEST_F(FlyTest, ATouchHasATime) {
  int touches = 0;
  for (int at = 14; at < 19; ++at) {  // it falls, once onto the table
    const Json report = fly({"--setpoint", "rates", "--fault", "restart@" + std::to_string(at)}, 1);
    const bool touched = report["flown_clearance"] <= report["margins"]["vehicle_radius"];
    ASSERT_EQ(report["touched_at"].is_null(), !touched);
    if (!touched) continue;
    ++touches;
    EXPECT_GT(report["touched_at"], at);
    EXPECT_LT(report["touched_at"], at + 2);
  }
  EXPECT_GT(touches, 0);
  EXPECT_LT(touches, 5);
}

TEST_F(FlyTest, FliesOverAPseudoTerminalInRealTime) {
#ifndef NDEBUG
  GTEST_SKIP() << "25 s of the wall's clock: once is enough";
#endif
  const Outcome run = swiftlet(
      {"fly", path("room.swm"), "--start", "0.48,0.48,0.8", "--goal", "1,2.6,1.2", "--json", path("flight.json")});
  const Json report = Json::parse(read_text(path("flight.json")));
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(report["status"], "arrived");
  EXPECT_FALSE(report["request"]["in_process"]);
  EXPECT_EQ(report["setpoints"]["stale"], 0);
  EXPECT_GT(report["setpoints"]["count"], 800);  // jitter is reported; a loaded machine is no place to bound it
  EXPECT_LT(report["link"]["load_in"], 0.3);
  EXPECT_LT(report["link"]["load_out"], 0.3);
}

// -------------------------------------------------------------------------------------------------------- the log

TEST_F(FlyTest, ALogReplaysEqual) {
  (void)fly({"--log", path("flight.ulg"), "--wind", "1,1,0", "--gust", "2", "--link-delay", "0.02", "--fault",
             "loss@12", "--fault", "sleep@16", "--setpoint", "rates"});
  EXPECT_TRUE(refused(replay(), 0, {"replays equal", "steps", "plans", "messages"}));
  std::string log = read_text(path("flight.ulg"));
  log.resize(log.size() / 2);
  write_text(path("flight.ulg"), log);
  EXPECT_TRUE(refused(replay(), 0, {"replays equal"}));  // as far as it reaches
}

TEST_F(FlyTest, AnotherByteOrSettingIsADifferenceAndAnotherMapIsRefused) {
  (void)fly({"--log", path("flight.ulg")});
  const std::string log = read_text(path("flight.ulg"));
  const auto with = [&](std::size_t at, std::string_view bytes) {
    std::string changed = log;
    changed.replace(at, bytes.size(), bytes);
    write_text(path("flight.ulg"), changed);
    return replay();
  };
  // A byte of an ATTITUDE_QUATERNION that was received in flight: its frame's checksum is then wrong.
  const std::size_t frame = log.find(std::string("\1\1\x1f\0\0", 5), log.size() / 2);  // sender and number
  ASSERT_NE(frame, std::string::npos);
  EXPECT_TRUE(refused(with(frame + 6, std::string(1, static_cast<char>(~log[frame + 6]))), 1,
                      {"flight.ulg", "differs at ", " s, "}));
  const std::size_t speed = log.find("\"vmax_m_s\": 1.0");
  ASSERT_NE(speed, std::string::npos);
  EXPECT_TRUE(refused(with(speed, "\"vmax_m_s\": 0.9"), 1, {"differs at "}));
  EXPECT_TRUE(refused(with(log.find("\"system_id\""), "\"system_ia\""), 3, {"settings", "system_ia"}));
  EXPECT_TRUE(refused(with(0, "uLog"), 3, {"flight.ulg", "no flight log"}));
  constexpr std::size_t kMoreThanAMessage = 200;  // so a header is among them
  EXPECT_TRUE(refused(with(log.size() / 2, std::string(kMoreThanAMessage, '\xff')), 3, {"flight.ulg", "damaged"}));
  write_text(path("flight.ulg"), log);
  ASSERT_EQ(swiftlet({"map", "build", path("room.bt"), "-o", path("room.swm"), "--radius", "0.29"}).status, 0);
  EXPECT_TRUE(refused(replay(), 3, {"flight.ulg", "map with the CRC-32"}));
  EXPECT_TRUE(refused(swiftlet({"replay", path("none.ulg"), "--map", path("room.swm")}), 3, {"none.ulg"}));
}

TEST_F(FlyTest, ALogKnowsWhereItsMapIs) {
  Words words = flight({"--log", path("flight.ulg"), "--fault", "map-replaced@18"});
  words[1] = std::filesystem::relative(words[1]).string();
  ASSERT_EQ(swiftlet(words).status, 0);
  const Words alone{"replay", path("flight.ulg")};
  EXPECT_TRUE(refused(swiftlet(alone), 0, {"replays equal"}));
  std::filesystem::rename(path("room.swm"), path("moved.swm"));
  EXPECT_TRUE(refused(swiftlet(alone), 3, {"flight.ulg", "/room.swm", "cannot be read", "--map"}));
  EXPECT_TRUE(refused(swiftlet({"replay", path("flight.ulg"), "--map", path("moved.swm")}), 0, {"replays equal"}));
  ASSERT_EQ(swiftlet({"map", "build", path("room.bt"), "-o", path("room.swm"), "--radius", "0.29"}).status, 0);
  EXPECT_TRUE(refused(swiftlet(alone), 3, {"flight.ulg", "/room.swm", "CRC-32", "--map"}));
  write_text(path("room.swm"), "no map");
  EXPECT_TRUE(refused(swiftlet(alone), 3, {"flight.ulg", "/room.swm", "--map"}));
  std::string log = read_text(path("flight.ulg"));
  const std::size_t key = log.find("swiftlet_map_file_");
  ASSERT_NE(key, std::string::npos);
  log[key] = 'S';
  write_text(path("flight.ulg"), log);
  EXPECT_TRUE(refused(swiftlet(alone), 3, {"flight.ulg", "does not say where", "--map"}));
}

TEST_F(FlyTest, ThePagesTitleSaysWhichFlightItWasAndHowItEnded) {
  (void)fly({"--report", path("flight.html")});
  EXPECT_NE(read_text(path("flight.html"))
                .find("<title>room: flight to 3.360, 0.800, 0.800 by way of 2 goals: arrived, landed</title>"),
            std::string::npos);
  (void)fly({"--report", path("flight.html"), "--fault", "pilot@18"}, 1);
  EXPECT_NE(read_text(path("flight.html"))
                .find("<title>room: flight to 3.360, 0.800, 0.800 by way of 2 goals: pilot took over</title>"),
            std::string::npos);
}

TEST_F(FlyTest, AGoalThatIsRefusedIsTheReason) {
  write_text(path("config.json"), R"({"format": "swiftlet-config/1", "margins": {"vehicle_radius_m": 0.1,
    "map_error_m": 0.03, "heading_accuracy_rad": 0.01}, "supervisor": {"setpoint_age_yield_s": 2}})");
  const Json report = fly({"--config", path("config.json")}, 1);
  EXPECT_EQ(report["status"], "stopped");
  EXPECT_NE(report["reason"].get<std::string>().find("the heading's margin allows"), std::string::npos)
      << report["reason"];  // not the warning of COM_OF_LOSS_T, which comes later
}

TEST_F(FlyTest, WithoutRoomToLogNoFlightStarts) {
  const Json report = fly({"--fault", "storage-full@1"}, 1);
  EXPECT_EQ(report["status"], "storage_full");
  EXPECT_EQ(report["state"], "idle");
}

TEST_F(FlyTest, TakesTheCompanionsSettingsFromAFile) {
  write_text(path("config.json"), R"({"format": "swiftlet-config/1", "margins": {"vehicle_radius_m": 0.3}})");
  const Json report = fly({"--config", path("config.json")}, 1);
  EXPECT_EQ(report["status"], "margins_too_small");
  EXPECT_TRUE(report["tracking"]["rms"].is_null());
}

// ------------------------------------------------------------------------------------------------------- bad input

TEST_F(FlyTest, EndsThatCannotBeFlownToAreRefusedBeforeTheFlight) {
  write_two_rooms(path("two.bt"));
  ASSERT_EQ(swiftlet({"map", "build", path("two.bt"), "-o", path("two.swm"), "--radius", "0.15"}).status, 0);
  const auto refuses = [&](const char* start, const char* goal, const Words& words) {
    const Words command{"fly",          path("two.swm"), "--start",          start, "--goal", kLeftToo, "--goal", goal,
                        "--in-process", "--json",        path("flight.json")};
    const testing::AssertionResult result = refused(swiftlet(command), 1, words);
    if (!result) return result;
    const Json report = Json::parse(read_text(path("flight.json")));
    if (report["status"] != words[0]) return testing::AssertionFailure() << report["status"];
    if (!report["tracking"]["rms"].is_null()) return testing::AssertionFailure() << "it flew";
    return testing::AssertionSuccess();
  };
  EXPECT_TRUE(refuses(kInPillar, kLeft, {"start_not_free", "occupied", "nearest free point"}));
  EXPECT_TRUE(refuses(kLeft, kInHole, {"goal_not_free", "goal 2", "unknown", "nearest free point"}));
  EXPECT_TRUE(refuses(kLeft, kOutside, {"goal_not_free", "goal 2", "outside"}));
  EXPECT_TRUE(refuses(kLeft, kRight, {"no_path", "component 0", "component 1"}));
}

TEST_F(FlyTest, CommandLinesThatAreNoFlightAreUsageErrors) {
  const Words before = files();
  const auto refuses = [&](const Words& extra, const Words& words) {
    return refused(swiftlet(flight(extra)), 2, words);
  };
  EXPECT_TRUE(refused(swiftlet({"fly"}), 2, {"map"}));
  EXPECT_TRUE(refused(swiftlet({"fly", path("room.swm"), "--start", "1,1,1"}), 2, {"--goal"}));
  EXPECT_TRUE(refused(swiftlet({"fly", path("room.swm"), "--goal", "1,1,1"}), 2, {"--start"}));
  for (const char* bad : {"nan,0,0", "0,0", "0,0,0,0", "a,b,c", "", "0,,0", "1e999,0,0", "1e9,0,0"}) {
    EXPECT_TRUE(refuses({"--goal", bad}, {"--goal"})) << bad;
  }
  for (const char* bad : {"north", "1,2", "nan", "", "1000", "0,0,inf"}) {
    EXPECT_TRUE(refuses({"--wind", bad}, {"--wind"})) << bad;
  }
  for (const char* bad : {"", "cut", "@5", "cut@", "cut@-1", "cut@nan", "cut@soon", "meteor@5", "sleep@1+", "sleep@1+x",
                          "position-jump@5+1", "clock-step@5+1", "map-replaced@5+1", "storage-full@"}) {
    EXPECT_TRUE(refuses({"--fault", bad}, {"--fault"})) << bad;
  }
  EXPECT_TRUE(refuses({"--setpoint", "thrust"}, {"--setpoint"}));
  for (const char* bad : {"0", "-1", "nan", "1e9", "", "fast"}) {
    EXPECT_TRUE(refuses({"--vmax", bad}, {"--vmax"})) << bad;
    EXPECT_TRUE(refuses({"--amax", bad}, {"--amax"})) << bad;
    EXPECT_TRUE(refuses({"--jmax", bad}, {"--jmax"})) << bad;
  }
  for (const char* bad : {"-1", "nan", "1e9", ""}) {
    EXPECT_TRUE(refuses({"--gust", bad}, {"--gust"})) << bad;
    EXPECT_TRUE(refuses({"--link-delay", bad}, {"--link-delay"})) << bad;
    EXPECT_TRUE(refuses({"--heading-noise", bad}, {"--heading-noise"})) << bad;
  }
  for (const char* bad : {"-1", "1.5", "many", "99999999999999999999"}) {
    EXPECT_TRUE(refuses({"--seed", bad}, {"--seed"})) << bad;
  }
  EXPECT_TRUE(refuses({"--yaw", "400"}, {"--yaw"}));
  EXPECT_TRUE(refuses({"--json", path("room.swm")}, {"input"}));
  EXPECT_TRUE(refuses({"--json", path("a"), "--report", path("a")}, {"a"}));
  EXPECT_EQ(files(), before);
}

TEST_F(FlyTest, FilesThatCannotBeReadOrWrittenAreNamed) {
  const auto refuses = [&](const Words& extra, const Words& words) {
    return refused(swiftlet(flight(extra)), 3, words);
  };
  const Words none{"fly", path("none.swm"), "--start", "0,0,0", "--goal", "1,1,1", "--in-process"};
  EXPECT_TRUE(refused(swiftlet(none), 3, {"none.swm"}));
  EXPECT_TRUE(refuses({"--vehicle", path("none.json")}, {"none.json"}));
  write_text(path("v.json"), R"({"format":"swiftlet-vehicle/1"})");
  EXPECT_TRUE(refuses({"--vehicle", path("v.json")}, {"v.json", "mass_kg"}));
  EXPECT_TRUE(refuses({"--config", path("none.json")}, {"none.json"}));
  write_text(path("c.json"), R"({"format":"swiftlet-config/1","speed":3})");
  EXPECT_TRUE(refuses({"--config", path("c.json")}, {"c.json", "speed"}));
  for (const char* option : {"--json", "--report", "--log"}) {
    EXPECT_TRUE(refuses({option, path("no/folder/f")}, {"no/folder"})) << option;
    EXPECT_TRUE(refuses({option, path(".")}, {"folder"})) << option;
  }
}

}  // namespace
}  // namespace swiftlet::tools
