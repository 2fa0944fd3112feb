#include "world/voxel_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace swiftlet::tools {
namespace {

constexpr double kEdge = 4294967296.0;  // one voxel edge in fixed point: a path of 2^16 steps is exact to 2^-17
constexpr std::int64_t kUnreached = std::numeric_limits<std::int64_t>::max();

/// The length of a step that changes 1, 2 or 3 coordinates.
std::int64_t step_length(int axes) { return std::llround(kEdge * std::sqrt(static_cast<double>(axes))); }

/// One of the 26 moves. Of the 27 voxels around its start, numbered (z + 1) * 9 + (y + 1) * 3 + x + 1, bit i of
/// `touched` says whether the move touches number i: a diagonal touches all voxels of the box that it crosses.
struct Step {
  Voxel offset;
  std::int64_t length;
  std::uint32_t touched;
};

std::uint32_t bit_of(const Voxel& offset) {
  return std::uint32_t{1} << static_cast<unsigned>((offset[2] + 1) * 9 + (offset[1] + 1) * 3 + offset[0] + 1);
}

std::vector<Voxel> offsets_27() {
  std::vector<Voxel> offsets;
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) offsets.push_back({x, y, z});
    }
  }
  return offsets;
}

std::vector<Step> steps_26() {
  std::vector<Step> steps;
  for (const Voxel& offset : offsets_27()) {
    const int squared = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
    if (squared == 0) continue;
    std::uint32_t touched = 0;
    for (unsigned part = 1; part < 8; ++part) {  // every combination of the step's axes, the whole step included
      const auto along = [&](std::size_t axis) { return (part >> axis & 1U) != 0 ? offset[axis] : 0; };
      touched |= bit_of({along(0), along(1), along(2)});
    }
    steps.push_back({offset, step_length(squared), touched});
  }
  return steps;
}

Voxel moved(const Voxel& voxel, const Voxel& step) {
  return {voxel[0] + step[0], voxel[1] + step[1], voxel[2] + step[2]};
}

}  // namespace

VoxelPathFinder::VoxelPathFinder(const VoxelGrid& grid, double radius)
    : grid_(grid), free_(voxels_with_clearance(grid, radius)), cost_(grid.voxel_count(), kUnreached) {}

std::uint32_t VoxelPathFinder::free_around(const Voxel& voxel) const {
  static const std::vector<Voxel> offsets = offsets_27();
  std::uint32_t free = 0;
  for (const Voxel& offset : offsets) {
    const Voxel neighbour = moved(voxel, offset);
    if (grid_.contains(neighbour) && free_[grid_.index(neighbour)] != 0) free |= bit_of(offset);
  }
  return free;
}

std::int64_t VoxelPathFinder::octile(const Voxel& a, const Voxel& b) {
  static const std::array<std::int64_t, 3> lengths{step_length(1), step_length(2), step_length(3)};
  std::array<int, 3> d{std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])};
  std::sort(d.begin(), d.end());
  return lengths[2] * d[0] + lengths[1] * (d[1] - d[0]) + lengths[0] * (d[2] - d[1]);
}

std::optional<double> VoxelPathFinder::shortest(const Voxel& from, const Voxel& to) {
  static const std::vector<Step> steps = steps_26();
  const std::size_t goal = grid_.index(to);
  if (free_[grid_.index(from)] == 0 || free_[goal] == 0) return std::nullopt;

  for (const std::size_t voxel : reached_) cost_[voxel] = kUnreached;
  reached_.assign(1, grid_.index(from));
  std::priority_queue<Open, std::vector<Open>, Later> open;
  cost_[grid_.index(from)] = 0;
  open.push({octile(from, to), 0, grid_.index(from)});
  while (!open.empty()) {
    const Open best = open.top();
    open.pop();
    if (best.voxel == goal) return static_cast<double>(best.cost) / kEdge * grid_.resolution();
    if (best.cost > cost_[best.voxel]) continue;  // a shorter way was found meanwhile
    const Voxel voxel = grid_.voxel(best.voxel);
    const std::uint32_t free = free_around(voxel);
    for (const Step& step : steps) {
      if ((step.touched & ~free) != 0) continue;
      const Voxel next = moved(voxel, step.offset);
      const std::size_t index = grid_.index(next);
      const std::int64_t cost = best.cost + step.length;
      if (cost >= cost_[index]) continue;
      if (cost_[index] == kUnreached) reached_.push_back(index);
      cost_[index] = cost;
      open.push({cost + octile(next, to), cost, index});
    }
  }
  return std::nullopt;
}

std::vector<std::uint8_t> largest_component(const VoxelGrid& grid, const std::vector<std::uint8_t>& allowed) {
  constexpr std::array<Voxel, 6> kFaces{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
  std::vector<std::uint8_t> seen(grid.voxel_count(), 0);
  std::vector<std::size_t> largest;
  for (std::size_t seed = 0; seed < grid.voxel_count(); ++seed) {
    if (allowed[seed] == 0 || seen[seed] != 0) continue;
    std::vector<std::size_t> component{seed};
    seen[seed] = 1;
    for (std::size_t i = 0; i < component.size(); ++i) {
      const Voxel voxel = grid.voxel(component[i]);
      for (const Voxel& face : kFaces) {
        const Voxel next = moved(voxel, face);
        if (!grid.contains(next)) continue;
        const std::size_t index = grid.index(next);
        if (allowed[index] == 0 || seen[index] != 0) continue;
        seen[index] = 1;
        component.push_back(index);
      }
    }
    if (component.size() > largest.size()) largest.swap(component);
  }
  std::vector<std::uint8_t> mask(grid.voxel_count(), 0);
  for (const std::size_t index : largest) mask[index] = 1;
  return mask;
}

}  // namespace swiftlet::tools
