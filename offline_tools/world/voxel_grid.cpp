#include "world/voxel_grid.hpp"

#include <octomap/OcTree.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

namespace swiftlet::tools {
namespace {

/// Offsets of the cubes that come nearer than `distance` to the centre of voxel (0, 0, 0).
std::vector<Voxel> offsets_within(double distance, double resolution) {
  constexpr double kRounding = 1e-9;  // a cube exactly at the distance does not block
  const int reach = static_cast<int>(std::ceil(distance / resolution + 0.5));
  const auto gap = [&](int offset) { return std::max(0.0, std::abs(offset) - 0.5) * resolution; };
  std::vector<Voxel> offsets;
  for (int z = -reach; z <= reach; ++z) {
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        const double nearest = std::sqrt(gap(x) * gap(x) + gap(y) * gap(y) + gap(z) * gap(z));
        if (nearest < distance - kRounding) offsets.push_back({x, y, z});
      }
    }
  }
  return offsets;
}

}  // namespace

VoxelGrid::VoxelGrid(const Voxel& size, double resolution)
    : size_(size),
      resolution_(resolution),
      occupied_(static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
                static_cast<std::size_t>(size[2])) {}

std::size_t VoxelGrid::occupied_count() const {
  return static_cast<std::size_t>(std::count(occupied_.begin(), occupied_.end(), std::uint8_t{1}));
}

bool VoxelGrid::contains(const Voxel& voxel) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (voxel[axis] < 0 || voxel[axis] >= size_[axis]) return false;
  }
  return true;
}

std::size_t VoxelGrid::index(const Voxel& voxel) const {
  const auto [x, y, z] = voxel;
  return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size_[1]) + static_cast<std::size_t>(y)) *
             static_cast<std::size_t>(size_[0]) +
         static_cast<std::size_t>(x);
}

Voxel VoxelGrid::voxel(std::size_t index) const {
  const auto width = static_cast<std::size_t>(size_[0]);
  const auto depth = static_cast<std::size_t>(size_[1]);
  return {static_cast<int>(index % width), static_cast<int>(index / width % depth),
          static_cast<int>(index / width / depth)};
}

std::array<double, 3> VoxelGrid::centre(const Voxel& voxel) const {
  return {(voxel[0] + 0.5) * resolution_, (voxel[1] + 0.5) * resolution_, (voxel[2] + 0.5) * resolution_};
}

void VoxelGrid::fill(const VoxelBox& box, bool occupied) {
  for (int z = box.lo[2]; z <= box.hi[2]; ++z) {
    for (int y = box.lo[1]; y <= box.hi[1]; ++y) {
      for (int x = box.lo[0]; x <= box.hi[0]; ++x) occupied_[index({x, y, z})] = occupied ? 1 : 0;
    }
  }
}

std::vector<std::uint8_t> voxels_with_clearance(const VoxelGrid& grid, double distance) {
  std::vector<std::uint8_t> clear(grid.voxel_count(), 1);
  const std::vector<Voxel> offsets = offsets_within(distance, grid.resolution());
  for (std::size_t i = 0; i < grid.voxel_count(); ++i) {
    const Voxel voxel = grid.voxel(i);
    if (!grid.occupied(voxel)) continue;
    for (const Voxel& offset : offsets) {
      const Voxel blocked{voxel[0] + offset[0], voxel[1] + offset[1], voxel[2] + offset[2]};
      if (grid.contains(blocked)) clear[grid.index(blocked)] = 0;
    }
  }
  return clear;
}

std::string to_bt(const VoxelGrid& grid) {
  constexpr bool kLazy = true;             // inner nodes are updated once, at the end
  constexpr unsigned kOrigin = 1U << 15U;  // OctoMap's key of the voxel above the origin
  octomap::OcTree tree(grid.resolution());
  for (std::size_t i = 0; i < grid.voxel_count(); ++i) {
    const Voxel voxel = grid.voxel(i);
    const auto key = [&](std::size_t axis) {
      return static_cast<octomap::key_type>(kOrigin + static_cast<unsigned>(voxel[axis]));
    };
    tree.updateNode(octomap::OcTreeKey(key(0), key(1), key(2)), grid.occupied(voxel), kLazy);
  }
  tree.updateInnerOccupancy();
  tree.toMaxLikelihood();
  tree.prune();
  std::ostringstream bytes;  // what OcTree::writeBinary writes, without its chatter on the terminal
  bytes
      << "# Octomap OcTree binary file\n# (feel free to add / change comments, but leave the first line as it is!)\n#\n"
      << "id OcTree\nsize " << tree.size() << "\nres " << grid.resolution() << "\ndata\n";
  tree.writeBinaryNode(bytes, tree.getRoot());
  return bytes.str();
}

}  // namespace swiftlet::tools
