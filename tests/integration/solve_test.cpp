// `swiftlet solve`: the contract of trajectory generation alone, its refusals, and the published reference cases.
#include <algorithm>
#include <cmath>
#include <string>

#include "program.hpp"

namespace swiftlet::tools {
namespace {

/// Two boxes side by side, a thin gate between them, from rest to rest, 2 s each.
Json two_boxes() {
  const Json rest = Json::array({0, 0, 0});
  return {{"format", "swiftlet-case/1"},
          {"name", "two boxes"},
          {"boxes", {{0, 0, 0, 1, 1, 1}, {1, 0, 0, 2, 1, 1}}},
          {"gates", {{1, 0, 0, 1, 1, 1}}},
          {"durations", {2, 2}},
          {"start", {{"position", {0.5, 0.5, 0.5}}, {"velocity", rest}, {"acceleration", rest}}},
          {"goal", {{"position", {1.5, 0.5, 0.5}}, {"velocity", rest}, {"acceleration", rest}}},
          {"vmax", 1},
          {"amax", 1},
          {"margins", {{"position", 0}, {"velocity", 0}, {"acceleration", 0}}}};
}

class Solve : public FolderTest {
 protected:
  Outcome solve(const Json& problem) {
    write_text(path("case.json"), problem.dump());
    return swiftlet({"solve", path("case.json"), "--json", path("answer.json")});
  }
  Json answer() { return Json::parse(read_text(path("answer.json"))); }
};

TEST_F(Solve, AnswersWithEveryFieldOfThePlanFormat) {
  Json problem = two_boxes();
  problem["expected"] = {{"ignored", true}};
  ASSERT_EQ(solve(problem).status, 0);
  const Json plan = answer();
  EXPECT_EQ(plan["format"], "swiftlet-plan/1");
  EXPECT_EQ(plan["name"], "two boxes");
  EXPECT_EQ(plan["status"], "optimal");
  EXPECT_EQ(plan["corridor"], problem["boxes"]);
  EXPECT_EQ(plan["gates"], problem["gates"]);
  EXPECT_EQ(plan["request"]["start"], problem["start"]);
  EXPECT_EQ(plan["request"]["norm"], "axis");
  EXPECT_FALSE(plan["request"].contains("corridor"));
  EXPECT_FALSE(plan["request"].contains("relax"));
  EXPECT_FALSE(plan.contains("map"));
  EXPECT_FALSE(plan.contains("expected"));
  EXPECT_FALSE(plan.contains("blocking"));
  EXPECT_FALSE(plan.contains("fallback_reason"));
  ASSERT_EQ(plan["segments"].size(), 2U);
  EXPECT_EQ(plan["segments"][0]["x"].size(), 6U);
  EXPECT_EQ(plan["duration"], 4.0);
  // Over 1 m in 4 s the free optimum is one rest-to-rest quintic: 720 d^2 / T^5.
  EXPECT_NEAR(plan["jerk_cost"][0].get<double>(), 720.0 / 1024.0, 1e-6);
  EXPECT_NEAR(plan["length"].get<double>(), 1.0, 1e-4);
  EXPECT_EQ(plan["qp"]["vmax"], Json::array({1, 1, 1}));
  EXPECT_TRUE(plan["certificate"]["pass"].get<bool>());
  EXPECT_NEAR(plan["certificate"]["max_speed_norm"].get<double>(), 1.875 / 4, 1e-3);
  EXPECT_EQ(plan["stats"]["time_scale"], 1.0);
}

TEST_F(Solve, TakesNullAsNoLimit) {
  Json problem = two_boxes();
  problem["vmax"] = nullptr;
  problem["amax"] = nullptr;
  problem["durations"] = {0.1, 0.1};
  ASSERT_EQ(solve(problem).status, 0);
  EXPECT_TRUE(answer()["request"]["vmax"].is_null());
  EXPECT_EQ(answer()["qp"]["amax"], Json::array({nullptr, nullptr, nullptr}));
  EXPECT_GT(answer()["certificate"]["max_speed"][0].get<double>(), 5.0);
}

TEST_F(Solve, SaysWhichBoundIsInTheWayOfAnInfeasibleCase) {
  Json problem = two_boxes();
  problem["durations"] = {0.5, 0.5};  // 1.875 m/s would be needed
  EXPECT_TRUE(refused(solve(problem), 1, {"infeasible", "axis x"}));
  EXPECT_EQ(answer()["status"], "infeasible");
  EXPECT_EQ(answer()["blocking"]["axis"], "x");
  EXPECT_GT(answer()["blocking"]["missing"].get<double>(), 0.0);
  EXPECT_GT(answer()["blocking"]["stretch"].get<double>(), 1.5);
  EXPECT_FALSE(answer().contains("segments"));
  EXPECT_FALSE(answer().contains("certificate"));
}

TEST_F(Solve, CallsNumbersThatContradictEachOtherABadRequest) {
  const auto bad_request = [&](const Json& problem, const std::string& word) {
    const testing::AssertionResult result = refused(solve(problem), 1, {"bad_request", word});
    if (answer()["status"] != "bad_request") return testing::AssertionFailure() << answer().dump();
    return result;
  };
  Json problem = two_boxes();
  problem["boxes"][1] = {2, 0, 0, 1, 1, 1};
  EXPECT_TRUE(bad_request(problem, "box 1 has lo > hi"));
  problem = two_boxes();
  problem["gates"][0] = {1, 0, 0, 1.5, 1, 1};
  EXPECT_TRUE(bad_request(problem, "gate 0 reaches out of box 0"));
  problem = two_boxes();
  problem["durations"][1] = 0;
  EXPECT_TRUE(bad_request(problem, "duration 1"));
  problem = two_boxes();
  problem["durations"] = {1, 1, 1};
  EXPECT_TRUE(bad_request(problem, "2 boxes"));
  problem = two_boxes();
  problem["gates"] = Json::array();
  EXPECT_TRUE(bad_request(problem, "1 gates"));
  problem = two_boxes();
  problem["boxes"] = Json::array();
  EXPECT_TRUE(bad_request(problem, "no box"));
  problem = two_boxes();
  problem["vmax"] = -1;
  EXPECT_TRUE(bad_request(problem, "vmax"));
  problem = two_boxes();
  problem["margins"]["velocity"] = -0.1;
  EXPECT_TRUE(bad_request(problem, "margins.velocity"));
  problem = two_boxes();
  problem["start"]["position"] = {0, 0};
  EXPECT_TRUE(bad_request(problem, "start.position"));
}

TEST_F(Solve, RefusesFilesThatAreNoCaseNamingFileAndFault) {
  const auto refuses = [&](const std::string& text, const std::vector<std::string>& words) {
    write_text(path("case.json"), text);
    const Outcome run = swiftlet({"solve", path("case.json"), "--json", path("answer.json")});
    if (std::filesystem::exists(path("answer.json"))) return testing::AssertionFailure() << "an answer was written";
    std::vector<std::string> all = words;
    all.push_back("case.json");
    return refused(run, 3, all);
  };
  EXPECT_TRUE(refuses("", {"empty"}));
  EXPECT_TRUE(refuses("{\n\"format\": \n", {":3:", "JSON"}));
  EXPECT_TRUE(refuses("\x01\x02\xff", {"JSON"}));
  EXPECT_TRUE(refuses(std::string(100000, '['), {"JSON"}));
  EXPECT_TRUE(refuses("[]", {"object"}));
  EXPECT_TRUE(refuses("{}", {"'format' is missing"}));
  EXPECT_TRUE(refuses("{\"a\": 1e999}", {"out of range"}));
  Json problem = two_boxes();
  problem["format"] = "swiftlet-case/2";
  EXPECT_TRUE(refuses(problem.dump(), {"format"}));
  problem = two_boxes();
  problem.erase("durations");
  EXPECT_TRUE(refuses(problem.dump(), {"'durations' is missing"}));
  problem = two_boxes();
  problem["durations"][0] = "one";
  EXPECT_TRUE(refuses(problem.dump(), {"durations", "number"}));
  problem = two_boxes();
  problem["vmax"] = true;
  EXPECT_TRUE(refuses(problem.dump(), {"'vmax'", "number"}));
}

TEST_F(Solve, ABatchGoesOnAfterACaseWithoutAnswer) {
  Json bad = two_boxes();
  bad["durations"][0] = -1;
  Json tight = two_boxes();
  tight["durations"] = {0.1, 0.1};
  write_text(path("cases.jsonl"), bad.dump() + "\n\n" + tight.dump() + "\r\n" + two_boxes().dump());
  const Outcome run = swiftlet({"solve", "--cases", path("cases.jsonl"), "--jsonl", path("out.jsonl")});
  EXPECT_EQ(run.status, 0) << run.err;
  const std::vector<Json> answers = read_lines(path("out.jsonl"));
  ASSERT_EQ(answers.size(), 3U);
  EXPECT_EQ(answers[0]["status"], "bad_request");
  EXPECT_EQ(answers[1]["status"], "infeasible");
  EXPECT_EQ(answers[2]["status"], "optimal");
}

TEST_F(Solve, ABatchWritesEveryLineEvenWhenACaseCannotBeAnswered) {
  Json far = two_boxes();  // where a double's digits are coarser than the certificate's tolerance
  far["name"] = "far";
  for (const char* key : {"boxes", "gates"}) {
    for (Json& box : far[key]) {
      box[0] = box[0].get<double>() + 1e12;
      box[3] = box[3].get<double>() + 1e12;
    }
  }
  for (const char* key : {"start", "goal"}) {
    Json& x = far[key]["position"][0];
    x = x.get<double>() + 1e12;
  }
  write_text(path("cases.jsonl"), far.dump() + "\n" + two_boxes().dump() + "\n");
  EXPECT_TRUE(refused(swiftlet({"solve", "--cases", path("cases.jsonl"), "--jsonl", path("out.jsonl")}), 4,
                      {"'far'", "please report"}));
  const std::vector<Json> answers = read_lines(path("out.jsonl"));
  ASSERT_EQ(answers.size(), 2U);
  EXPECT_EQ(answers[0]["name"], "far");
  EXPECT_TRUE(answers[0]["status"].is_null());
  EXPECT_FALSE(answers[0].contains("segments"));
  EXPECT_EQ(answers[1]["status"], "optimal");
}

TEST_F(Solve, ACaseTooStiffForTheSolverStillGetsACertifiedAnswer) {
  Json stiff = two_boxes();  // accelerations of 1e8 m/s^2, whose digits the solver's tolerance does not have
  stiff["boxes"] = {{0, -62, -62, 46, 62, 62}, {46, -62, -62, 85, 62, 62}};
  stiff["gates"] = {{46, 52, -31, 46, 55, 31}};
  stiff["durations"] = {0.00078, 0.04};
  stiff["start"]["position"] = {0.06, 0, 0};
  stiff["goal"]["position"] = {84.9, 0, 0};
  stiff["vmax"] = nullptr;
  stiff["amax"] = nullptr;
  ASSERT_EQ(solve(stiff).status, 0);
  EXPECT_TRUE(answer()["status"] == "optimal" || answer()["status"] == "fallback") << answer()["status"];
  EXPECT_EQ(answer().contains("fallback_reason"), answer()["status"] == "fallback");
  EXPECT_EQ(answer()["certificate"]["pass"], true);
  EXPECT_EQ(answer()["segments"][0]["duration"], 0.00078);
}

TEST_F(Solve, ABatchWithABrokenLineWritesNothingAndNamesTheLine) {
  write_text(path("cases.jsonl"), two_boxes().dump() + "\n{broken\n");
  EXPECT_TRUE(refused(swiftlet({"solve", "--cases", path("cases.jsonl"), "--jsonl", path("out.jsonl")}), 3,
                      {"cases.jsonl:2:", "JSON"}));
  EXPECT_EQ(files(), std::vector<std::string>{"cases.jsonl"});
}

TEST_F(Solve, MoreBoxesThanTheBoardHoldsAreRefusedByName) {
  Json problem = two_boxes();
  problem["boxes"] = Json::array();
  problem["gates"] = Json::array();
  problem["durations"] = Json::array();
  for (int i = 0; i < 513; ++i) {
    problem["boxes"].push_back({0, 0, 0, 2, 2, 2});
    problem["durations"].push_back(1);
    if (i > 0) problem["gates"].push_back({0, 0, 0, 2, 2, 2});
  }
  EXPECT_TRUE(refused(solve(problem), 1, {"corridor_capacity", "513", "512"}));
}

TEST_F(Solve, SolvesEveryReferenceCaseToItsPublishedOptimum) {
  const std::filesystem::path cases = shared_folder() / "cases/cases.jsonl";
  if (!std::filesystem::exists(cases)) GTEST_SKIP() << "the reference cases are not there: ../shared/cases/cases.jsonl";
  const Outcome run = swiftlet({"solve", "--cases", cases, "--jsonl", path("out.jsonl")});
  ASSERT_EQ(run.status, 0) << run.err;
  const std::vector<Json> problems = read_lines(cases);
  const std::vector<Json> answers = read_lines(path("out.jsonl"));
  ASSERT_EQ(answers.size(), problems.size());
  for (std::size_t i = 0; i < problems.size(); ++i) {
    const Json& expected = problems[i]["expected"];
    const bool feasible = std::count(expected["status"].begin(), expected["status"].end(), "optimal") == 3;
    EXPECT_EQ(answers[i]["name"], problems[i]["name"]);
    EXPECT_EQ(answers[i]["status"], feasible ? "optimal" : "infeasible") << problems[i]["name"];
    if (answers[i]["status"] != "optimal") continue;
    EXPECT_TRUE(answers[i]["certificate"]["pass"].get<bool>()) << problems[i]["name"];
    EXPECT_LE(answers[i]["certificate"]["tolerance"].get<double>(), 1e-6);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double optimum = expected["cost"][axis].get<double>();
      if (optimum < 0) continue;  // not verified by the reference
      EXPECT_NEAR(answers[i]["jerk_cost"][axis].get<double>(), optimum, 1e-5 * std::max(optimum, 1e-3))
          << problems[i]["name"] << " axis " << axis;
    }
  }
}

}  // namespace
}  // namespace swiftlet::tools
