// Every query of the published maps, judged by an independent checker against the source OctoMap. Needs the folder
// ../shared (or SWIFTLET_SHARED); skipped where it is absent.
#include <algorithm>
#include <iostream>
#include <map>
#include <sstream>
#include <string>

#include "program.hpp"

namespace swiftlet::tools {
namespace {

struct ReferenceMap {
  const char* name;
  const char* file;
};

// GoogleTest prints it into the case's name.
std::ostream& operator<<(std::ostream& out, const ReferenceMap& map) { return out << map.name; }

class ReferencePlans : public FolderTest, public testing::WithParamInterface<ReferenceMap> {
 protected:
  void SetUp() override {
    folder_ = shared_folder() / "maps" / GetParam().name;
    if (!std::filesystem::exists(folder_)) GTEST_SKIP() << "the reference maps are not there: ../shared/maps";
  }

  void build(const std::string& policy) {
    const Outcome run = swiftlet(
        {"map", "build", folder_ / GetParam().file, "-o", path("map.swm"), "--radius", "0.30", "--unknown", policy});
    ASSERT_EQ(run.status, 0) << run.err;
  }

  std::vector<Json> plan(const std::string& queries, const std::string& limit) {
    const Outcome run = swiftlet({"plan", path("map.swm"), "--queries", folder_ / queries, "--vmax", limit, "--amax",
                                  limit, "--jsonl", path("plans.jsonl")});
    EXPECT_EQ(run.status, 0) << run.err;
    return read_lines(path("plans.jsonl"));
  }

  /// Every query gets a trajectory in which the checker finds no defect.
  void expect_flawless(const std::string& queries, const std::string& policy) {
    build(policy);
    for (const std::string limit : {"1", "3"}) {
      for (const Json& json : plan(queries, limit)) {
        EXPECT_TRUE(json.contains("segments")) << queries << " " << limit << ": " << json["status"] << json["request"];
      }
#ifdef SWIFTLET_CHECK_PLAN
      const Outcome check = run_program(
          SWIFTLET_CHECK_PLAN, {folder_ / GetParam().file, path("plans.jsonl"), "--radius", "0.30", "--unknown", policy,
                                "--queries", folder_ / queries, "--vmax", limit, "--amax", limit});
      EXPECT_EQ(check.status, 0) << check.out;
      std::cout << GetParam().name << ", " << queries << " at " << limit << ": " << check.out;
#endif
    }
  }

  std::filesystem::path folder_;
};

TEST_P(ReferencePlans, EveryQueryIsFlownWithoutADefectWhereUnknownSpaceIsAvoided) {
  expect_flawless("queries.csv", "avoid");
}

TEST_P(ReferencePlans, EveryQueryIsFlownWithoutADefectWhereUnknownSpaceIsAnObstacle) {
  expect_flawless("queries_occupied.csv", "occupied");
}

TEST_P(ReferencePlans, EveryQueryThatMustFailGetsTheRightRefusal) {
  const std::map<std::string, std::string> expected{{"start_occupied", "start_not_free"},
                                                    {"start_unknown", "start_not_free"},
                                                    {"goal_within_half_radius_of_obstacle", "goal_not_free"},
                                                    {"different_free_component", "no_path"}};
  build("avoid");
  const std::vector<Json> plans = plan("queries_negative.csv", "1");
  std::istringstream rows(read_text(folder_ / "queries_negative.csv"));
  std::string row;
  std::getline(rows, row);
  for (const Json& json : plans) {
    ASSERT_TRUE(std::getline(rows, row));
    const std::string reason = row.substr(row.rfind(',') + 1);
    ASSERT_TRUE(expected.contains(reason)) << row;
    EXPECT_EQ(json["status"], expected.at(reason)) << row;
  }
  EXPECT_FALSE(std::getline(rows, row)) << "fewer answers than rows";
}

INSTANTIATE_TEST_SUITE_P(Maps, ReferencePlans,
                         testing::Values(ReferenceMap{"geb079", "geb079.bt"}, ReferenceMap{"lounge", "lounge.bt"},
                                         ReferenceMap{"power_plant", "power_plant.bt"},
                                         ReferenceMap{"rgbd_room", "rgbd_room.ot"}),
                         [](const auto& param) { return std::string(param.param.name); });

}  // namespace
}  // namespace swiftlet::tools
