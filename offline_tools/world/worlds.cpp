#include "world/worlds.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <optional>

#include "world/random.hpp"
#include "world/voxel_path.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kSmallVehicle = 0.15;  // [m] radius in maze and classroom

/// The world when its main query joins two roomy voxels, and that query's length [m].
std::optional<double> main_length(const World& world) {
  const std::vector<std::uint8_t> roomy = roomy_voxels(world.grid, world.radius);
  if (roomy[world.grid.index(world.main_start)] == 0 || roomy[world.grid.index(world.main_goal)] == 0) {
    return std::nullopt;
  }
  return VoxelPathFinder(world.grid, world.radius).shortest(world.main_start, world.main_goal);
}

// --- maze: 4 x 4 x 4 rooms behind walls one voxel thick; a random spanning tree of doors and a few loops ---

constexpr int kMazeSize = 32;
constexpr double kMazeResolution = 0.32;      // [m]
constexpr std::size_t kMazeOccupied = 6774;   // paper, Sec. VI
constexpr double kMazeMainLength = 34.4;      // [m] the paper's trajectory
constexpr double kMazeLengthTolerance = 0.5;  // [m] near enough to stop drawing mazes
constexpr int kMazeAttempts = 64;
constexpr int kRooms = 4;                       // along each axis
constexpr int kRoomPitch = kMazeSize / kRooms;  // wall k stands in voxel layer (k + 1) * kRoomPitch - 1
constexpr std::size_t kLoops = 3;               // doors beyond the tree
constexpr int kSmallestDoor = 3;                // [voxels]

using Room = std::array<int, 3>;

struct Door {
  std::size_t axis;  ///< the wall's normal
  Room room;         ///< on the low side
  VoxelBox opening;
};

int room_low(int room) { return room * kRoomPitch; }
int room_high(int room) { return room == kRooms - 1 ? kMazeSize - 1 : (room + 1) * kRoomPitch - 2; }
std::size_t room_index(const Room& room) {
  const int index = (room[2] * kRooms + room[1]) * kRooms + room[0];
  return static_cast<std::size_t>(index);
}

void build_walls(VoxelGrid& grid) {
  for (int wall = 0; wall + 1 < kRooms; ++wall) {
    const int layer = room_high(wall) + 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      VoxelBox box{{0, 0, 0}, {kMazeSize - 1, kMazeSize - 1, kMazeSize - 1}};
      box.lo[axis] = box.hi[axis] = layer;
      grid.fill(box, true);
    }
  }
}

std::vector<Door> all_doors() {
  std::vector<Door> doors;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (int z = 0; z < kRooms; ++z) {
      for (int y = 0; y < kRooms; ++y) {
        for (int x = 0; x < kRooms; ++x) {
          const Room room{x, y, z};
          if (room[axis] + 1 < kRooms) doors.push_back({axis, room, {}});
        }
      }
    }
  }
  return doors;
}

/// Kruskal's algorithm on doors in random order, then the first kLoops of those that it passed over.
std::vector<Door> choose_doors(SplitMix64& random) {
  std::vector<Door> candidates = all_doors();
  random.shuffle(candidates);
  constexpr std::size_t kRoomCount = std::size_t{kRooms} * kRooms * kRooms;
  std::array<std::size_t, kRoomCount> parent{};
  for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = i;
  const auto root = [&](std::size_t room) {
    while (parent[room] != room) room = parent[room];
    return room;
  };
  std::vector<Door> chosen;
  std::vector<Door> passed_over;
  for (const Door& door : candidates) {
    Room beyond = door.room;
    ++beyond[door.axis];
    const std::size_t a = root(room_index(door.room));
    const std::size_t b = root(room_index(beyond));
    (a == b ? passed_over : chosen).push_back(door);
    parent[a] = b;
  }
  chosen.insert(chosen.end(), passed_over.begin(), passed_over.begin() + kLoops);
  return chosen;
}

void open_smallest(Door& door, VoxelGrid& grid, SplitMix64& random) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int room = door.room[axis];
    if (axis == door.axis) {
      door.opening.lo[axis] = door.opening.hi[axis] = room_high(room) + 1;
    } else {
      door.opening.lo[axis] = random.between(room_low(room), room_high(room) - kSmallestDoor + 1);
      door.opening.hi[axis] = door.opening.lo[axis] + kSmallestDoor - 1;
    }
  }
  grid.fill(door.opening, false);
}

/// Widens the door by one row of voxels on a random side, where its room leaves space; opens at most `budget` voxels of
/// that row and returns how many.
std::size_t widen(Door& door, VoxelGrid& grid, SplitMix64& random, std::size_t budget) {
  const std::size_t axis = (door.axis + 1 + random.below(2)) % 3;
  const std::size_t along = 3 - axis - door.axis;
  const bool upwards = random.below(2) == 1;
  const int row = upwards ? door.opening.hi[axis] + 1 : door.opening.lo[axis] - 1;
  if (row < room_low(door.room[axis]) || row > room_high(door.room[axis])) return 0;
  VoxelBox opened = door.opening;
  opened.lo[axis] = opened.hi[axis] = row;
  const auto width = static_cast<std::size_t>(opened.hi[along] - opened.lo[along] + 1);
  if (width > budget) {
    opened.hi[along] = opened.lo[along] + static_cast<int>(budget) - 1;
    grid.fill(opened, false);
    return budget;
  }
  grid.fill(opened, false);
  (upwards ? door.opening.hi : door.opening.lo)[axis] = row;
  return width;
}

World draw_maze(SplitMix64& random) {
  World maze{VoxelGrid({kMazeSize, kMazeSize, kMazeSize}, kMazeResolution), kSmallVehicle, {1, 1, 1}, {}};
  maze.main_goal = {kMazeSize - 2, kMazeSize - 2, kMazeSize - 2};
  build_walls(maze.grid);
  std::vector<Door> doors = choose_doors(random);
  for (Door& door : doors) open_smallest(door, maze.grid, random);
  for (std::size_t left = maze.grid.occupied_count() - kMazeOccupied; left > 0;) {
    left -= widen(doors[random.below(doors.size())], maze.grid, random, left);
  }
  return maze;
}

// --- classroom: furniture that adds up to the paper's scale, anywhere on the floor ---

constexpr Voxel kClassroomSize{13, 10, 5};
constexpr double kClassroomResolution = 0.32;  // [m]
constexpr int kClassroomAttempts = 64;
constexpr std::array<Voxel, 6> kFurniture{{
    {1, 5, 5},  // a screen
    {1, 1, 5},
    {1, 1, 5},
    {1, 1, 5},  // pillars
    {2, 2, 2},  // a table
    {2, 1, 3},  // a shelf
}};

bool is_empty(const VoxelGrid& grid, const VoxelBox& box) {
  for (int y = box.lo[1]; y <= box.hi[1]; ++y) {
    for (int x = box.lo[0]; x <= box.hi[0]; ++x) {
      if (grid.occupied({x, y, box.lo[2]})) return false;  // everything stands on the floor
    }
  }
  return true;
}

World draw_classroom(SplitMix64& random) {
  World room{VoxelGrid(kClassroomSize, kClassroomResolution), kSmallVehicle, {1, 1, 2}, {11, 8, 2}};
  for (const Voxel& piece : kFurniture) {
    VoxelBox place{};
    do {
      place.lo = {random.between(0, kClassroomSize[0] - piece[0]), random.between(0, kClassroomSize[1] - piece[1]), 0};
      place.hi = {place.lo[0] + piece[0] - 1, place.lo[1] + piece[1] - 1, piece[2] - 1};
    } while (!is_empty(room.grid, place));
    room.grid.fill(place, true);
  }
  return room;
}

// --- forest: round trunks from ground to top, clear of the two ends of the main query ---

constexpr Voxel kForestSize{200, 200, 25};
constexpr double kForestResolution = 0.20;  // [m]
constexpr double kForestVehicle = 0.25;     // [m] radius
constexpr int kTrunks = 240;
constexpr int kThickestTrunk = 2;  // [voxels] radius
constexpr Voxel kForestStart{5, 5, 12};
constexpr Voxel kForestGoal{194, 194, 12};
constexpr int kClearing = 8;  // [voxels] around both

void plant(VoxelGrid& grid, int x, int y, int radius) {
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx) {
      const Voxel foot{x + dx, y + dy, 0};
      if (dx * dx + dy * dy > radius * radius || !grid.contains(foot)) continue;
      grid.fill({foot, {foot[0], foot[1], kForestSize[2] - 1}}, true);
    }
  }
}

bool is_near(const Voxel& end, int x, int y) {
  return std::abs(x - end[0]) <= kClearing && std::abs(y - end[1]) <= kClearing;
}

}  // namespace

World make_maze(std::uint64_t seed) {
  SplitMix64 random(seed);
  World best = draw_maze(random);
  double best_error = std::numeric_limits<double>::infinity();
  for (int attempt = 0; attempt < kMazeAttempts && best_error > kMazeLengthTolerance; ++attempt) {
    World maze = draw_maze(random);
    const std::optional<double> length = main_length(maze);  // every maze is connected: doors have room
    const double error = length ? std::abs(*length - kMazeMainLength) : std::numeric_limits<double>::infinity();
    if (error >= best_error) continue;
    best = maze;
    best_error = error;
  }
  return best;
}

World make_classroom(std::uint64_t seed) {
  SplitMix64 random(seed);
  World best = draw_classroom(random);
  double best_length = 0;  // the longest way round its furniture is the most interesting
  for (int attempt = 0; attempt < kClassroomAttempts || best_length == 0; ++attempt) {
    World room = draw_classroom(random);
    const double length = main_length(room).value_or(0);
    if (length <= best_length) continue;
    best = room;
    best_length = length;
  }
  return best;
}

World make_forest(std::uint64_t seed) {
  SplitMix64 random(seed);
  World forest{VoxelGrid(kForestSize, kForestResolution), kForestVehicle, kForestStart, kForestGoal};
  for (int trunk = 0; trunk < kTrunks;) {
    const int x = random.between(0, kForestSize[0] - 1);
    const int y = random.between(0, kForestSize[1] - 1);
    if (is_near(kForestStart, x, y) || is_near(kForestGoal, x, y)) continue;
    plant(forest.grid, x, y, random.between(0, kThickestTrunk));
    ++trunk;
  }
  return forest;
}

std::vector<std::uint8_t> roomy_voxels(const VoxelGrid& grid, double radius) {
  const double unit = grid.resolution() / (radius < grid.resolution() ? 4 : 2);
  const double rounding = std::sqrt(3.0) * unit;  // diagonal of a cube of that edge
  return largest_component(grid, voxels_with_clearance(grid, radius + rounding));
}

std::vector<WorldQuery> make_queries(const World& world, std::uint64_t seed, std::size_t count,
                                     const std::function<void(double)>& progress) {
  const std::vector<std::uint8_t> roomy = roomy_voxels(world.grid, world.radius);
  std::vector<Voxel> ends;
  for (std::size_t i = 0; i < roomy.size(); ++i) {
    if (roomy[i] != 0) ends.push_back(world.grid.voxel(i));
  }
  const auto distance = [&](const Voxel& a, const Voxel& b) {
    const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return std::sqrt(x * x + y * y + z * z) * world.grid.resolution();
  };
  const double shortest_allowed = distance({0, 0, 0}, world.grid.size()) / 4;

  VoxelPathFinder finder(world.grid, world.radius);
  std::vector<WorldQuery> queries;
  const auto add = [&](const Voxel& start, const Voxel& goal) {
    const std::optional<double> astar = finder.shortest(start, goal);
    if (astar) queries.push_back({start, goal, distance(start, goal), *astar});
  };
  SplitMix64 random(~seed);  // apart from the numbers that the world itself took
  add(world.main_start, world.main_goal);
  while (queries.size() < count) {
    const Voxel start = ends[random.below(ends.size())];
    const Voxel goal = ends[random.below(ends.size())];
    if (distance(start, goal) >= shortest_allowed) add(start, goal);
    progress(static_cast<double>(queries.size()) / static_cast<double>(count));
  }
  return queries;
}

std::string queries_csv(const World& world, const std::vector<WorldQuery>& queries) {
  std::string csv = "x0,y0,z0,x1,y1,z1,euclid_m,astar_m\n";
  for (const WorldQuery& query : queries) {
    const std::array<double, 3> start = world.grid.centre(query.start);
    const std::array<double, 3> goal = world.grid.centre(query.goal);
    std::array<char, 256> line{};
    std::snprintf(line.data(), line.size(), "%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f\n", start[0], start[1], start[2],
                  goal[0], goal[1], goal[2], query.euclid, query.astar);
    csv += line.data();
  }
  return csv;
}

}  // namespace swiftlet::tools
