// Every kind of bad input: the contract's exit status, one line on standard error that says what and where, and no
// output left behind.
#include <cstdint>
#include <cstring>
#include <string>

#include "program.hpp"
#include "two_rooms.hpp"

namespace swiftlet::tools {
namespace {

using Words = std::vector<std::string>;

class BadInput : public FolderTest {
 protected:
  /// Refused, and the folder holds what it held before.
  testing::AssertionResult refuses(const std::vector<std::string>& arguments, int status, const Words& words) {
    const std::vector<std::string> before = files();
    const testing::AssertionResult result = refused(swiftlet(arguments), status, words);
    if (files() != before) return testing::AssertionFailure() << "the files in the folder changed";
    return result;
  }
};

// ------------------------------------------------------------------------------------------------------- map build

class BadOctoMap : public BadInput {
 protected:
  testing::AssertionResult refuses_map(const std::string& name, const std::string& content, const Words& words) {
    write_text(path(name), content);
    Words all = words;
    all.push_back(name);
    return refuses({"map", "build", path(name), "-o", path("out.swm"), "--radius", "0.15"}, 3, all);
  }
  std::string good_bt() {
    write_two_rooms(path("good.bt"));
    return read_text(path("good.bt"));
  }
};

TEST_F(BadOctoMap, MissingEmptyAndTruncatedFilesAreRefusedByName) {
  EXPECT_TRUE(refuses({"map", "build", path("none.bt"), "-o", path("out.swm"), "--radius", "0.3"}, 3, {"none.bt"}));
  EXPECT_TRUE(refuses({"map", "build", path("."), "-o", path("out.swm"), "--radius", "0.3"}, 3, {"folder"}));
  EXPECT_TRUE(refuses_map("empty.bt", "", {}));
  EXPECT_TRUE(refuses_map("empty.ot", "", {}));
  const std::string good = good_bt();
  for (std::size_t size = 1; size < good.size(); size += good.size() / 40 + 1) {
    EXPECT_TRUE(refuses_map("short.bt", good.substr(0, size), {})) << size;
  }
}

TEST_F(BadOctoMap, OtherKindsOfFilesAreRefusedByName) {
  EXPECT_TRUE(refuses_map("text.bt", "This is no map.\n", {}));
  EXPECT_TRUE(refuses_map("map.pcd", "# .PCD v0.7 - Point Cloud Data file format\n", {}));
  EXPECT_TRUE(refuses_map("stamped.ot", "# Octomap OcTree file\nid OcTreeStamped\nsize 1\nres 0.1\ndata\n\1\1\1\1\1",
                          {"OcTreeStamped"}));
  EXPECT_TRUE(refuses_map("counting.ot", "# Octomap OcTree file\nid CountingOcTree\nsize 1\nres 0.1\ndata\n\1\1\1\1\1",
                          {"CountingOcTree"}));
  EXPECT_TRUE(refuses_map("zip.bt", std::string("PK\3\4\0\0\0\0\0\0", 10), {}));
}

TEST_F(BadOctoMap, HostileHeadersAreRefused) {
  const std::string head = "# Octomap OcTree binary file\nid OcTree\n";
  const std::string node(16, '\x55');
  EXPECT_TRUE(refuses_map("res0.bt", head + "size 1\nres 0\ndata\n" + node, {}));
  EXPECT_TRUE(refuses_map("negative.bt", head + "size 1\nres -0.1\ndata\n" + node, {}));
  EXPECT_TRUE(refuses_map("nan.bt", head + "size 1\nres nan\ndata\n" + node, {}));
  EXPECT_TRUE(refuses_map("infinite.bt", head + "size 1\nres inf\ndata\n" + node, {}));
  EXPECT_TRUE(refuses_map("huge.bt", head + "size 18446744073709551615\nres 0.1\ndata\n" + node.substr(0, 1), {}));
  EXPECT_TRUE(refuses_map("no_data.bt", head + "size 1\nres 0.1\n", {}));
  EXPECT_TRUE(refuses_map("no_leaf.bt", head + "size 1\nres 0.1\ndata\n" + std::string(2, '\0'), {}));
  // Every node has eight inner children for ever: deeper than any octree.
  EXPECT_TRUE(
      refuses_map("deep.bt", head + "size 1\nres 0.1\ndata\n" + std::string(4096, '\xff'), {"16th level", "byte 91"}));
}

TEST_F(BadOctoMap, AMapTooLargeForTheBlobIsRefusedWithAdviceToCropIt) {
  octomap::OcTree tree(0.1);
  tree.updateNode(octomap::OcTreeKey(0, 32768, 32768), false);
  tree.updateNode(octomap::OcTreeKey(65535, 32768, 32768), false);
  tree.writeBinary(path("long.bt"));
  EXPECT_TRUE(refuses({"map", "build", path("long.bt"), "-o", path("out.swm"), "--radius", "0.15"}, 3,
                      {"long.bt", "--bounds"}));
}

TEST_F(BadOctoMap, NumbersOutOfRangeAreUsageErrors) {
  write_two_rooms(path("good.bt"));
  const auto build = [&](const std::vector<std::string>& extra) {
    std::vector<std::string> arguments{"map", "build", path("good.bt"), "-o", path("out.swm")};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    return arguments;
  };
  EXPECT_TRUE(refuses(build({}), 2, {"--radius"}));
  for (const char* radius : {"-0.1", "nan", "inf", "1e999", "1e9", "zero", "", "0.3m"}) {
    EXPECT_TRUE(refuses(build({"--radius", radius}), 2, {"--radius"})) << radius;
  }
  EXPECT_TRUE(refuses(build({"--radius", "0.3", "--unknown", "maybe"}), 2, {"--unknown", "maybe"}));
  EXPECT_TRUE(refuses(build({"--radius", "0.3", "--partition", "leaves"}), 2, {"--partition"}));
  EXPECT_TRUE(refuses(build({"--radius", "0.3", "--bounds", "0,0,0,1,1"}), 2, {"--bounds"}));
  EXPECT_TRUE(refuses(build({"--radius", "0.3", "--bounds", "0,0,0,1,1,nan"}), 2, {"--bounds"}));
  EXPECT_TRUE(refuses(build({"--radius", "0.3", "--bounds", "1,0,0,0,1,1"}), 2, {"--bounds"}));
  EXPECT_TRUE(refuses(build({"--radius", "0.3", "--bounds", "50,50,50,51,51,51"}), 2, {"--bounds", "good.bt"}));
  EXPECT_TRUE(refuses(build({"--radius", "7"}), 2, {"--radius", "good.bt"}));  // 70 voxels
  EXPECT_TRUE(refuses(build({"--radius", "0.3", "--frobnicate"}), 2, {"--frobnicate"}));
}

TEST_F(BadOctoMap, AnOutputThatCannotBeWrittenIsRefusedBeforeTheWork) {
  write_two_rooms(path("good.bt"));
  const auto build = [&](const std::string& out) {
    return std::vector<std::string>{"map", "build", path("good.bt"), "--radius", "0.15", "-o", out};
  };
  EXPECT_TRUE(refuses(build(path("no/such/folder/out.swm")), 3, {"no/such/folder"}));
  EXPECT_TRUE(refuses(build(path(".")), 3, {"folder"}));
  EXPECT_TRUE(refuses(build("/dev/full"), 3, {"/dev/full"}));
  EXPECT_TRUE(refuses(build(path("good.bt")), 2, {"input"}));
}

// ----------------------------------------------------------------------------------------------------- point clouds

TEST_F(BadInput, CloudsThatAreNoneOrTooLargeAndNumbersOutOfRangeAreRefused) {
  const auto import = [&](const std::string& cloud, const std::string& resolution) {
    return std::vector<std::string>{"map", "import", path(cloud), "--resolution", resolution, "-o", path("out.bt")};
  };
  write_text(path("good.xyz"), "0 0 0\n1 1 1\n");
  write_text(path("empty.xyz"), "");
  write_text(path("letters.xyz"), "0 0 0\none two three\n");
  write_text(path("wide.xyz"), "0 0 0\n1e6 0 0\n");
  write_text(path("short.ply"), "ply\nformat ascii 1.0\nelement vertex 2\n");
  write_text(path("cloud.las"), "LASF");
  EXPECT_TRUE(refuses(import("none.xyz", "0.1"), 3, {"none.xyz"}));
  EXPECT_TRUE(refuses(import("empty.xyz", "0.1"), 3, {"empty.xyz"}));
  EXPECT_TRUE(refuses(import("letters.xyz", "0.1"), 3, {"letters.xyz", "2"}));
  EXPECT_TRUE(refuses(import("wide.xyz", "0.1"), 3, {"wide.xyz"}));
  EXPECT_TRUE(refuses(import("short.ply", "0.1"), 3, {"short.ply"}));
  EXPECT_TRUE(refuses(import("cloud.las", "0.1"), 3, {"cloud.las"}));
  for (const char* bad : {"0", "-0.1", "nan", "inf", "1e9", "fine"}) {
    EXPECT_TRUE(refuses(import("good.xyz", bad), 2, {"--resolution"})) << bad;
  }
  EXPECT_TRUE(
      refuses({"map", "import", path("good.xyz"), "--resolution", "0.1", "-o", path("good.xyz")}, 2, {"input"}));
  EXPECT_TRUE(refuses({"map", "import", path("good.xyz"), "-o", path("out.bt")}, 2, {"--resolution"}));
}

// ------------------------------------------------------------------------------------------------------------ blobs

class BadBlob : public BadInput {
 protected:
  void SetUp() override {
    write_two_rooms(path("good.bt"));
    ASSERT_EQ(swiftlet({"map", "build", path("good.bt"), "-o", path("good.swm"), "--radius", "0.15"}).status, 0);
    good_ = read_text(path("good.swm"));
  }

  /// `plan` and `map info` both refuse these bytes.
  testing::AssertionResult refuses_blob(const std::string& bytes, const Words& words) {
    write_text(path("bad.swm"), bytes);
    Words all = words;
    all.push_back("bad.swm");
    const testing::AssertionResult info = refuses({"map", "info", path("bad.swm"), "--json", path("out.json")}, 3, all);
    if (!info) return info;
    return refuses({"plan", path("bad.swm"), "--start", kLeft, "--goal", kLeftToo, "--vmax", "1", "--amax", "1",
                    "--json", path("out.json")},
                   3, all);
  }
  std::string good_;
};

TEST_F(BadBlob, MissingEmptyForeignAndTruncatedBlobsAreRefused) {
  EXPECT_TRUE(refuses({"map", "info", path("none.swm")}, 3, {"none.swm"}));
  EXPECT_TRUE(refuses({"map", "info", path(".")}, 3, {"folder"}));
  EXPECT_TRUE(refuses_blob("", {"empty"}));
  EXPECT_TRUE(refuses_blob("hello", {"not a swiftlet map"}));
  EXPECT_TRUE(refuses_blob(read_text(path("good.bt")), {"not a swiftlet map"}));
  for (std::size_t size = 8; size < good_.size(); size += good_.size() / 30 + 1) {
    EXPECT_TRUE(refuses_blob(good_.substr(0, size), {"cut short"})) << size;
    if (size < 224) continue;  // shorter than the header
    EXPECT_TRUE(refuses_blob(good_.substr(0, size), {std::to_string(size) + " of " + std::to_string(good_.size())}));
  }
}

TEST_F(BadBlob, MapVerifyRefusesWhatItCannotRead) {
  const auto verify = [&](const std::string& map, const std::string& source) {
    return std::vector<std::string>{"map", "verify", path(map), path(source)};
  };
  write_text(path("short.swm"), good_.substr(0, good_.size() / 2));
  write_text(path("text.bt"), "This is no map.\n");
  EXPECT_TRUE(refuses(verify("none.swm", "good.bt"), 3, {"none.swm"}));
  EXPECT_TRUE(refuses(verify("short.swm", "good.bt"), 3, {"short.swm", "cut short"}));
  EXPECT_TRUE(refuses(verify("good.swm", "none.bt"), 3, {"none.bt"}));
  EXPECT_TRUE(refuses(verify("good.swm", "text.bt"), 3, {"text.bt"}));
  EXPECT_TRUE(refuses({"map", "verify", path("good.swm")}, 2, {"source"}));
}

TEST_F(BadBlob, AnotherVersionAndAnotherByteOrderAreNamed) {
  std::string version = good_;
  ++version[12];
  EXPECT_TRUE(refuses_blob(version, {"version"}));
  std::string swapped = good_;
  std::swap(swapped[8], swapped[11]);
  std::swap(swapped[9], swapped[10]);
  EXPECT_TRUE(refuses_blob(swapped, {"byte order"}));
}

TEST_F(BadBlob, AnyFlippedBitIsNoticed) {
  for (std::size_t byte = 0; byte < good_.size(); byte += good_.size() / 60 + 1) {
    std::string flipped = good_;
    flipped[byte] = static_cast<char>(flipped[byte] ^ (1 << (byte % 8)));
    EXPECT_TRUE(refuses_blob(flipped, {})) << byte;
  }
}

// ----------------------------------------------------------------------------------------------------------- plans

class BadPlan : public BadBlob {
 protected:
  std::vector<std::string> plan(const std::string& start, const std::string& goal,
                                const std::vector<std::string>& extra) {
    std::vector<std::string> arguments{"plan", path("good.swm"), "--start",    start, "--goal",
                                       goal,   "--csv",          path("p.csv")};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    return arguments;
  }
  std::vector<std::string> plan(const std::string& start, const std::string& goal) {
    return plan(start, goal, {"--vmax", "1", "--amax", "1"});
  }
};

TEST_F(BadPlan, AnEndThatIsNotFreeIsRefusedWithReasonAndNearestFreePoint) {
  EXPECT_TRUE(refuses(plan(kOutside, kLeft), 1, {"start_not_free", "outside", "nearest free point", " m "}));
  EXPECT_TRUE(refuses(plan(kInPillar, kLeft), 1, {"start_not_free", "occupied", "nearest free point"}));
  EXPECT_TRUE(refuses(plan(kNearPillar, kLeft), 1, {"start_not_free", "too close", "nearest free point"}));
  EXPECT_TRUE(refuses(plan(kInHole, kLeft), 1, {"start_not_free", "unknown", "nearest free point"}));
  EXPECT_TRUE(refuses(plan(kLeft, kOutside), 1, {"goal_not_free", "outside", "nearest free point"}));
  EXPECT_TRUE(refuses(plan(kLeft, kInPillar), 1, {"goal_not_free", "occupied", "nearest free point"}));
  EXPECT_TRUE(refuses(plan(kLeft, kNearPillar), 1, {"goal_not_free", "too close", "nearest free point"}));
  EXPECT_TRUE(refuses(plan(kLeft, kInHole), 1, {"goal_not_free", "unknown", "nearest free point"}));
  EXPECT_TRUE(refuses(plan("1e300,0,0", kLeft), 1, {"start_not_free", "outside"}));
}

TEST_F(BadPlan, EndsInTwoComponentsAreRefusedNamingBoth) {
  EXPECT_TRUE(refuses(plan(kLeft, kRight), 1, {"no_path", "component 0", "component 1"}));
}

TEST_F(BadPlan, NumbersThatAreNoRequestAreUsageErrors) {
  for (const char* bad : {"nan,0,0", "0,inf,0", "0,0", "0,0,0,0", "a,b,c", "", "0,,0", "1e999,0,0"}) {
    EXPECT_TRUE(refuses(plan(bad, kLeft), 2, {"--start"})) << bad;
    EXPECT_TRUE(refuses(plan(kLeft, bad), 2, {"--goal"})) << bad;
  }
  for (const char* bad : {"0", "-1", "nan", "inf", "1e9", "1e-9", "fast", ""}) {
    EXPECT_TRUE(refuses(plan(kLeft, kLeftToo, {"--vmax", bad, "--amax", "1"}), 2, {"--vmax"})) << bad;
    EXPECT_TRUE(refuses(plan(kLeft, kLeftToo, {"--vmax", "1", "--amax", bad}), 2, {"--amax"})) << bad;
  }
  const auto with = [&](const std::string& option, const std::string& value) {
    return plan(kLeft, kLeftToo, {"--vmax", "1", "--amax", "1", option, value});
  };
  EXPECT_TRUE(refuses(with("--start-velocity", "nan,0,0"), 2, {"--start-velocity"}));
  EXPECT_TRUE(refuses(with("--search-weight", "0.5"), 2, {"--search-weight"}));
  EXPECT_TRUE(refuses(with("--snap", "-1"), 2, {"--snap"}));
  EXPECT_TRUE(refuses(with("--norm", "manhattan"), 2, {"--norm"}));
  EXPECT_TRUE(refuses(with("--corridor", "tubes"), 2, {"--corridor"}));
  EXPECT_TRUE(refuses(with("--relax", "maybe"), 2, {"--relax"}));
  EXPECT_TRUE(refuses(with("--search", "best"), 2, {"--search"}));
  for (const char* bad : {"0", "-1", "nan", "inf", ""}) EXPECT_TRUE(refuses(with("--jmax", bad), 2, {"--jmax"})) << bad;
  for (const char* bad : {"-1", "1.5", "nan", "", "99999999999999999999"}) {
    EXPECT_TRUE(refuses(with("--refine-us", bad), 2, {"--refine-us"})) << bad;
    EXPECT_TRUE(refuses(with("--deadline-us", bad), 2, {"--deadline-us"})) << bad;
  }
}

TEST_F(BadPlan, AVehicleFileIsRefusedByNameAndFault) {
  const auto refuses_vehicle = [&](const std::string& text, const Words& words) {
    write_text(path("v.json"), text);
    Words all = words;
    all.push_back("v.json");
    return refuses(plan(kLeft, kLeftToo, {"--vmax", "1", "--amax", "1", "--vehicle", path("v.json")}), 3, all);
  };
  const auto with = [](const std::string& key, const std::string& value) {
    Json json{{"format", "swiftlet-vehicle/1"},
              {"mass_kg", 1},
              {"thrust_min_n", 2},
              {"thrust_max_n", 20},
              {"rate_max_rad_s", 3}};
    json[key] = Json::parse(value);
    return json.dump();
  };
  EXPECT_TRUE(refuses({"plan", path("good.swm"), "--start", kLeft, "--goal", kLeftToo, "--vmax", "1", "--amax", "1",
                       "--vehicle", path("none.json")},
                      3, {"none.json"}));
  EXPECT_TRUE(refuses_vehicle("", {"empty", "swiftlet-vehicle/1"}));
  EXPECT_TRUE(refuses_vehicle("{", {"JSON"}));
  EXPECT_TRUE(refuses_vehicle("[]", {"object"}));
  EXPECT_TRUE(refuses_vehicle("{}", {"format"}));
  EXPECT_TRUE(refuses_vehicle(R"({"format":"swiftlet-vehicle/1"})", {"mass_kg", "missing"}));
  EXPECT_TRUE(refuses_vehicle(with("format", R"("swiftlet-case/1")"), {"format"}));
  EXPECT_TRUE(refuses_vehicle(with("maximum_thrust", "20"), {"maximum_thrust"}));
  EXPECT_TRUE(refuses_vehicle(with("mass_kg", "\"heavy\""), {"mass_kg"}));
  EXPECT_TRUE(refuses_vehicle(with("mass_kg", "0"), {"mass_kg"}));
  EXPECT_TRUE(refuses_vehicle(with("rate_max_rad_s", "-1"), {"rate_max_rad_s"}));
  EXPECT_TRUE(refuses_vehicle(with("thrust_max_n", "9"), {"hover", "thrust_max_n"}));
  EXPECT_TRUE(refuses_vehicle(with("thrust_min_n", "10"), {"hover", "thrust_min_n"}));
}

TEST_F(BadPlan, IncompleteOrContradictoryCommandLinesAreUsageErrors) {
  const std::string map = path("good.swm");
  EXPECT_TRUE(refuses({}, 2, {"command"}));
  EXPECT_TRUE(refuses({"fly-me"}, 2, {"fly-me"}));
  EXPECT_TRUE(refuses({"map"}, 2, {"swiftlet map --help"}));
  EXPECT_TRUE(refuses({"plan", map}, 2, {"--vmax"}));
  EXPECT_TRUE(refuses({"plan", map, "--vmax", "1", "--amax", "1"}, 2, {"--start"}));
  EXPECT_TRUE(refuses({"plan", map, "--vmax", "1", "--amax", "1", "--start", kLeft}, 2, {"--goal"}));
  EXPECT_TRUE(refuses({"plan", map, "--vmax", "1", "--amax", "1", "--queries", "q.csv"}, 2, {"--jsonl"}));
  EXPECT_TRUE(refuses({"plan", map, "--vmax", "1", "--amax", "1", "--queries", "q.csv", "--jsonl", "-", "--json", "-"},
                      2, {"--queries"}));
  EXPECT_TRUE(refuses(plan(kLeft, kLeftToo, {"--vmax", "1", "--amax", "1", "--json", path("p.csv")}), 2, {"p.csv"}));
}

TEST_F(BadPlan, AnOutputThatCannotBeWrittenLeavesNothingBehind) {
  const auto with = [&](const std::string& option, const std::string& file) {
    return std::vector<std::string>{"plan", path("good.swm"), "--start", kLeft,  "--goal", kLeftToo, "--vmax",
                                    "1",    "--amax",         "1",       option, file};
  };
  for (const char* option : {"--json", "--csv"}) {
    EXPECT_TRUE(refuses(with(option, path("no/folder/p")), 3, {"no/folder"})) << option;
    EXPECT_TRUE(refuses(with(option, path(".")), 3, {"folder"})) << option;
    EXPECT_TRUE(refuses(with(option, "/dev/full"), 3, {"/dev/full"})) << option;
    EXPECT_TRUE(refuses(with(option, path("good.swm")), 2, {"input"})) << option;
  }
}

TEST_F(BadPlan, AQueryFileWithABadRowIsRefusedByLineBeforeAnyOutput) {
  const auto refuses_queries = [&](const std::string& text, const Words& words) {
    write_text(path("q.csv"), text);
    Words all = words;
    all.push_back("q.csv");
    return refuses({"plan", path("good.swm"), "--queries", path("q.csv"), "--vmax", "1", "--amax", "1", "--jsonl", "-"},
                   3, all);
  };
  const std::string head = "x0,y0,z0,x1,y1,z1\n";
  const std::string good = "-0.75,-0.75,0.5,0.55,0.55,0.5\n";
  EXPECT_TRUE(refuses_queries("", {"empty"}));
  EXPECT_TRUE(refuses_queries("\n\n", {"empty"}));
  EXPECT_TRUE(refuses_queries("x0,y0,z0,x1,y1\n", {":1:", "z1"}));
  EXPECT_TRUE(refuses_queries(good, {":1:", "x0"}));
  EXPECT_TRUE(refuses_queries(head + good + "1,2,3,4,5\n", {":3:", "5 fields"}));
  EXPECT_TRUE(refuses_queries(head + good + good + "1,2,three,4,5,6\n", {":4:", "three", "z0"}));
  EXPECT_TRUE(refuses_queries(head + good + "1,2,3,4,5,6,7\n", {":3:", "7 fields"}));
  EXPECT_TRUE(refuses_queries(head + "1,2,,4,5,6\n", {":2:", "z0"}));
  EXPECT_TRUE(refuses_queries(head + "1,2,3 4,4,5,6\n", {":2:", "3 4"}));
  EXPECT_TRUE(refuses_queries(std::string("\0\1\2\xff", 4), {":1:"}));
}

}  // namespace
}  // namespace swiftlet::tools
