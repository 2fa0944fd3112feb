#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include <cstring>
#include <filesystem>
#include <limits>
#include <random>
#include <sstream>

#include "map/file_io.hpp"
#include "map/point_cloud.hpp"
#include "map/voxel_map.hpp"

namespace swiftlet::tools {
namespace {

std::span<const std::byte> as_bytes(const std::string& text) {
  return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

template <typename T>
std::string raw(T value, bool swap = false) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return swap ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

using Points = std::vector<std::array<double, 3>>;
const Points kTwoPoints{{1.5, -2, 0.25}, {-3, 4, 5}};

Points points_of(const std::string& name, const std::string& text) {
  const auto cloud = parse_point_cloud(name, as_bytes(text));
  EXPECT_TRUE(cloud.has_value()) << cloud.error().message;
  return cloud ? cloud->points : Points{};
}

std::string message_of(const std::string& name, const std::string& text) {
  const auto cloud = parse_point_cloud(name, as_bytes(text));
  if (cloud) return "accepted";
  EXPECT_EQ(cloud.error().exit_status, 3);
  EXPECT_EQ(cloud.error().message.find('\n'), std::string::npos);
  return cloud.error().message;
}

std::string ply_header(const std::string& format, const std::string& type) {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\nelement vertex 2\nproperty uchar red\nproperty " +
         type + " z\nproperty " + type + " x\nproperty " + type +
         " y\nelement face 0\nproperty list uchar int v\nend_header\n";
}

std::string ply_file(const std::string& format) {
  std::string text = ply_header(format, "double");
  for (const auto& p : kTwoPoints) {
    const bool swap = format == "binary_big_endian";
    text += "r" + raw(p[2], swap) + raw(p[0], swap) + raw(p[1], swap);
  }
  return text;
}

std::string pcd_header(const std::string& data, const std::string& points = "2") {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS rgb x y z\nSIZE 1 4 4 4\nTYPE U F F F\nCOUNT 3 1 1 1\nWIDTH 2\nHEIGHT 1\n"
         "VIEWPOINT 0.5 1 2 1 0 0 0\nPOINTS " +
         points + "\nDATA " + data + "\n";
}

std::string pcd_file() {
  std::string text = pcd_header("binary");
  for (const auto& p : kTwoPoints) {
    text += "rgb" + raw(static_cast<float>(p[0])) + raw(static_cast<float>(p[1])) + raw(static_cast<float>(p[2]));
  }
  return text;
}

TEST(PointCloud, ReadsEveryFormatToTheSamePoints) {
  EXPECT_EQ(points_of("a.xyz", "# x y z\n1.5 -2 2.5e-1 99\r\n\n-3;4,\t5"), kTwoPoints);
  EXPECT_EQ(points_of("a.ply", ply_header("ascii", "float") + "7 0.25 1.5 -2\n7 5 -3 4\n"), kTwoPoints);
  EXPECT_EQ(points_of("a.ply", ply_file("binary_little_endian")), kTwoPoints);
  EXPECT_EQ(points_of("a.ply", ply_file("binary_big_endian")), kTwoPoints);
  EXPECT_EQ(points_of("a.pcd", pcd_header("ascii") + "1 2 3 1.5 -2 0.25\n1 2 3 -3 4 5\n"), kTwoPoints);
  EXPECT_EQ(points_of("a.pcd", pcd_file()), kTwoPoints);
}

TEST(PointCloud, ReadsNoDecimalCommasAsSeparators) {
  for (const char* row : {"1,5 2,5 3,5\n", "1,5;2,5;3,5\n", "1 2 3,5\n", "1,5\t2\t3\n"}) {
    const std::string message = message_of("a.xyz", std::string("0 0 0\n") + row);
    EXPECT_NE(message.find("line 2"), std::string::npos) << row << message;
    EXPECT_NE(message.find("decimal"), std::string::npos) << row << message;
  }
  for (const char* row : {"1,2,3\n", "1, 2, 3\n", "1 , 2 , 3 \n", "1;2;3\n", "1,2,3,4\n", " 1,2,3\n"}) {
    EXPECT_EQ(points_of("a.xyz", row), (std::vector<std::array<double, 3>>{{1, 2, 3}})) << row;
  }
}

TEST(PointCloud, KnowsItsFormatsInCapitalsToo) {
  EXPECT_EQ(points_of("A.XYZ", "1 2 3\n").size(), 1U);
  EXPECT_EQ(points_of("A.Ply", ply_file("binary_little_endian")), kTwoPoints);
  EXPECT_EQ(points_of("A.PCD", pcd_file()), kTwoPoints);
}

TEST(PointCloud, TakesTheViewpointOfAPcdAndDropsPointsThatAreNone) {
  const auto cloud = parse_point_cloud("a.pcd", as_bytes(pcd_header("ascii") + "1 2 3 nan nan nan\n1 2 3 -3 4 5\n"));
  ASSERT_TRUE(cloud.has_value()) << cloud.error().message;
  EXPECT_EQ(cloud->viewpoint, (std::array<double, 3>{0.5, 1, 2}));
  EXPECT_EQ(cloud->dropped, 1U);
  EXPECT_EQ(cloud->points.size(), 1U);
}

TEST(PointCloud, RefusesEveryTruncationOfABinaryFile) {
  for (const auto& [name, text] :
       {std::pair("a.ply", ply_file("binary_little_endian")), std::pair("a.pcd", pcd_file())}) {
    for (std::size_t size = 0; size < text.size(); ++size) {
      EXPECT_NE(message_of(name, text.substr(0, size)), "accepted") << size;
    }
  }
}

TEST(PointCloud, SaysWhatIsWrongAndWhere) {
  EXPECT_NE(message_of("a.xyz", "1 2 3\n1 2\n").find("line 2"), std::string::npos);
  EXPECT_NE(message_of("a.xyz", "1 2 3\n4 five 6\n").find("line 2"), std::string::npos);
  EXPECT_NE(message_of("a.xyz", "nan 1 2\n").find("no finite point"), std::string::npos);
  EXPECT_NE(message_of("a.las", "LASF").find("docs/import.md"), std::string::npos);
  EXPECT_NE(message_of("a.ply", "").find("empty"), std::string::npos);
  EXPECT_NE(message_of("a.ply", "plx\n").find("not `ply`"), std::string::npos);
  EXPECT_NE(message_of("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n")
                .find("without y"),
            std::string::npos);
  EXPECT_NE(message_of("a.ply", "ply\nformat ascii 1.0\nelement vertex -1\n").find("line 3"), std::string::npos);
  EXPECT_NE(message_of("a.ply", "ply\nformat ascii 1.0\nelement face 1\n").find("begin with its vertices"),
            std::string::npos);
  EXPECT_NE(message_of("a.pcd", pcd_header("binary_compressed")).find("compressed"), std::string::npos);
  EXPECT_NE(message_of("a.pcd", pcd_header("binary", "18446744073709551615") + "x").find("cut short"),
            std::string::npos);
  EXPECT_NE(message_of("a.pcd", "hello\n").find("line 1"), std::string::npos);
}

TEST(PointCloud, BecomesAnOctreeThatOctomapReadsToTheSameVoxels) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(-4, 4);
  PointCloud cloud;
  cloud.viewpoint = {0.1, 0.2, 0.3};
  for (int i = 0; i < 300; ++i) cloud.points.push_back({coordinate(random), coordinate(random), coordinate(random)});
  const auto file = octree_of(cloud, "cloud", 0.25, true);
  ASSERT_TRUE(file.has_value());
  std::stringstream stream(std::string(reinterpret_cast<const char*>(file->data()), file->size()));
  octomap::OcTree tree(1);
  ASSERT_TRUE(tree.readBinary(stream));
  EXPECT_EQ(tree.getResolution(), 0.25);
  for (const auto& p : cloud.points) {
    const auto* node = tree.search(p[0], p[1], p[2]);
    ASSERT_NE(node, nullptr);
    EXPECT_TRUE(tree.isNodeOccupied(node));
    // The way there is known, and its voxels hang together: every point on it, but for grazed corners, is in one.
    for (double share = 0.013; share < 1; share += 0.05) {
      std::array<double, 3> q{};
      for (std::size_t axis = 0; axis < 3; ++axis)
        q[axis] = cloud.viewpoint[axis] + share * (p[axis] - cloud.viewpoint[axis]);
      EXPECT_NE(tree.search(q[0], q[1], q[2]), nullptr);
    }
  }
  const auto map = parse_octree("a.bt", *file);
  ASSERT_TRUE(map.has_value());
  std::size_t leaves = 0;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) ++leaves;
  EXPECT_EQ(map->leaves.size(), leaves);
}

TEST(PointCloud, WithoutRaysOnlyThePointsAreKnown) {
  PointCloud cloud;
  cloud.points = {{0.1, 0.1, 0.1}, {0.2, 0.2, 0.2}, {3, 3, 3}};
  const auto map = parse_octree("a.bt", *octree_of(cloud, "cloud", 0.5, false));
  ASSERT_TRUE(map.has_value());
  EXPECT_EQ(map->leaves.size(), 2U);
  EXPECT_TRUE(map->leaves[0].occupied && map->leaves[1].occupied);
}

TEST(PointCloud, RefusesACloudWiderThanAnOctree) {
  PointCloud cloud;
  cloud.points = {{40'000, 0, 0}};
  const auto file = octree_of(cloud, "far.ply", 1, false);
  ASSERT_FALSE(file.has_value());
  EXPECT_NE(file.error().message.find("--resolution"), std::string::npos);
  EXPECT_TRUE(octree_of(cloud, "far.ply", 2, false).has_value());
  cloud.points = {{std::numeric_limits<double>::max(), 0, 0}};
  EXPECT_FALSE(octree_of(cloud, "far.ply", 1, true).has_value());
}

}  // namespace
}  // namespace swiftlet::tools
