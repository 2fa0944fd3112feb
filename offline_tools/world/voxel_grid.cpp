#include "world/voxel_grid.hpp"

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

// --- .bt: two bits a node, children after their parent; a cube of one kind is one node ---

constexpr std::size_t kOctreeDepth = 16;
constexpr std::uint8_t kInner = 3;  // beside the codes of a voxel, which a leaf of any size has

/// The codes of all cubes of one size that reach into the grid.
struct OctreeLevel {
  Voxel size;
  std::vector<std::uint8_t> codes;

  [[nodiscard]] std::uint8_t code(const Voxel& cube) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (cube[axis] >= size[axis]) return kUnknownVoxel;
    }
    const int number = (cube[2] * size[1] + cube[1]) * size[0] + cube[0];
    return codes[static_cast<std::size_t>(number)];
  }
};

Voxel child_of(const Voxel& cube, int child) {
  return {2 * cube[0] + (child & 1), 2 * cube[1] + (child >> 1 & 1), 2 * cube[2] + (child >> 2)};
}

/// Like its children when they are all alike, else inner.
std::uint8_t joined_code(const OctreeLevel& children, const Voxel& cube) {
  const std::uint8_t first = children.code(child_of(cube, 0));
  for (int child = 1; child < 8; ++child) {
    if (children.code(child_of(cube, child)) != first) return kInner;
  }
  return first;
}

/// Level i holds cubes of 2^i voxels, from the grid's low corner on; the last one is the octant of OctoMap's root that
/// lies above the origin of frame W.
std::vector<OctreeLevel> octree_levels(const Voxel& size, std::vector<std::uint8_t> codes) {
  std::vector<OctreeLevel> levels{{size, std::move(codes)}};
  while (levels.size() < kOctreeDepth) {
    const OctreeLevel& finer = levels.back();
    OctreeLevel level{{(finer.size[0] + 1) / 2, (finer.size[1] + 1) / 2, (finer.size[2] + 1) / 2}, {}};
    for (int z = 0; z < level.size[2]; ++z) {
      for (int y = 0; y < level.size[1]; ++y) {
        for (int x = 0; x < level.size[0]; ++x) level.codes.push_back(joined_code(finer, {x, y, z}));
      }
    }
    levels.push_back(std::move(level));
  }
  return levels;
}

/// Appends an inner node and all below it; returns how many nodes those are, leaves included.
std::size_t write_node(const std::vector<OctreeLevel>& levels, std::size_t level, const Voxel& cube,
                       std::string& nodes) {
  unsigned codes = 0;
  for (int child = 0; child < 8; ++child) {
    codes |= unsigned{levels[level - 1].code(child_of(cube, child))} << static_cast<unsigned>(2 * child);
  }
  nodes += static_cast<char>(codes & 255U);
  nodes += static_cast<char>(codes >> 8U);
  std::size_t count = 1;
  for (int child = 0; child < 8; ++child) {
    const unsigned code = codes >> static_cast<unsigned>(2 * child) & 3U;
    if (code == kInner) count += write_node(levels, level - 1, child_of(cube, child), nodes);
    if (code == kFreeVoxel || code == kOccupiedVoxel) ++count;
  }
  return count;
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
  std::vector<std::uint8_t> codes(grid.voxel_count());
  for (std::size_t i = 0; i < codes.size(); ++i) {
    codes[i] = grid.occupied(grid.voxel(i)) ? kOccupiedVoxel : kFreeVoxel;
  }
  return to_bt(grid.size(), grid.resolution(), std::move(codes));
}

std::string to_bt(const Voxel& size, double resolution, std::vector<std::uint8_t> codes) {
  const std::vector<OctreeLevel> levels = octree_levels(size, std::move(codes));
  std::string nodes("\0\xC0", 2);  // the root: its last child alone is there, an inner node
  const std::size_t node_count = 1 + write_node(levels, kOctreeDepth - 1, {0, 0, 0}, nodes);
  std::ostringstream header;
  header
      << "# Octomap OcTree binary file\n# (feel free to add / change comments, but leave the first line as it is!)\n#\n"
      << "id OcTree\nsize " << node_count << "\nres " << resolution << "\ndata\n";
  return header.str() + nodes;
}

}  // namespace swiftlet::tools
