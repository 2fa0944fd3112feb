#include "world/voxel_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace swiftlet::tools {
namespace {

/// One of the 26 moves. Of the 27 voxels around its start, numbered (z + 1) * 9 + (y + 1) * 3 + x + 1, bit i of
/// `touched` says whether the move touches number i: a diagonal touches all voxels of the box that it crosses.
struct Step {
  Voxel offset;
  double length;  ///< [voxel edges]
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
    steps.push_back({offset, std::sqrt(static_cast<double>(squared)), touched});
  }
  return steps;
}

Voxel moved(const Voxel& voxel, const Voxel& step) {
  return {voxel[0] + step[0], voxel[1] + step[1], voxel[2] + step[2]};
}

}  // namespace

VoxelPathFinder::VoxelPathFinder(const VoxelGrid& grid, double radius)
    : grid_(grid), free_(voxels_with_clearance(grid, radius)), cost_(grid.voxel_count()) {}

std::uint32_t VoxelPathFinder::free_around(const Voxel& voxel) const {
  static const std::vector<Voxel> offsets = offsets_27();
  std::uint32_t free = 0;
  for (const Voxel& offset : offsets) {
    const Voxel neighbour = moved(voxel, offset);
    if (grid_.contains(neighbour) && free_[grid_.index(neighbour)] != 0) free |= bit_of(offset);
  }
  return free;
}

double VoxelPathFinder::octile(const Voxel& a, const Voxel& b) const {
  std::array<int, 3> d{std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])};
  std::sort(d.begin(), d.end());
  return std::sqrt(3.0) * d[0] + std::sqrt(2.0) * (d[1] - d[0]) + (d[2] - d[1]);
}

std::optional<double> VoxelPathFinder::shortest(const Voxel& from, const Voxel& to) {
  static const std::vector<Step> steps = steps_26();
  const std::size_t goal = grid_.index(to);
  if (free_[grid_.index(from)] == 0 || free_[goal] == 0) return std::nullopt;

  std::fill(cost_.begin(), cost_.end(), std::numeric_limits<double>::infinity());
  std::priority_queue<Open, std::vector<Open>, Later> open;
  cost_[grid_.index(from)] = 0;
  open.push({octile(from, to), 0, grid_.index(from)});
  while (!open.empty()) {
    const Open best = open.top();
    open.pop();
    if (best.voxel == goal) return best.cost * grid_.resolution();
    if (best.cost > cost_[best.voxel]) continue;  // a shorter way was found meanwhile
    const Voxel voxel = grid_.voxel(best.voxel);
    const std::uint32_t free = free_around(voxel);
    for (const Step& step : steps) {
      if ((step.touched & ~free) != 0) continue;
      const Voxel next = moved(voxel, step.offset);
      const double cost = best.cost + step.length;
      if (cost >= cost_[grid_.index(next)]) continue;
      cost_[grid_.index(next)] = cost;
      open.push({cost + octile(next, to), cost, grid_.index(next)});
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
