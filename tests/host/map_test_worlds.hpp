#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "map/map_builder.hpp"
#include "map/voxel_map.hpp"

namespace swiftlet::test {

using tools::MapBuildOptions;
using tools::Partition;
using tools::VoxelMap;

enum class Known : char { kUnknown = '?', kFree = '.', kOccupied = '#' };

/// A small world of voxels, its low corner at the origin. Text rows run along x, rows along y, layers along z.
struct SmallWorld {
  std::array<int, 3> size{};
  double resolution = 1;
  std::vector<Known> voxels;

  [[nodiscard]] Known at(int x, int y, int z) const {
    return voxels[static_cast<std::size_t>((z * size[1] + y) * size[0] + x)];
  }
};

inline SmallWorld world_of(const std::vector<std::vector<std::string>>& layers, double resolution = 1) {
  SmallWorld world;
  world.size = {static_cast<int>(layers[0][0].size()), static_cast<int>(layers[0].size()),
                static_cast<int>(layers.size())};
  world.resolution = resolution;
  for (const auto& layer : layers) {
    for (const std::string& row : layer) {
      for (const char c : row) world.voxels.push_back(static_cast<Known>(c));
    }
  }
  return world;
}

inline VoxelMap voxel_map(const SmallWorld& world) {
  VoxelMap map;
  map.resolution = world.resolution;
  map.key = {32768, 32768, 32768};
  for (std::size_t axis = 0; axis < 3; ++axis) map.size[axis] = static_cast<std::uint32_t>(world.size[axis]);
  for (int z = 0; z < world.size[2]; ++z) {
    for (int y = 0; y < world.size[1]; ++y) {
      for (int x = 0; x < world.size[0]; ++x) {
        if (world.at(x, y, z) == Known::kUnknown) continue;
        const std::array<std::uint16_t, 3> lo{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y),
                                              static_cast<std::uint16_t>(z)};
        map.leaves.push_back({lo, 0, world.at(x, y, z) == Known::kOccupied});
      }
    }
  }
  return map;
}

inline SmallWorld random_world(std::mt19937& random) {
  const auto pick = [&random](int lo, int hi) {
    return lo + static_cast<int>(random() % static_cast<unsigned>(hi - lo + 1));
  };
  SmallWorld world;
  world.size = {pick(1, 9), pick(1, 7), pick(1, 5)};
  constexpr std::array<double, 4> kResolutions{0.05, 0.1, 0.32, 1};
  world.resolution = kResolutions[random() % kResolutions.size()];
  const auto occupied = static_cast<unsigned>(random() % 20);
  const auto unknown = static_cast<unsigned>(random() % 30);
  for (int i = 0; i < world.size[0] * world.size[1] * world.size[2]; ++i) {
    const auto dice = static_cast<unsigned>(random() % 100);
    world.voxels.push_back(dice < occupied             ? Known::kOccupied
                           : dice < occupied + unknown ? Known::kUnknown
                                                       : Known::kFree);
  }
  return world;
}

inline MapBuildOptions random_options(std::mt19937& random, double resolution) {
  constexpr std::array<double, 9> kRadii{0, 0.2, 0.3, 0.5, 0.75,
                                         1, 1.2, 2,   3};  // voxels; whole numbers hit distances exactly
  MapBuildOptions options;
  options.radius = kRadii[random() % kRadii.size()] * resolution;
  options.unknown = static_cast<UnknownPolicy>(random() % 3);
  options.partition = random() % 4 == 0 ? Partition::kOctree : Partition::kBoxes;
  return options;
}

}  // namespace swiftlet::test
