#include "world/voxel_path.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace swiftlet::tools {
namespace {

constexpr double kEdge = 4294967296.0;  // one voxel edge in fixed point: a path of 2^16 steps is exact to 2^-17
constexpr int kBucketShift = 26;        // buckets of 1/64 edge
constexpr std::int64_t kUnreached = std::numeric_limits<std::int64_t>::max();

constexpr std::size_t kTileEdge = 8;
constexpr std::size_t kTileVoxels = kTileEdge * kTileEdge * kTileEdge;

constexpr unsigned kStepCount = 27;  // the standstill in the middle included
constexpr unsigned kStart = 13;      // it: no step led here
constexpr std::uint32_t kAll = (std::uint32_t{1} << kStepCount) - 1;

/// The length of a step that changes 1, 2 or 3 coordinates.
std::int64_t step_length(int axes) { return std::llround(kEdge * std::sqrt(static_cast<double>(axes))); }

constexpr std::uint32_t bit(unsigned number) { return std::uint32_t{1} << number; }

unsigned number_of(const Voxel& offset) {
  return static_cast<unsigned>((offset[2] + 1) * 9 + (offset[1] + 1) * 3 + offset[0] + 1);
}

bool is_step(const Voxel& offset) {
  return std::all_of(offset.begin(), offset.end(), [](int d) { return d >= -1 && d <= 1; });
}

Voxel moved(const Voxel& voxel, const Voxel& step) {
  return {voxel[0] + step[0], voxel[1] + step[1], voxel[2] + step[2]};
}

Voxel difference(const Voxel& a, const Voxel& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

struct Step {
  Voxel offset;
  int axes;  ///< how many coordinates it changes
  std::int64_t length;
};

std::array<Step, kStepCount> all_steps() {
  std::array<Step, kStepCount> steps{};
  for (int i = 0; i < static_cast<int>(kStepCount); ++i) {
    const Voxel offset{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
    const int axes = std::abs(offset[0]) + std::abs(offset[1]) + std::abs(offset[2]);
    steps[static_cast<std::size_t>(i)] = {offset, axes, step_length(axes)};
  }
  return steps;
}

const std::array<Step, kStepCount> kSteps = all_steps();

/// Whether the step from offset `from` to `to`, both of the 27 voxels around one, touches free voxels only: a diagonal
/// touches all voxels of the box that it crosses.
bool is_allowed(std::uint32_t free, const Voxel& from, const Voxel& to) {
  for (int z = std::min(from[2], to[2]); z <= std::max(from[2], to[2]); ++z) {
    for (int y = std::min(from[1], to[1]); y <= std::max(from[1], to[1]); ++y) {
      for (int x = std::min(from[0], to[0]); x <= std::max(from[0], to[0]); ++x) {
        if ((free & bit(number_of({x, y, z}))) == 0) return false;
      }
    }
  }
  return true;
}

/// Whether a way from offset `from` to offset `to` round the middle makes the one through it, by the steps `first` and
/// `second`, needless: it is shorter, or as long and more diagonal in its first step. Of all shortest paths the one
/// that is most diagonal at the earliest step is never needless anywhere, so that one is always found.
bool is_needless(std::uint32_t free, const Step& first, const Step& second) {
  const Voxel from = difference({0, 0, 0}, first.offset);
  const Voxel& to = second.offset;
  if (is_step(difference(to, from)) && is_allowed(free, from, to)) return true;
  return std::any_of(kSteps.begin(), kSteps.end(), [&](const Step& detour) {
    const Voxel middle = moved(from, detour.offset);
    const Voxel rest = difference(to, middle);
    if (!is_step(middle) || !is_step(rest)) return false;
    const std::int64_t length = detour.length + kSteps[number_of(rest)].length;
    const std::int64_t through = first.length + second.length;
    const bool better = length < through || (length == through && detour.axes > first.axes);
    return better && is_allowed(free, from, middle) && is_allowed(free, middle, to);
  });
}

/// The steps that are worth following from a voxel with these free voxels around, entered by the step `arrival`.
std::uint32_t canonical_steps(std::uint32_t free, unsigned arrival) {
  std::uint32_t worthwhile = 0;
  for (unsigned i = 0; i < kStepCount; ++i) {
    if (i == kStart || !is_allowed(free, {0, 0, 0}, kSteps[i].offset)) continue;
    if (arrival == kStart || !is_needless(free, kSteps[arrival], kSteps[i])) worthwhile |= bit(i);
  }
  return worthwhile;
}

std::int64_t octile(const Voxel& a, const Voxel& b) {
  static const std::array<std::int64_t, 3> lengths{step_length(1), step_length(2), step_length(3)};
  std::array<int, 3> d{std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])};
  std::sort(d.begin(), d.end());
  return lengths[2] * d[0] + lengths[1] * (d[1] - d[0]) + lengths[0] * (d[2] - d[1]);
}

/// The voxels of a mask whose 26 neighbours are in it as well, by one axis after the other.
std::vector<std::uint8_t> voxels_amid(const VoxelGrid& grid, std::vector<std::uint8_t> mask) {
  const std::array<std::size_t, 3> strides{grid.index({1, 0, 0}), grid.index({0, 1, 0}), grid.index({0, 0, 1})};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto count = static_cast<std::size_t>(grid.size()[axis]);
    const std::vector<std::uint8_t> before = mask;
    for (std::size_t i = 0; i < mask.size(); ++i) {
      const std::size_t along = i / strides[axis] % count;
      const bool amid =
          along > 0 && along + 1 < count && before[i - strides[axis]] != 0 && before[i + strides[axis]] != 0;
      if (!amid) mask[i] = 0;
    }
  }
  return mask;
}

std::size_t bucket_of(std::int64_t priority) { return static_cast<std::size_t>(priority >> kBucketShift); }

}  // namespace

VoxelPathFinder::VoxelPathFinder(const VoxelGrid& grid, double radius) : grid_(grid) {
  std::array<std::size_t, 3> tile_counts{};
  std::size_t tile_stride = kTileVoxels;
  std::size_t stride = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto padded = static_cast<std::size_t>(grid.size()[axis]) + 2;
    for (std::size_t i = 0; i < padded; ++i) {
      terms_[axis].push_back(i / kTileEdge * tile_stride + i % kTileEdge * stride);
    }
    tile_counts[axis] = (padded + kTileEdge - 1) / kTileEdge;
    tile_stride *= tile_counts[axis];
    stride *= kTileEdge;
  }
  space_.assign(tile_stride, Space::kBlocked);
  tiles_.resize(tile_stride / kTileVoxels);

  const std::vector<std::uint8_t> free = voxels_with_clearance(grid, radius);
  const std::vector<std::uint8_t> open = voxels_amid(grid, free);
  std::size_t i = 0;
  const Voxel& size = grid.size();
  for (int z = 0; z < size[2]; ++z) {
    for (int y = 0; y < size[1]; ++y) {
      for (int x = 0; x < size[0]; ++x, ++i) {
        if (free[i] != 0) space_[index({x, y, z})] = open[i] != 0 ? Space::kOpen : Space::kFree;
      }
    }
  }
}

VoxelPathFinder::Directions VoxelPathFinder::free_around(const Voxel& voxel) const {
  Directions free = 0;
  for (unsigned i = 0; i < kStepCount; ++i) {
    if (space_[index(moved(voxel, kSteps[i].offset))] != Space::kBlocked) free |= bit(i);
  }
  return free;
}

VoxelPathFinder::Directions VoxelPathFinder::steps_on(const Voxel& voxel, Directions arrivals) {
  const bool is_open = space_[index(voxel)] == Space::kOpen;
  const Directions free = is_open ? kAll : free_around(voxel);
  Directions worthwhile = 0;
  for (; arrivals != 0; arrivals &= arrivals - 1) {
    const auto arrival = static_cast<unsigned>(std::countr_zero(arrivals));
    const auto [entry, is_new] = known_steps_.try_emplace(std::uint64_t{free} * kStepCount + arrival, 0);
    if (is_new) entry->second = canonical_steps(free, arrival);
    worthwhile |= entry->second;
  }
  return worthwhile;
}

VoxelPathFinder::Node& VoxelPathFinder::node(std::size_t index) {
  std::unique_ptr<Node[]>& tile = tiles_[index / kTileVoxels];
  if (!tile) {
    tile = std::make_unique<Node[]>(kTileVoxels);
    std::fill_n(tile.get(), kTileVoxels, Node{kUnreached, 0, 0});
  }
  return tile[index % kTileVoxels];
}

void VoxelPathFinder::push(const Open& open) {
  const std::size_t bucket = bucket_of(open.priority);
  if (buckets_.size() <= bucket) buckets_.resize(bucket + 1);
  buckets_[bucket].push_back(open);
}

void VoxelPathFinder::relax(const Voxel& voxel, std::int64_t cost, Directions arrival, const Voxel& to) {
  Node& reached = node(index(voxel));
  if (cost > reached.cost || (cost == reached.cost && (reached.arrivals & arrival) != 0)) return;
  if (cost < reached.cost) reached = {cost, 0, 0};
  reached.arrivals |= arrival;
  push({cost, cost + octile(voxel, to), voxel});
}

std::optional<double> VoxelPathFinder::shortest(const Voxel& from, const Voxel& to) {
  const std::size_t goal = index(to);
  if (space_[index(from)] == Space::kBlocked || space_[goal] == Space::kBlocked) return std::nullopt;

  for (std::unique_ptr<Node[]>& tile : tiles_) tile.reset();
  buckets_.clear();
  relax(from, 0, bit(kStart), to);
  for (std::size_t bucket = 0; bucket < buckets_.size(); ++bucket) {
    // A bucket is not sorted, so a voxel may be followed on before its best path is known, and then again. The goal is
    // settled once nothing is left that could still lead to a shorter path.
    while (!buckets_[bucket].empty()) {
      const Open best = buckets_[bucket].back();
      buckets_[bucket].pop_back();
      Node& here = node(index(best.voxel));
      const Directions arrivals = here.arrivals & ~here.expanded;
      if (best.cost > here.cost || arrivals == 0 || best.priority >= node(goal).cost) continue;
      here.expanded |= arrivals;
      for (Directions rest = steps_on(best.voxel, arrivals); rest != 0; rest &= rest - 1) {
        const auto step = static_cast<unsigned>(std::countr_zero(rest));
        relax(moved(best.voxel, kSteps[step].offset), best.cost + kSteps[step].length, bit(step), to);
      }
    }
    const std::int64_t found = node(goal).cost;
    if (found != kUnreached && bucket >= bucket_of(found)) {
      return static_cast<double>(found) / kEdge * grid_.resolution();
    }
  }
  return std::nullopt;
}

std::vector<std::uint8_t> largest_component(const VoxelGrid& grid, const std::vector<std::uint8_t>& allowed) {
  const std::array<std::size_t, 3> strides{grid.index({1, 0, 0}), grid.index({0, 1, 0}), grid.index({0, 0, 1})};
  std::vector<std::uint8_t> open = allowed;  // and not yet in a component
  std::vector<std::size_t> largest;
  for (std::size_t seed = 0; seed < open.size(); ++seed) {
    if (open[seed] == 0) continue;
    std::vector<std::size_t> component{seed};
    open[seed] = 0;
    const auto add = [&](std::size_t voxel) {
      if (open[voxel] == 0) return;
      open[voxel] = 0;
      component.push_back(voxel);
    };
    for (std::size_t i = 0; i < component.size(); ++i) {
      const std::size_t voxel = component[i];
      const Voxel position = grid.voxel(voxel);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (position[axis] > 0) add(voxel - strides[axis]);
        if (position[axis] + 1 < grid.size()[axis]) add(voxel + strides[axis]);
      }
    }
    if (component.size() > largest.size()) largest.swap(component);
  }
  std::vector<std::uint8_t> mask(grid.voxel_count(), 0);
  for (const std::size_t index : largest) mask[index] = 1;
  return mask;
}

}  // namespace swiftlet::tools
