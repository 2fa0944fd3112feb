#include "map/partition.hpp"

#include <algorithm>
#include <bit>
#include <queue>
#include <utility>

namespace swiftlet::tools {
namespace {

/// Axes that grow together, as bits; a growth order lists such groups, each grown until it is stuck before the next.
using AxisGroup = unsigned;
constexpr AxisGroup kX = 1;
constexpr AxisGroup kY = 2;
constexpr AxisGroup kZ = 4;
using GrowthOrder = std::array<AxisGroup, 3>;
constexpr std::array<GrowthOrder, 7> kGrowthOrders{{
    {kX | kY | kZ, 0, 0},
    {kX | kY, kZ, 0},
    {kZ, kX | kY, 0},
    {kX, kY | kZ, 0},
    {kY, kX | kZ, 0},
    {kX | kZ, kY, 0},
    {kY | kZ, kX, 0},
}};

/// Grows one face by `step` cells when the slab before it is free.
bool grow_face(const BitGrid& free, std::size_t axis, bool high, std::int32_t step, GridBox& box) {
  GridBox slab = box;
  if (high) {
    slab.lo[axis] = box.hi[axis];
    slab.hi[axis] = box.hi[axis] + step;
    if (slab.hi[axis] > free.size()[axis]) return false;
  } else {
    slab.hi[axis] = box.lo[axis];
    slab.lo[axis] = box.lo[axis] - step;
    if (slab.lo[axis] < 0) return false;
  }
  if (!free.all_set(slab)) return false;
  (high ? box.hi : box.lo)[axis] += high ? step : -step;
  return true;
}

constexpr std::int32_t kLargestStep = 64;  // a word: thicker slabs cost no less a cell

/// Faces of the group in turn, in steps that halve once none of them succeeds: every free cell is looked at once or
/// twice and a slab along x costs a word operation for up to 64 cells.
void grow_group(const BitGrid& free, AxisGroup group, GridBox& box) {
  for (std::int32_t step = kLargestStep; step > 0; step /= 2) {
    for (bool grown = true; grown;) {
      grown = false;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if ((group >> axis & 1U) == 0) continue;
        grown |= grow_face(free, axis, false, step, box);
        grown |= grow_face(free, axis, true, step, box);
      }
    }
  }
}

}  // namespace

GridBox grow(const BitGrid& free, const GridBox& seed) {
  GridBox best = seed;
  std::uint64_t best_volume = 0;
  for (const GrowthOrder& order : kGrowthOrders) {
    GridBox box = seed;
    for (const AxisGroup group : order) grow_group(free, group, box);
    if (volume(box) <= best_volume) continue;
    best = box;
    best_volume = volume(box);
  }
  return best;
}

std::vector<GridBox> octree_leaves(const BitGrid& free, const std::array<std::int64_t, 3>& key) {
  // From the largest cube that any axis could hold downwards; a cube is a leaf when it is free and not yet taken.
  std::vector<GridBox> leaves;
  BitGrid rest = free;
  std::int32_t edge = 1;
  while (edge < *std::max_element(free.size().begin(), free.size().end())) edge *= 2;
  for (; edge > 0; edge /= 2) {
    Index3 first{};  // low corner of the aligned cube that holds the grid's low corner, at most zero
    for (std::size_t axis = 0; axis < 3; ++axis) first[axis] = -static_cast<std::int32_t>(key[axis] % edge);
    for (std::int32_t z = first[2]; z < free.size()[2]; z += edge) {
      for (std::int32_t y = first[1]; y < free.size()[1]; y += edge) {
        for (std::int32_t x = first[0]; x < free.size()[0]; x += edge) {
          const GridBox cube{{x, y, z}, {x + edge, y + edge, z + edge}};
          if (intersection(cube, free.box()) != cube || !rest.all_set(cube)) continue;
          rest.clear(cube);
          leaves.push_back(cube);
        }
      }
    }
  }
  return leaves;
}

namespace {

/// A box that could be taken, grown from a seed; the largest comes first, ties go to the earlier seed.
struct Candidate {
  GridBox box;
  GridBox seed;
  std::size_t order;
  bool operator<(const Candidate& other) const {
    return volume(box) != volume(other.box) ? volume(box) < volume(other.box) : order > other.order;
  }
};

/// Takes boxes out of a grid until it is empty. Seeds are cubes of a power of two; those of one size are dealt with
/// before the smaller ones, so large boxes come first without growing one from every leaf.
class BoxTaker {
 public:
  explicit BoxTaker(const BitGrid& free) : rest_(free) {}

  void add_seed(const GridBox& cube) { seeds_[log2_edge(cube)].push_back(cube); }

  std::vector<GridBox> take_all(const std::function<void(double)>& done) {
    const double total = static_cast<double>(std::max<std::uint64_t>(rest_.count(), 1));
    for (std::size_t level = seeds_.size(); level-- > 0;) {
      while (!seeds_[level].empty()) {
        queue_candidates(level);
        take_candidates();
        done(static_cast<double>(taken_) / total);
      }
    }
    return std::move(boxes_);
  }

 private:
  static std::size_t log2_edge(const GridBox& cube) {
    return static_cast<std::size_t>(std::countr_zero(static_cast<std::uint32_t>(cube.hi[0] - cube.lo[0])));
  }

  /// Grows a box from every seed of the level that no other such box covers; the covered ones wait for the next round.
  void queue_candidates(std::size_t level) {
    std::vector<GridBox> waiting;
    BitGrid uncovered = rest_;
    for (const GridBox& seed : std::exchange(seeds_[level], {})) {
      if (uncovered.all_set(seed)) {
        uncovered.clear(queue_candidate(seed));
      } else if (rest_.all_set(seed)) {
        waiting.push_back(seed);
      } else {
        split(seed);
      }
    }
    seeds_[level] = std::move(waiting);
  }

  GridBox queue_candidate(const GridBox& seed) {
    const GridBox box = grow(rest_, seed);
    queue_.push({box, seed, order_++});
    return box;
  }

  /// Takes the largest candidate; one that has lost a part to an earlier box grows anew and queues again.
  void take_candidates() {
    while (!queue_.empty()) {
      const Candidate candidate = queue_.top();
      queue_.pop();
      if (rest_.all_set(candidate.box)) {
        rest_.clear(candidate.box);
        taken_ += volume(candidate.box);
        boxes_.push_back(candidate.box);
      } else if (rest_.all_set(candidate.seed)) {
        queue_candidate(candidate.seed);
      } else {
        split(candidate.seed);
      }
    }
  }

  /// A seed that was partly taken: of its eight parts those that are not wholly taken become seeds of the next level.
  void split(const GridBox& seed) {
    const std::int32_t half = (seed.hi[0] - seed.lo[0]) / 2;
    if (half == 0) return;
    for (unsigned child = 0; child < 8; ++child) {
      GridBox part = seed;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        part.lo[axis] += (child >> axis & 1U) != 0 ? half : 0;
        part.hi[axis] = part.lo[axis] + half;
      }
      if (!rest_.none_set(part)) add_seed(part);  // without this memory would follow the volume
    }
  }

  BitGrid rest_;
  std::array<std::vector<GridBox>, 32> seeds_;  ///< by log2 of the edge
  std::priority_queue<Candidate> queue_;
  std::size_t order_ = 0;
  std::vector<GridBox> boxes_;
  std::uint64_t taken_ = 0;
};

}  // namespace

std::vector<GridBox> merged_boxes(const BitGrid& free, const std::array<std::int64_t, 3>& key,
                                  const std::function<void(double)>& done) {
  BoxTaker taker(free);
  for (const GridBox& leaf : octree_leaves(free, key)) taker.add_seed(leaf);
  return taker.take_all(done);
}

}  // namespace swiftlet::tools
