#include "map/free_space.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace swiftlet::tools {
namespace {

constexpr std::uint32_t kMaxUnitShift = 8;
constexpr std::int64_t kMaxUnits = 65'535;
constexpr double kLossAllowed = 0.7;             // of the radius: how much more than it may be inflated along an axis
constexpr double kTwelveDigits = 1e-12;          // relative: such lengths count as equal
constexpr double kMaxGridCells = 8'589'934'592;  // 2^33: 1 GB a grid of bits

/// Voxels of the source map, relative to its low corner.
struct VoxelBox {
  std::array<std::int64_t, 3> lo;
  std::array<std::int64_t, 3> hi;
};

/// The voxels that lie wholly inside the bounds, all of them without bounds.
VoxelBox crop(const VoxelMap& map, const std::optional<std::array<double, 6>>& bounds) {
  constexpr double kRounding = 1e-9;  // of a voxel: bounds given as decimals mean the face that they print
  VoxelBox box{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.hi[axis] = map.size[axis];
    if (!bounds) continue;
    const auto voxels = [&](double x) {
      return std::clamp((x - map.origin[axis]) / map.resolution, -1.0, static_cast<double>(map.size[axis]) + 1);
    };
    box.lo[axis] = std::max<std::int64_t>(box.lo[axis], std::llround(std::ceil(voxels((*bounds)[axis]) - kRounding)));
    box.hi[axis] =
        std::min<std::int64_t>(box.hi[axis], std::llround(std::floor(voxels((*bounds)[axis + 3]) + kRounding)));
  }
  return box;
}

bool fits(const VoxelBox& box, std::uint32_t shift) {
  double cells = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t units = (box.hi[axis] - box.lo[axis]) << shift;
    if (units > kMaxUnits) return false;
    cells *= static_cast<double>(units);
  }
  return cells <= kMaxGridCells;
}

/// Along an axis inflation reaches the radius rounded up to whole units. Halves the unit while that is far more than
/// the radius, as far as the map still fits.
std::uint32_t choose_unit_shift(const VoxelBox& box, double resolution, double radius) {
  std::uint32_t shift = 0;
  const auto loss = [&] {
    const double unit = std::ldexp(resolution, -static_cast<int>(shift));
    return std::ceil(radius / unit * (1 - kTwelveDigits)) * unit - radius;
  };
  while (shift < kMaxUnitShift && loss() > kLossAllowed * radius && fits(box, shift + 1)) ++shift;
  return shift;
}

/// Which offsets between two grid cells are too close: gap(d) = max(0, |d| - 1) on each axis, squared gaps below
/// `limit`.
class Neighbourhood {
 public:
  explicit Neighbourhood(double radius_in_units) {
    const auto limit =
        static_cast<std::int64_t>(std::ceil(radius_in_units * radius_in_units * (1 - 2 * kTwelveDigits)));
    while (limit > 0 && std::int64_t{reach_} * reach_ < limit) ++reach_;  // the largest gap below the radius, plus one
    const auto gap = [](std::int32_t d) { return std::int64_t{std::max(0, d - 1)}; };
    for (std::int32_t dz = 0; dz <= reach_; ++dz) {
      for (std::int32_t dy = 0; dy <= reach_; ++dy) {
        const std::int64_t rest = limit - gap(dy) * gap(dy) - gap(dz) * gap(dz);
        std::int32_t width = rest > 0 ? 1 : -1;
        while (rest > 0 && std::int64_t{width} * width < rest) ++width;
        if (dy == 0 && dz == 0) width = std::max(width, 0);  // an obstacle blocks itself even at radius 0
        widths_.push_back(width);
      }
    }
    distinct_ = widths_;
    std::sort(distinct_.begin(), distinct_.end());
    distinct_.erase(std::unique(distinct_.begin(), distinct_.end()), distinct_.end());
    if (distinct_.front() < 0) distinct_.erase(distinct_.begin());
  }

  [[nodiscard]] std::int32_t reach() const { return reach_; }
  /// Largest |dx| that is too close beside this dy and dz; -1: none is.
  [[nodiscard]] std::int32_t width(std::int32_t dy, std::int32_t dz) const {
    return widths_[static_cast<std::size_t>(std::abs(dz) * (reach_ + 1) + std::abs(dy))];
  }
  [[nodiscard]] const std::vector<std::int32_t>& distinct_widths() const { return distinct_; }

 private:
  std::int32_t reach_ = 0;
  std::vector<std::int32_t> widths_;
  std::vector<std::int32_t> distinct_;
};

using Row = std::vector<BitGrid::Word>;

void or_shifted_up(std::span<const BitGrid::Word> from, std::int32_t bits, std::span<BitGrid::Word> to) {
  const auto words = static_cast<std::size_t>(bits) / 64;
  const int rest = bits % 64;
  for (std::size_t i = from.size(); i-- > words;) {
    BitGrid::Word value = from[i - words] << rest;
    if (rest != 0 && i > words) value |= from[i - words - 1] >> (64 - rest);
    to[i] |= value;
  }
}

void or_shifted_down(std::span<const BitGrid::Word> from, std::int32_t bits, std::span<BitGrid::Word> to) {
  const auto words = static_cast<std::size_t>(bits) / 64;
  const int rest = bits % 64;
  for (std::size_t i = 0; i + words < from.size(); ++i) {
    BitGrid::Word value = from[i + words] >> rest;
    if (rest != 0 && i + words + 1 < from.size()) value |= from[i + words + 1] << (64 - rest);
    to[i] |= value;
  }
}

/// Sets every bit at most `width` from a set one.
void dilate_row(Row& row, std::int32_t width) {
  for (std::int32_t done = 0; done < width;) {
    const std::int32_t step =
        std::min(2 * done + 1, width - done);  // bits within `done` are set: no gaps up to 2 done + 1
    const Row before = row;
    or_shifted_up(before, step, row);
    or_shifted_down(before, step, row);
    done += step;
  }
}

/// A grid with a border all around, so that obstacles outside the mapped box count and no row access needs a check.
struct PaddedGrid {
  PaddedGrid(const Index3& inner, std::int32_t reach)
      : border{(reach + 63) / 64 * 64, reach, reach},
        size(inner),
        bits({inner[0] + 2 * border[0], inner[1] + 2 * border[1], inner[2] + 2 * border[2]}) {}

  [[nodiscard]] GridBox clipped(GridBox box) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.lo[axis] += border[axis];
      box.hi[axis] += border[axis];
    }
    return intersection(box, bits.box());
  }

  Index3 border;
  Index3 size;  ///< without the border
  BitGrid bits;
};

/// The cells of the inner grid that are not too close to any obstacle. Rows are dilated along x once for each distinct
/// width, kept for as many slices as the neighbourhood reaches, and joined across y and z.
BitGrid far_from(const PaddedGrid& obstacles, const Neighbourhood& near, const std::function<void(double)>& done) {
  const std::int32_t reach = near.reach();
  const std::int32_t slices = 2 * reach + 1;
  const std::vector<std::int32_t>& widths = near.distinct_widths();
  const auto rows = static_cast<std::size_t>(obstacles.bits.size()[1]);
  using Slice = std::vector<Row>;  // a row holds its dilations one after the other; empty where it has no obstacle
  std::vector<Slice> ring(static_cast<std::size_t>(slices), Slice(rows));
  std::vector<std::size_t> width_index(static_cast<std::size_t>(reach) + 2);
  for (std::size_t i = 0; i < widths.size(); ++i) width_index[static_cast<std::size_t>(widths[i])] = i;

  const auto fill = [&](std::int32_t z) {
    Slice& slice = ring[static_cast<std::size_t>(z % slices)];
    for (std::size_t y = 0; y < rows; ++y) {
      const auto source = obstacles.bits.row(static_cast<std::int32_t>(y), z);
      Row& target = slice[y];
      target.clear();
      if (std::all_of(source.begin(), source.end(), [](BitGrid::Word word) { return word == 0; })) continue;
      Row row(source.begin(), source.end());
      std::int32_t width = 0;
      for (const std::int32_t next : widths) {
        dilate_row(row, next - width);
        width = next;
        target.insert(target.end(), row.begin(), row.end());
      }
    }
  };

  BitGrid far(obstacles.size);
  const auto first_word = static_cast<std::size_t>(obstacles.border[0]) / 64;
  Row blocked(far.row_words());
  for (std::int32_t z = 0; z < 2 * reach; ++z) fill(z);
  for (std::int32_t z = 0; z < obstacles.size[2]; ++z) {
    fill(z + 2 * reach);
    for (std::int32_t y = 0; y < obstacles.size[1]; ++y) {
      std::fill(blocked.begin(), blocked.end(), 0);
      for (std::int32_t dz = -reach; dz <= reach; ++dz) {
        const Slice& slice = ring[static_cast<std::size_t>((z + reach + dz) % slices)];
        for (std::int32_t dy = -reach; dy <= reach; ++dy) {
          const std::int32_t width = near.width(dy, dz);
          if (width < 0) continue;
          const Row& row = slice[static_cast<std::size_t>(y + reach + dy)];
          if (row.empty()) continue;
          const std::size_t dilation = width_index[static_cast<std::size_t>(width)];
          const BitGrid::Word* words = row.data() + dilation * obstacles.bits.row_words() + first_word;
          for (std::size_t i = 0; i < blocked.size(); ++i) blocked[i] |= words[i];
        }
      }
      far.set({{0, y, z}, {far.size()[0], y + 1, z + 1}});
      const auto row = far.row(y, z);
      for (std::size_t i = 0; i < row.size(); ++i) row[i] &= ~blocked[i];
    }
    done(static_cast<double>(z + 1) / obstacles.size[2]);
  }
  return far;
}

void keep_common(BitGrid& grid, const BitGrid& other) {
  for (std::int32_t z = 0; z < grid.size()[2]; ++z) {
    for (std::int32_t y = 0; y < grid.size()[1]; ++y) {
      const auto row = grid.row(y, z);
      const auto mask = other.row(y, z);
      for (std::size_t i = 0; i < row.size(); ++i) row[i] &= mask[i];
    }
  }
}

/// Keeps only whole blocks of `edge` cells that are free; blocks at the grid's end are cut there.
void keep_whole_blocks(BitGrid& grid, std::int32_t edge) {
  const Index3 size = grid.size();
  for (std::int32_t z = 0; z < size[2]; z += edge) {
    for (std::int32_t y = 0; y < size[1]; y += edge) {
      for (std::int32_t x = 0; x < size[0]; x += edge) {
        const GridBox block = intersection({{x, y, z}, {x + edge, y + edge, z + edge}}, grid.box());
        if (!grid.all_set(block)) grid.clear(block);
      }
    }
  }
}

}  // namespace

Expected<FreeSpace> compute_free_space(const VoxelMap& map, const std::string& source, const MapBuildOptions& options,
                                       const Progress& progress) {
  const VoxelBox voxels = crop(map, options.bounds);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (voxels.lo[axis] >= voxels.hi[axis]) {
      return bad_option("--bounds holds no voxel of " + source + "; choose bounds that overlap the map");
    }
  }
  if (!fits(voxels, 0)) {
    return bad_file(
        source + ": the map is too large (at most 65,535 voxels an axis and 8 billion in all); crop it with --bounds");
  }

  FreeSpace space;
  space.unit_shift = choose_unit_shift(voxels, map.resolution, options.radius);
  const double unit = std::ldexp(map.resolution, -static_cast<int>(space.unit_shift));
  const double reach_in_units = options.radius / unit;
  constexpr double kMaxReach = 64;  // a limit on time and memory: both grow with its square
  if (!(reach_in_units <= kMaxReach)) {
    return bad_option("--radius is over 64 voxels of " + source + "; use a coarser map, or a smaller radius");
  }
  const Neighbourhood near(reach_in_units);

  Index3 size{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    size[axis] = static_cast<std::int32_t>((voxels.hi[axis] - voxels.lo[axis]) << space.unit_shift);
    space.first_voxel[axis] = static_cast<std::int32_t>(voxels.lo[axis]);
    space.origin[axis] = voxels.lo[axis] == 0
                             ? map.origin[axis]
                             : map.origin[axis] + static_cast<double>(voxels.lo[axis]) * map.resolution;
  }
  const auto to_grid = [&](std::size_t axis, std::int64_t voxel) {
    return static_cast<std::int32_t>((voxel - voxels.lo[axis]) * (std::int64_t{1} << space.unit_shift));
  };
  const auto leaf_box = [&](const VoxelLeaf& leaf) {
    GridBox box{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.lo[axis] = to_grid(axis, leaf.lo[axis]);
      box.hi[axis] = to_grid(axis, leaf.lo[axis] + (std::int64_t{1} << leaf.log2_edge));
    }
    return box;
  };

  BitGrid known_free(size);
  PaddedGrid obstacles(size, near.reach());
  for (const VoxelLeaf& leaf : map.leaves) {
    const GridBox box = leaf_box(leaf);
    if (leaf.occupied) {
      obstacles.bits.set(obstacles.clipped(box));
    } else {
      known_free.set(intersection(box, known_free.box()));
    }
  }
  const std::uint64_t known_volume = known_free.count();

  space.free = far_from(obstacles, near, [&](double done) { progress("inflate", done); });
  const std::uint64_t free_without_policy = space.free.count();
  if (options.unknown == UnknownPolicy::kOccupied) {
    GridBox whole{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      whole.lo[axis] = to_grid(axis, 0);
      whole.hi[axis] = to_grid(axis, map.size[axis]);
    }
    BitGrid by_obstacles = std::move(space.free);
    keep_common(by_obstacles, known_free);
    space.lost_to_inflation = known_volume - by_obstacles.count();
    obstacles.bits.set(obstacles.clipped(whole));
    for (const VoxelLeaf& leaf : map.leaves) {
      if (!leaf.occupied) obstacles.bits.clear(obstacles.clipped(leaf_box(leaf)));
    }
    space.free = far_from(obstacles, near, [&](double done) { progress("inflate unknown space", done); });
    keep_common(space.free, known_free);
  } else {
    keep_common(known_free, space.free);
    space.lost_to_inflation = known_volume - known_free.count();
    if (options.unknown == UnknownPolicy::kAvoid) space.free = std::move(known_free);
  }
  const std::uint64_t free_volume = space.free.count();
  space.lost_to_unknown = free_without_policy - free_volume;
  if (options.coarsen > 1) {
    keep_whole_blocks(space.free, options.coarsen << space.unit_shift);
    space.lost_to_coarsening = free_volume - space.free.count();
  }
  return space;
}

}  // namespace swiftlet::tools
