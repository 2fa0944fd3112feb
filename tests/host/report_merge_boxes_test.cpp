#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "report/merge_boxes.hpp"

namespace {

using swiftlet::IntBox;
using swiftlet::tools::merge_boxes;

constexpr int kEdge = 9;  // the random fills live in a cube of so many voxels an edge

int place(int x, int y, int z) { return (z * kEdge + y) * kEdge + x; }

/// How often each voxel of the cube is covered.
std::vector<int> coverage(const std::vector<IntBox>& boxes) {
  std::vector<int> times(kEdge * kEdge * kEdge);
  for (const IntBox& box : boxes) {
    for (int z = box.lo[2]; z < box.hi[2]; ++z) {
      for (int y = box.lo[1]; y < box.hi[1]; ++y) {
        for (int x = box.lo[0]; x < box.hi[0]; ++x) ++times[static_cast<std::size_t>(place(x, y, z))];
      }
    }
  }
  return times;
}

IntBox voxel(int x, int y, int z) {
  const auto at = [](int value) { return static_cast<std::uint16_t>(value); };
  return {{at(x), at(y), at(z)}, {at(x + 1), at(y + 1), at(z + 1)}};
}

std::vector<IntBox> random_voxels(std::mt19937& random, unsigned one_in) {
  std::vector<IntBox> voxels;
  for (int z = 0; z < kEdge; ++z) {
    for (int y = 0; y < kEdge; ++y) {
      for (int x = 0; x < kEdge; ++x) {
        if (random() % one_in == 0) voxels.push_back(voxel(x, y, z));
      }
    }
  }
  return voxels;
}

TEST(MergeBoxes, KeepsNothingAndOneBoxAsTheyAre) {
  EXPECT_TRUE(merge_boxes({}).empty());
  const std::vector<IntBox> one{voxel(1, 2, 3)};
  EXPECT_EQ(merge_boxes(one), one);
}

TEST(MergeBoxes, MakesOneBoxOfAFullCube) {
  std::mt19937 random(1);
  const std::vector<IntBox> merged = merge_boxes(random_voxels(random, 1));
  ASSERT_EQ(merged.size(), 1U);
  EXPECT_EQ(merged[0], (IntBox{{0, 0, 0}, {kEdge, kEdge, kEdge}}));
}

TEST(MergeBoxes, DoesNotMergeBoxesThatTouchOnlyAtAnEdgeOrWithPartOfAFace) {
  const std::vector<IntBox> at_an_edge{voxel(0, 0, 0), voxel(1, 1, 0)};
  EXPECT_EQ(merge_boxes(at_an_edge).size(), 2U);
  const std::vector<IntBox> part_of_a_face{{{0, 0, 0}, {2, 2, 2}}, {{2, 0, 0}, {3, 1, 1}}};
  EXPECT_EQ(merge_boxes(part_of_a_face).size(), 2U);
}

TEST(MergeBoxes, CoversExactlyTheSameVoxelsOnceEachInAnyOrder) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::vector<IntBox> voxels = random_voxels(random, 2 + seed % 3);
    const std::vector<IntBox> merged = merge_boxes(voxels);
    EXPECT_EQ(coverage(merged), coverage(voxels));
    EXPECT_LT(merged.size(), voxels.size());
    std::shuffle(voxels.begin(), voxels.end(), random);
    EXPECT_EQ(merge_boxes(voxels), merged);
  }
}

}  // namespace
