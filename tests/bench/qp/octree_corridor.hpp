#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "harness/random_corridor.hpp"
#include "swiftlet/storage.hpp"
#include "swiftlet/time_allocation.hpp"
#include "swiftlet/window_relaxation.hpp"

namespace swiftlet::bench {

/// Corridors like those of the reference cases: octree cells of edge 0.32 m * 2^k, k = 0 to 4, each sharing a face with
/// the next, sizes drifting by at most two levels, no overlaps; start and goal at rest inside the end cells; v_max and
/// a_max uniform in 1 to 3.
enum class Gates : std::uint8_t { kWindows, kRelaxed };  ///< thin faces, or Sec. IV-E
enum class Times : std::uint8_t { kTrap, kTight };  ///< each leg rest to rest, or 1.05 x the shortest whole profile

struct Corridor {
  std::vector<Box> boxes;
  std::vector<Box> gates;
  std::vector<Real> durations;
  State start;
  State goal;
  Real v_max = 1;
  Real a_max = 1;
  Margins margins;

  [[nodiscard]] TrajectoryProblem problem() const {
    return {.boxes = boxes,
            .gates = gates,
            .durations = durations,
            .start = start,
            .goal = goal,
            .v_max = Vector3::Constant(v_max),
            .a_max = Vector3::Constant(a_max),
            .margins = margins};
  }
};

constexpr std::size_t kMostSegments = 320;
constexpr Real kEdge = Real(0.32);  // [m] of the smallest cell
constexpr int kLevels = 5;

inline TrajectoryStorage<kMostSegments>& shared_storage() {
  static TrajectoryStorage<kMostSegments> storage;
  return storage;
}

/// A cell that shares a face with `from` across its `high` or low side along `axis`; aligned like an octree cell.
inline IntBox neighbour(test::Random& random, const IntBox& from, std::size_t axis, bool high, int edge) {
  IntBox cell{};
  for (std::size_t k = 0; k < 3; ++k) {
    const int from_edge = from.hi[k] - from.lo[k];
    int lo = from.lo[k] / edge * edge;  // the aligned cell around a smaller face
    if (edge < from_edge) lo = from.lo[k] + edge * static_cast<int>(random.below(std::size_t(from_edge / edge)));
    if (k == axis) lo = high ? from.hi[k] : from.lo[k] - edge;
    cell.lo[k] = static_cast<std::uint16_t>(lo);
    cell.hi[k] = static_cast<std::uint16_t>(lo + edge);
  }
  return cell;
}

inline bool overlap(const IntBox& a, const IntBox& b) {
  bool common = true;
  for (std::size_t k = 0; k < 3; ++k) common = common && a.lo[k] < b.hi[k] && b.lo[k] < a.hi[k];
  return common;
}

/// A chain of `count` cells with a drifting heading; starts again when it has walked into a corner.
inline std::vector<IntBox> octree_chain(test::Random& random, std::size_t count) {
  constexpr int kTries = 40;
  constexpr std::uint16_t kMiddle = 32768;
  while (true) {
    int level = static_cast<int>(random.below(kLevels));
    std::vector<IntBox> chain;
    chain.push_back({{kMiddle, kMiddle, kMiddle}, {}});
    for (std::uint16_t& hi : chain[0].hi) hi = static_cast<std::uint16_t>(kMiddle + (1 << level));
    std::size_t axis = random.below(3);
    bool high = random.below(2) == 1;
    for (int attempt = 0; attempt < kTries && chain.size() < count; ++attempt) {
      const bool turn = random.below(10) < 4;
      const std::size_t next_axis = turn ? random.below(3) : axis;
      const bool next_high = turn && next_axis != axis ? random.below(2) == 1 : high;
      const int next_level = std::clamp(level + static_cast<int>(random.below(5)) - 2, 0, kLevels - 1);
      const int edge = 1 << next_level;
      const IntBox& from = chain.back();
      const int face = next_high ? from.hi[next_axis] : from.lo[next_axis];
      if (face % edge != 0) continue;
      const IntBox cell = neighbour(random, from, next_axis, next_high, edge);
      const bool free = std::none_of(chain.begin(), chain.end(), [&](const IntBox& c) { return overlap(c, cell); });
      if (!free) continue;
      chain.push_back(cell);
      axis = next_axis;
      high = next_high;
      level = next_level;
      attempt = 0;
    }
    if (chain.size() == count) return chain;
  }
}

inline Box in_metres(const IntBox& box) {
  Box metres;
  for (std::size_t k = 0; k < 3; ++k) {
    metres.lo[static_cast<Eigen::Index>(k)] = kEdge * static_cast<Real>(box.lo[k] - 32768);
    metres.hi[static_cast<Eigen::Index>(k)] = kEdge * static_cast<Real>(box.hi[k] - 32768);
  }
  return metres;
}

inline void set_cells(Corridor& corridor, const std::vector<IntBox>& cells) {
  corridor.boxes.clear();
  corridor.gates.clear();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    corridor.boxes.push_back(in_metres(cells[i]));
    if (i > 0) corridor.gates.push_back(in_metres(intersection(cells[i - 1], cells[i])));
  }
}

inline Vector3 point_inside(test::Random& random, const Box& box) {
  Vector3 point;
  for (Eigen::Index k = 0; k < 3; ++k) {
    point[k] = box.lo[k] + random.uniform(Real(0.1), Real(0.9)) * (box.hi[k] - box.lo[k]);
  }
  return point;
}

/// The corridor of a seed; false when no stretch of its whole profile is feasible (kTight).
inline bool make_corridor(std::uint64_t seed, std::size_t count, Gates gates, Times times, Corridor& corridor) {
  test::Random random(seed * 1000003 + count);
  std::vector<IntBox> cells = octree_chain(random, count);
  set_cells(corridor, cells);
  corridor.v_max = random.uniform(1, 3);
  corridor.a_max = random.uniform(1, 3);
  corridor.start.position = point_inside(random, corridor.boxes.front());
  corridor.goal.position = point_inside(random, corridor.boxes.back());
  std::vector<Vector3> points{corridor.start.position};
  for (const Box& gate : corridor.gates) points.push_back((gate.lo + gate.hi) / 2);
  points.push_back(corridor.goal.position);
  const SpeedLimits limits{corridor.v_max, corridor.a_max};
  corridor.durations.assign(count, 0);
  if (times == Times::kTrap) {
    for (std::size_t i = 0; i < count; ++i) {
      if (allocate_durations(std::span(points).subspan(i, 2), limits, std::span(corridor.durations).subspan(i, 1)) !=
          Status::kOk) {
        return false;
      }
    }
  } else {
    if (allocate_durations(points, limits, corridor.durations) != Status::kOk) return false;
    std::vector<Segment> segments(count);
    std::vector<Real> scratch(count);
    const Real stretch = smallest_stretch(corridor.problem(), shared_storage().spans(), segments, scratch);
    if (stretch == 0) return false;
    for (Real& duration : corridor.durations) duration *= Real(1.05) * stretch;
  }
  if (gates == Gates::kRelaxed) {
    relax_windows(cells, {});
    set_cells(corridor, cells);
  }
  return true;
}

}  // namespace swiftlet::bench
