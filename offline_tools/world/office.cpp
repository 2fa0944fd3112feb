#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <vector>

#include "world/random.hpp"
#include "world/voxel_path.hpp"
#include "world/worlds.hpp"

namespace swiftlet::tools {
namespace {

constexpr Voxel kBlock{390, 250, 100};     // an office of scale 1; larger ones are blocks side by side
constexpr double kResolution = 0.20;       // [m]
constexpr std::size_t kOccupied = 259237;  // paper, Sec. VI
constexpr double kRadius = 0.30;           // [m]
constexpr double kMainLength = 42;         // [m] the paper's trajectory
constexpr double kLengthTolerance = 0.5;   // [m] near enough to stop drawing main queries
constexpr int kMainAttempts = 64;

constexpr std::array<int, 3> kFloors{0, 25, 50};  // slabs, one voxel thick; the highest covers the west wing alone
constexpr int kWestWing = 70;
constexpr VoxelBox kAtrium{{90, 76, kFloors[1]}, {319, 174, kFloors[1]}};
constexpr int kSouthWall = 75;  // y of the walls between the rooms on both long sides and the middle
constexpr int kNorthWall = 175;
constexpr std::array<int, 3> kCrossWalls{2, 2, 0};  // on each long side of a floor
constexpr int kTopWall = 52;                        // x of the only wall on the highest floor
constexpr int kTopWallHeight = 15;
constexpr std::array<VoxelBox, 2> kShafts{{{{20, 90, 1}, {39, 104, 65}}, {{20, 140, 1}, {39, 154, 65}}}};
constexpr int kDoorsBetweenBlocks = 3;  // on each floor
constexpr int kDoorWidth = 6;           // 1.2 m
constexpr int kDoorHeight = 11;         // 2.2 m
constexpr Voxel kDesk{8, 4, 4};

/// Between a floor and the one above, both excluded; `floor` is not the highest.
VoxelBox storey(std::size_t floor) {
  return {{0, 0, kFloors[floor] + 1}, {kBlock[0] - 1, kBlock[1] - 1, kFloors[floor + 1] - 1}};
}

void build_slabs(VoxelGrid& grid) {
  for (const int z : kFloors) {
    const int east = z == kFloors[2] ? kWestWing : kBlock[0];
    grid.fill({{0, 0, z}, {east - 1, kBlock[1] - 1, z}}, true);
  }
  grid.fill(kAtrium, false);
}

/// An opening in a wall of constant `axis` coordinate, from its floor up.
void open_door(VoxelGrid& grid, std::size_t axis, int wall, int along, int floor) {
  VoxelBox door{{along, along, floor + 1}, {along + kDoorWidth - 1, along + kDoorWidth - 1, floor + kDoorHeight}};
  door.lo[axis] = door.hi[axis] = wall;
  grid.fill(door, false);
}

/// Rooms in a row along one long side of the building: a wall, cross walls near even spacing, a door each.
void build_rooms(VoxelGrid& grid, SplitMix64& random, std::size_t floor, bool north) {
  const int wall = north ? kNorthWall : kSouthWall;
  VoxelBox long_wall = storey(floor);
  long_wall.lo[1] = long_wall.hi[1] = wall;
  grid.fill(long_wall, true);
  const int rooms = kCrossWalls[floor] + 1;
  int west = 0;
  for (int room = 1; room <= rooms; ++room) {
    const int east = room == rooms ? kBlock[0] : kBlock[0] * room / rooms + random.between(-20, 20);
    if (room < rooms) {
      VoxelBox cross = storey(floor);
      cross.lo[0] = cross.hi[0] = east;
      cross.lo[1] = north ? wall : 0;
      cross.hi[1] = north ? kBlock[1] - 1 : wall;
      grid.fill(cross, true);
    }
    open_door(grid, 1, wall, random.between(west + 5, east - kDoorWidth - 5), kFloors[floor]);
    west = east;
  }
}

void build_top_wall(VoxelGrid& grid, SplitMix64& random) {
  grid.fill({{kTopWall, 0, kFloors[2] + 1}, {kTopWall, kBlock[1] - 1, kFloors[2] + kTopWallHeight}}, true);
  open_door(grid, 0, kTopWall, random.between(5, kBlock[1] / 2), kFloors[2]);
  open_door(grid, 0, kTopWall, random.between(kBlock[1] / 2, kBlock[1] - kDoorWidth - 5), kFloors[2]);
}

/// A stair shaft through all floors, without its stairs, with a door to the east on each floor.
void build_shaft(VoxelGrid& grid, const VoxelBox& inside) {
  const VoxelBox outside{{inside.lo[0] - 1, inside.lo[1] - 1, inside.lo[2]},
                         {inside.hi[0] + 1, inside.hi[1] + 1, inside.hi[2]}};
  grid.fill(outside, true);
  grid.fill(inside, false);
  for (const int floor : kFloors) open_door(grid, 0, inside.hi[0] + 1, inside.lo[1] + 4, floor);
}

/// Empty, and with a floor below all of it.
bool can_stand(const VoxelGrid& grid, const VoxelBox& box) {
  for (int y = box.lo[1]; y <= box.hi[1]; ++y) {
    for (int x = box.lo[0]; x <= box.hi[0]; ++x) {
      if (grid.occupied({x, y, box.lo[2]}) || !grid.occupied({x, y, box.lo[2] - 1})) return false;
    }
  }
  return true;
}

/// Desks anywhere on the floors, the last one cut, until the block has its number of voxels.
void furnish(VoxelGrid& grid, SplitMix64& random) {
  for (std::size_t left = kOccupied - grid.occupied_count(); left > 0;) {
    Voxel size = kDesk;
    if (random.below(2) == 1) std::swap(size[0], size[1]);
    if (left < static_cast<std::size_t>(size[0] * size[1] * size[2])) size = {1, 1, 1};
    VoxelBox place{};
    do {
      place.lo = {random.between(0, kBlock[0] - size[0]), random.between(0, kBlock[1] - size[1]),
                  kFloors[random.below(kFloors.size())] + 1};
      place.hi = {place.lo[0] + size[0] - 1, place.lo[1] + size[1] - 1, place.lo[2] + size[2] - 1};
    } while (!can_stand(grid, place));
    grid.fill(place, true);
    left -= static_cast<std::size_t>(size[0] * size[1] * size[2]);
  }
}

/// From the ground floor to a higher one, by a path of about the paper's length.
void choose_main_query(World& office, SplitMix64& random) {
  const std::vector<std::uint8_t> roomy = roomy_voxels(office.grid, office.radius);
  const auto draw = [&](int z_low, int z_high) {
    Voxel voxel{};
    do {
      voxel = {random.between(0, office.grid.size()[0] - 1), random.between(0, office.grid.size()[1] - 1),
               random.between(z_low, z_high)};
    } while (roomy[office.grid.index(voxel)] == 0);
    return voxel;
  };
  VoxelPathFinder finder(office.grid, office.radius);
  double best_error = std::numeric_limits<double>::infinity();
  for (int attempt = 0; attempt < kMainAttempts && best_error > kLengthTolerance; ++attempt) {
    const Voxel start = draw(kFloors[0] + 1, kFloors[0] + kDoorHeight);
    const Voxel goal = draw(kFloors[1] + 1, kFloors[1] + kDoorHeight);
    const double straight = kResolution * std::hypot(start[0] - goal[0], start[1] - goal[1], start[2] - goal[2]);
    if (straight < kMainLength / 2 || straight > kMainLength) {
      --attempt;  // costs nothing
      continue;
    }
    const std::optional<double> length = finder.shortest(start, goal);
    const double error = length ? std::abs(*length - kMainLength) : std::numeric_limits<double>::infinity();
    if (error >= best_error) continue;
    office.main_start = start;
    office.main_goal = goal;
    best_error = error;
  }
}

/// Blocks along x and y: near a square whatever the scale.
std::array<int, 2> blocks_along(std::size_t scale) { return {scale < 4 ? 1 : 2, scale == 1 ? 1 : scale == 8 ? 4 : 2}; }

VoxelGrid build_block(SplitMix64& random) {
  VoxelGrid block(kBlock, kResolution);
  build_slabs(block);
  for (const std::size_t floor : {0U, 1U}) {
    for (const bool north : {false, true}) build_rooms(block, random, floor, north);
  }
  build_top_wall(block, random);
  for (const VoxelBox& shaft : kShafts) build_shaft(block, shaft);
  furnish(block, random);
  return block;
}

void copy_block(const VoxelGrid& block, const Voxel& corner, VoxelGrid& grid) {
  for (std::size_t i = 0; i < block.voxel_count(); ++i) {
    const Voxel from = block.voxel(i);
    const Voxel to{corner[0] + from[0], corner[1] + from[1], corner[2] + from[2]};
    if (block.occupied(from)) grid.fill({to, to}, true);
  }
}

/// A wall across the rooms on both long sides of every block; the middle stays open from block to block.
void part_rooms(VoxelGrid& grid, int x) {
  for (int block_low = 0; block_low < grid.size()[1]; block_low += kBlock[1]) {
    for (const std::size_t floor : {0U, 1U}) {
      VoxelBox wall = storey(floor);
      wall.lo[0] = wall.hi[0] = x;
      wall.lo[1] = block_low;
      wall.hi[1] = block_low + kSouthWall;
      grid.fill(wall, true);
      wall.lo[1] = block_low + kNorthWall;
      wall.hi[1] = block_low + kBlock[1] - 1;
      grid.fill(wall, true);
    }
  }
}

/// A wall between rooms back to back, with a few doors a block.
void part_blocks(VoxelGrid& grid, SplitMix64& random, int y) {
  for (int block_low = 0; block_low < grid.size()[0]; block_low += kBlock[0]) {
    for (const std::size_t floor : {0U, 1U}) {
      VoxelBox wall = storey(floor);
      wall.lo[0] = block_low;
      wall.hi[0] = block_low + kBlock[0] - 1;
      wall.lo[1] = wall.hi[1] = y;
      grid.fill(wall, true);
      for (int door = 0; door < kDoorsBetweenBlocks; ++door) {
        open_door(grid, 1, y, random.between(wall.lo[0] + 5, wall.hi[0] - kDoorWidth - 5), kFloors[floor]);
      }
    }
  }
}

}  // namespace

World make_office(std::uint64_t seed, std::size_t scale) {
  SplitMix64 random(seed);
  const std::array<int, 2> blocks = blocks_along(scale);
  World office{VoxelGrid({blocks[0] * kBlock[0], blocks[1] * kBlock[1], kBlock[2]}, kResolution), kRadius, {}, {}};
  for (int y = 0; y < blocks[1]; ++y) {
    for (int x = 0; x < blocks[0]; ++x) copy_block(build_block(random), {x * kBlock[0], y * kBlock[1], 0}, office.grid);
  }
  for (int x = 1; x < blocks[0]; ++x) part_rooms(office.grid, x * kBlock[0]);
  for (int y = 1; y < blocks[1]; ++y) part_blocks(office.grid, random, y * kBlock[1]);
  choose_main_query(office, random);
  return office;
}

}  // namespace swiftlet::tools
