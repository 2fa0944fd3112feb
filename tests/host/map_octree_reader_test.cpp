#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>

#include "map/file_io.hpp"
#include "map/voxel_map.hpp"
#include "map_test_files.hpp"

namespace swiftlet::tools {
namespace {

using test::FileKind;
using test::OctomapFile;
using test::Voxels;

std::span<const std::byte> as_bytes(const std::string& text) {
  return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

/// The known voxels of a map by key, leaves taken apart.
Voxels voxels_of(const VoxelMap& map) {
  Voxels voxels;
  for (const VoxelLeaf& leaf : map.leaves) {
    for (unsigned i = 0; i < 1U << (3 * leaf.log2_edge); ++i) {
      const unsigned mask = (1U << leaf.log2_edge) - 1;
      const std::array<unsigned, 3> offset{i & mask, i >> leaf.log2_edge & mask, i >> (2 * leaf.log2_edge)};
      test::Voxel key{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        key[axis] = static_cast<std::uint16_t>(map.key[axis] + leaf.lo[axis] + offset[axis]);
      }
      EXPECT_FALSE(voxels.contains(key));
      voxels[key] = leaf.occupied;
    }
  }
  return voxels;
}

const Voxels kFewVoxels{{{32768, 32767, 32769}, true}, {{32769, 32767, 32769}, false}, {{40000, 5, 32770}, true}};

TEST(OctreeReader, ReadsEveryKindOfFileToTheSameVoxels) {
  for (const FileKind kind : {FileKind::kBt, FileKind::kOt, FileKind::kColorOt}) {
    const auto map = parse_octree("a.ot", OctomapFile(kFewVoxels, 0.25, kind).bytes());
    ASSERT_TRUE(map.has_value()) << map.error().message;
    EXPECT_EQ(voxels_of(*map), kFewVoxels);
    EXPECT_EQ(map->resolution, 0.25);
    EXPECT_EQ(map->size, (std::array<std::uint32_t, 3>{7233, 32763, 2}));
    EXPECT_EQ(map->origin, (std::array<double, 3>{0, (5 - 32768) * 0.25, 0.25}));
  }
}

TEST(OctreeReader, ReadsLeavesAboveTheLowestLevel) {
  // Child 0 of the root is one occupied leaf, child 7 one free one.
  const std::string text =
      "# Octomap OcTree binary file\nid OcTree\nsize 3\nres 1\ndata\n" + std::string("\x02\x40", 2);
  const auto map = parse_octree("a.bt", as_bytes(text));
  ASSERT_TRUE(map.has_value()) << map.error().message;
  ASSERT_EQ(map->leaves.size(), 2U);
  EXPECT_EQ(map->leaves[0].log2_edge, 15);
  EXPECT_TRUE(map->leaves[0].occupied);
  EXPECT_FALSE(map->leaves[1].occupied);
  EXPECT_EQ(map->size, (std::array<std::uint32_t, 3>{65536, 65536, 65536}));
  EXPECT_EQ(map->origin, (std::array<double, 3>{-32768, -32768, -32768}));
}

TEST(OctreeReader, RefusesEveryTruncationInOneLineThatNamesTheFile) {
  for (const FileKind kind : {FileKind::kBt, FileKind::kOt, FileKind::kColorOt}) {
    const std::vector<std::byte> bytes = OctomapFile(kFewVoxels, 0.25, kind).bytes();
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      const auto map = parse_octree("some.bt", std::span(bytes).first(length));
      ASSERT_FALSE(map.has_value()) << length;
      EXPECT_EQ(map.error().exit_status, 3);
      EXPECT_EQ(map.error().message.rfind("some.bt: ", 0), 0U);
      EXPECT_EQ(map.error().message.find('\n'), std::string::npos);
    }
  }
}

TEST(OctreeReader, SurvivesDamageAnywhere) {
  std::mt19937 random(1);
  for (const FileKind kind : {FileKind::kBt, FileKind::kOt, FileKind::kColorOt}) {
    const std::vector<std::byte> good = OctomapFile(kFewVoxels, 0.25, kind).bytes();
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
      std::vector<std::byte> bad = good;
      bad[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
      const auto map = parse_octree("a", bad);
      if (map) {
        EXPECT_FALSE(map->leaves.empty());
      } else {
        EXPECT_EQ(map.error().exit_status, 3);
      }
    }
  }
}

TEST(OctreeReader, RefusesATreeThatGoesDeeperThanItsLevels) {
  const std::string header = "# Octomap OcTree binary file\nid OcTree\nsize 9\nres 1\ndata\n";
  const auto map = parse_octree("deep.bt", as_bytes(header + std::string(1'000'000, '\xFF')));
  ASSERT_FALSE(map.has_value());
  EXPECT_NE(map.error().message.find("16th level"), std::string::npos) << map.error().message;
}

TEST(OctreeReader, SaysWhatIsWrongWithAForeignOrDamagedHeader) {
  const auto message = [](const std::string& text) {
    const auto map = parse_octree("x.bt", as_bytes(text));
    return map ? std::string("accepted") : map.error().message;
  };
  const auto header = [](const std::string& lines) { return "# Octomap OcTree file\n" + lines + "data\n"; };
  EXPECT_NE(message("").find("is empty"), std::string::npos);
  EXPECT_NE(message("ply\nformat ascii 1.0\n").find("not an OctoMap file"), std::string::npos);
  EXPECT_NE(message(header("id CountingOcTree\nsize 1\nres 1\n")).find("type CountingOcTree"), std::string::npos);
  EXPECT_NE(message("# Octomap OcTree binary file\nid ColorOcTree\nsize 1\nres 1\ndata\n").find("ColorOcTree"),
            std::string::npos);
  EXPECT_NE(message(header("size 1\nres 1\n")).find("no `id`"), std::string::npos);
  EXPECT_NE(message(header("id OcTree\nres 1\n")).find("no `size`"), std::string::npos);
  EXPECT_NE(message(header("id OcTree\nsize 1\n")).find("`res`"), std::string::npos);
  for (const char* res : {"0", "-1", "nan", "inf", "1e300", "1e-300", "x"}) {
    EXPECT_NE(message(header(std::string("id OcTree\nsize 1\nres ") + res + "\n")).find("`res`"), std::string::npos)
        << res;
  }
  EXPECT_NE(message(header("id OcTree\nsize 0\nres 1\n")).find("no voxel"), std::string::npos);
  EXPECT_NE(message("# Octomap OcTree file\nid OcTree\nsize 1\nres 1\n").find("no `data`"), std::string::npos);
  EXPECT_NE(message(header("id OcTree\nsize 1\nres 1\n") + std::string("\x00\x00\xC0\x7F\x00", 5)).find("no number"),
            std::string::npos);
}

TEST(OctreeReader, NamesAFileThatCannotBeRead) {
  EXPECT_NE(read_octree("/nowhere/a.bt").error().message.find("/nowhere/a.bt: cannot be read"), std::string::npos);
  EXPECT_NE(read_octree("/tmp").error().message.find("folder"), std::string::npos);
}

TEST(OctreeReader, CountsTheLeavesOfRealScansAsOctomapDoes) {
  struct Expected {
    const char* path;
    std::ptrdiff_t occupied;
    std::ptrdiff_t free;
  };
  const std::filesystem::path maps = std::filesystem::path(SWIFTLET_SOURCE_DIR) / ".." / "shared" / "maps";
  if (!std::filesystem::exists(maps)) GTEST_SKIP() << maps << " is absent";
  for (const Expected& expected : {Expected{"geb079/geb079.bt", 143'729, 284'415},
                                   {"power_plant/power_plant.bt", 139'733, 189'072},
                                   {"rgbd_room/rgbd_room.ot", 54'163, 199'211}}) {
    const auto map = read_octree((maps / expected.path).string());
    ASSERT_TRUE(map.has_value()) << map.error().message;
    const auto occupied =
        std::count_if(map->leaves.begin(), map->leaves.end(), [](const VoxelLeaf& l) { return l.occupied; });
    EXPECT_EQ(occupied, expected.occupied);
    EXPECT_EQ(static_cast<std::ptrdiff_t>(map->leaves.size()) - occupied, expected.free);
  }
}

TEST(FileIo, ReplacesAFileAsAWholeAndLeavesNothingBesideIt) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "swiftlet_file_io";
  std::filesystem::create_directories(folder);
  const std::string path = (folder / "out.bin").string();
  ASSERT_TRUE(write_file_atomically(path, as_bytes("first")).has_value());
  ASSERT_TRUE(write_file_atomically(path, as_bytes("second")).has_value());
  const auto bytes = read_file(path);
  ASSERT_TRUE(bytes.has_value());
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()), "second");
  EXPECT_FALSE(write_file_atomically((folder / "absent" / "x").string(), as_bytes("x")).has_value());
  EXPECT_FALSE(write_file_atomically(folder.string(), as_bytes("x")).has_value());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace swiftlet::tools
