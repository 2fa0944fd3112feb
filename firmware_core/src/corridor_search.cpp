#include "swiftlet/corridor_search.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "swiftlet/assert.hpp"
#include "swiftlet/blocked_space.hpp"

namespace swiftlet {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kClosed = kNone;
constexpr Real kMaxWeight = Real(1e6);       // by then the search is greedy; more would only overflow
constexpr std::size_t kFirstTableSize = 64;  // of the hash, which grows with the nodes
// A stored distance and that of the goal are rounded by half a step each; the rest is for float.
constexpr float kRounding = 1.02F;

/// A point in units relative to the map origin. Coordinates of a map are 16-bit integers, so float holds them, their
/// halves and their differences exactly; and it makes the search the same in float and double builds.
struct Point {
  float x, y, z;
};

float distance(const Point& a, const Point& b) {
  const float x = a.x - b.x;
  const float y = a.y - b.y;
  const float z = a.z - b.z;
  return std::sqrt(x * x + y * y + z * z);
}

// ------------------------------------------------------------------------------------------------ where windows are

/// Gives each window the one point that stands for it throughout a query.
class Representative {
 public:
  Representative(bool centre, const Point& start, const Point& goal)
      : centre_(centre), start_(start), along_{goal.x - start.x, goal.y - start.y, goal.z - start.z} {
    const float squared = along_.x * along_.x + along_.y * along_.y + along_.z * along_.z;
    per_length_ = squared > 0 ? 1 / squared : 0;
  }

  [[nodiscard]] Point of(const IntBox& window) const {
    const Point centre = {middle(window, 0), middle(window, 1), middle(window, 2)};
    if (centre_) return centre;
    // Where the line passes the window's centre; shortest paths keep to the side of their windows that faces it.
    const float dot =
        (centre.x - start_.x) * along_.x + (centre.y - start_.y) * along_.y + (centre.z - start_.z) * along_.z;
    const float share = std::clamp(dot * per_length_, 0.0F, 1.0F);
    return {clamp_to(window, 0, start_.x + share * along_.x), clamp_to(window, 1, start_.y + share * along_.y),
            clamp_to(window, 2, start_.z + share * along_.z)};
  }

 private:
  static float middle(const IntBox& box, std::size_t axis) {
    return 0.5F * static_cast<float>(box.lo[axis] + box.hi[axis]);
  }
  static float clamp_to(const IntBox& box, std::size_t axis, float value) {
    return std::clamp(value, static_cast<float>(box.lo[axis]), static_cast<float>(box.hi[axis]));
  }

  bool centre_;
  Point start_;
  Point along_;
  float per_length_;
};

// -------------------------------------------------------------------------------------------------------- landmarks

/// Lower bounds on the way to the goal over window centres by the triangle inequality, |d(l, w) - d(l, goal)|, for the
/// landmarks l of the map (Goldberg and Harrelson, "Computing the shortest path: A* search meets graph theory", 2005).
class LandmarkBound {
 public:
  /// `centres` gives the centre of a window. Without landmarks every bound is zero.
  LandmarkBound(const BoxGraphView& graph, bool used, CellIndex goal_cell, const Point& goal,
                const Representative& centres)
      : count_(used ? graph.header().landmark_count : 0) {
    if (count_ == 0) return;
    step_ = 1 / static_cast<float>(1U << graph.header().landmark_shift);
    to_goal_.fill(std::numeric_limits<float>::infinity());
    for (const CellIndex neighbour : graph.neighbours(goal_cell)) {
      const LandmarkRow row = graph.landmarks(goal_cell, neighbour);
      const IntBox window = intersection(graph.cell(goal_cell), graph.cell(neighbour));
      const float leg = distance(centres.of(window), goal);
      for (std::size_t k = 0; k < count_; ++k) {
        to_goal_[k] = std::min(to_goal_[k], leg + step_ * static_cast<float>(row[k]));
      }
    }
  }

  /// [unit] no way from the window to the goal is shorter; infinite when no window leads to the goal.
  [[nodiscard]] float of(const LandmarkRow& row) const {
    float largest = 0;
    for (std::size_t k = 0; k < count_; ++k) {
      largest = std::max(largest, std::fabs(step_ * static_cast<float>(row[k]) - to_goal_[k]));
    }
    return std::max(largest - kRounding * step_, 0.0F);
  }

  [[nodiscard]] bool is_used() const { return count_ > 0; }

 private:
  std::size_t count_;
  float step_ = 0;
  std::array<float, kMostLandmarks> to_goal_{};
};

// -------------------------------------------------------------------------------------------------------- open list

/// Binary heap of nodes, least priority first, ties by node index. Each node knows its position, so its priority can
/// fall.
class OpenList {
 public:
  OpenList(std::span<OpenEntry> entries, std::span<SearchNode> nodes) : entries_(entries), nodes_(nodes) {}

  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] const OpenEntry& top() const { return entries_[0]; }

  void push(const OpenEntry& entry) { rise(count_++, entry); }
  void lower(const OpenEntry& entry) { rise(nodes_[entry.node].position, entry); }

  std::uint32_t pop() {
    const std::uint32_t node = entries_[0].node;
    nodes_[node].position = kClosed;
    if (--count_ > 0) sink(entries_[count_]);
    return node;
  }

 private:
  static bool precedes(const OpenEntry& a, const OpenEntry& b) {
    return a.priority < b.priority || (a.priority == b.priority && a.node < b.node);
  }
  void place(std::size_t position, const OpenEntry& entry) {
    entries_[position] = entry;
    nodes_[entry.node].position = static_cast<std::uint32_t>(position);
  }
  void rise(std::size_t position, const OpenEntry& entry) {
    while (position > 0 && precedes(entry, entries_[(position - 1) / 2])) {
      place(position, entries_[(position - 1) / 2]);
      position = (position - 1) / 2;
    }
    place(position, entry);
  }
  void sink(const OpenEntry& entry) {
    std::size_t position = 0;
    for (std::size_t child = 1; child < count_; child = 2 * position + 1) {
      if (child + 1 < count_ && precedes(entries_[child + 1], entries_[child])) ++child;
      if (!precedes(entries_[child], entry)) break;
      place(position, entries_[child]);
      position = child;
    }
    place(position, entry);
  }

  std::span<OpenEntry> entries_;
  std::span<SearchNode> nodes_;
  std::size_t count_ = 0;
};

// ------------------------------------------------------------------------------------------------------- node table

/// The reached windows, found by their two cells in either order. Only as much of the hash is used, and cleared, as the
/// nodes ask for: a short search in a large table stays short.
class NodeTable {
 public:
  NodeTable(const SearchScratch& scratch, std::uint32_t start_cell)
      : nodes_(scratch.nodes), hash_(scratch.hash), start_cell_(start_cell) {
    resize(std::min(kFirstTableSize, hash_.size()));
  }

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] bool full() const { return count_ == nodes_.size(); }
  [[nodiscard]] SearchNode& operator[](std::uint32_t node) { return nodes_[node]; }
  [[nodiscard]] std::uint32_t from(const SearchNode& node) const {
    return node.parent == kNone ? start_cell_ : nodes_[node.parent].to;
  }

  /// The node of the window between two cells, or kNone; then `add` puts it in.
  [[nodiscard]] std::uint32_t find(std::uint32_t a, std::uint32_t b) {
    slot_ = home(a, b);
    while (used_[slot_] != kNone && !joins(nodes_[used_[slot_]], a, b)) slot_ = (slot_ + 1) & (used_.size() - 1);
    return used_[slot_];
  }

  /// Puts in a node of the window that the last `find` was for; from now on `find` gives this one. The table must not
  /// be full.
  std::uint32_t add(const SearchNode& node) {
    const auto index = static_cast<std::uint32_t>(count_++);
    nodes_[index] = node;
    used_[slot_] = index;
    if (2 * count_ > used_.size() && used_.size() < hash_.size()) resize(std::min(4 * used_.size(), hash_.size()));
    return index;
  }

 private:
  [[nodiscard]] bool joins(const SearchNode& node, std::uint32_t a, std::uint32_t b) const {
    if (node.to == b) return from(node) == a;
    return node.to == a && from(node) == b;
  }
  [[nodiscard]] std::size_t home(std::uint32_t a, std::uint32_t b) const {
    const std::uint64_t key = (static_cast<std::uint64_t>(std::max(a, b)) << 32U) | std::min(a, b);
    return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15U) >> 32U) & (used_.size() - 1);  // Fibonacci hashing
  }
  void resize(std::size_t size) {
    used_ = hash_.first(size);
    std::fill(used_.begin(), used_.end(), kNone);
    for (std::size_t i = count_; i-- > 0;) {  // the last node of a window comes first
      std::size_t slot = home(from(nodes_[i]), nodes_[i].to);
      while (used_[slot] != kNone) slot = (slot + 1) & (size - 1);
      used_[slot] = static_cast<std::uint32_t>(i);
    }
  }

  std::span<SearchNode> nodes_;
  std::span<std::uint32_t> hash_;
  std::span<std::uint32_t> used_;
  std::uint32_t start_cell_;
  std::size_t count_ = 0;
  std::size_t slot_ = 0;
};

// ----------------------------------------------------------------------------------------------------------- search

/// True when the mode's graph is the paper's, where a window stands for its centre.
bool uses_centres(const BoxGraphView& graph, CellIndex start_cell, SearchMode mode) {
  if (mode != SearchMode::kDefault) return true;
  return graph.header().search_points == static_cast<std::uint32_t>(SearchPoints::kCentres) &&
         graph.has_landmarks(graph.component(start_cell));
}

bool uses_landmarks(const BoxGraphView& graph, CellIndex start_cell, SearchMode mode) {
  return mode != SearchMode::kPlain && uses_centres(graph, start_cell, mode) &&
         graph.has_landmarks(graph.component(start_cell));
}

class Search {
 public:
  Search(const BoxGraphView& graph, CellIndex start_cell, const Vector3& start, CellIndex goal_cell,
         const Vector3& goal, const SearchOptions& options, const SearchScratch& scratch)
      : graph_(graph),
        start_cell_(static_cast<std::uint32_t>(start_cell)),
        goal_cell_(static_cast<std::uint32_t>(goal_cell)),
        start_(to_units(start)),
        goal_(to_units(goal)),
        weight_(static_cast<float>(options.weight)),
        representative_(uses_centres(graph, start_cell, options.mode), start_, goal_),
        bound_(graph, uses_landmarks(graph, start_cell, options.mode), goal_cell, goal_, representative_),
        nodes_(scratch, start_cell_),
        open_(scratch.open, scratch.nodes) {}

  Status run() {
    if (start_cell_ == goal_cell_) return Status::kOk;
    Status status = expand(kNone);
    // Every pass closes a node, so there are no more passes than nodes.
    while (status == Status::kOk && !open_.empty() && open_.top().priority < goal_cost_) {
      ++expanded_;
      status = expand(open_.pop());
    }
    if (status != Status::kOk) return status;
    return last_ == kNone ? Status::kNoPath : Status::kOk;
  }

  Status write_path(std::span<CellIndex> path, std::size_t& path_length) {
    std::size_t length = 1;
    for (std::uint32_t node = last_; node != kNone; node = nodes_[node].parent) ++length;
    if (path.size() < length) return Status::kCorridorCapacity;
    path_length = length;
    for (std::uint32_t node = last_; node != kNone; node = nodes_[node].parent) {
      path[--length] = static_cast<CellIndex>(nodes_[node].to);
    }
    path[0] = static_cast<CellIndex>(start_cell_);
    return Status::kOk;
  }

  /// Summed again in Real along the path, without the rounding of the float costs.
  [[nodiscard]] Real cost(std::span<const CellIndex> path) const {
    const auto leg = [](const Point& a, const Point& b) {
      return Vector3(static_cast<Real>(a.x) - static_cast<Real>(b.x), static_cast<Real>(a.y) - static_cast<Real>(b.y),
                     static_cast<Real>(a.z) - static_cast<Real>(b.z))
          .norm();
    };
    Real sum = 0;
    Point here = start_;
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
      const Point next = representative_.of(intersection(graph_.cell(path[i]), graph_.cell(path[i + 1])));
      sum += leg(here, next);
      here = next;
    }
    return (sum + leg(here, goal_)) * static_cast<Real>(graph_.unit());
  }

  [[nodiscard]] std::uint32_t expanded() const { return expanded_; }
  [[nodiscard]] std::uint32_t reached() const { return static_cast<std::uint32_t>(nodes_.count()); }

 private:
  [[nodiscard]] Point to_units(const Vector3& p_W) const {
    const auto coordinate = [&](Eigen::Index axis) {
      const double offset = static_cast<double>(p_W[axis]) - graph_.header().origin[static_cast<std::size_t>(axis)];
      return static_cast<float>(offset / graph_.unit());
    };
    return {coordinate(0), coordinate(1), coordinate(2)};
  }

  /// Relaxes every window of the cell beyond `node` (the start cell for kNone), and the goal when it lies there.
  Status expand(std::uint32_t node) {
    const bool at_start = node == kNone;
    const std::uint32_t near = at_start ? kNone : nodes_.from(nodes_[node]);
    const std::uint32_t here = at_start ? start_cell_ : nodes_[node].to;
    const float cost = at_start ? 0.0F : nodes_[node].cost;
    const IntBox cell = graph_.cell(static_cast<CellIndex>(here));
    const Point point =
        at_start ? start_ : representative_.of(intersection(graph_.cell(static_cast<CellIndex>(near)), cell));

    if (here == goal_cell_) {  // a cell is convex: no way out of it leads back at less cost
      relax_goal(node, cost + distance(point, goal_));
      return Status::kOk;
    }
    if (graph_.blocked() != nullptr) return expand_pieces(node, near, here, point, cost);
    const NeighbourRange neighbours = graph_.neighbours(static_cast<CellIndex>(here));
    for (NeighbourRange::Iterator at = neighbours.begin(); at != neighbours.end(); ++at) {
      const auto to = static_cast<std::uint32_t>(*at);
      if (to == near) continue;
      const Point next = representative_.of(intersection(cell, graph_.cell(*at)));
      const auto heuristic = [&] { return lower_bound(here, at, next); };
      if (!relax(node, here, to, cost + distance(point, next), heuristic)) return Status::kSearchCapacity;
    }
    return Status::kOk;
  }

  /// The same where cells are cut: neighbours may be pieces, whose windows have no landmark distances.
  Status expand_pieces(std::uint32_t node, std::uint32_t near, std::uint32_t here, const Point& point, float cost) {
    const IntBox cell = graph_.cell(static_cast<CellIndex>(here));
    const auto offer = [&](CellIndex neighbour, const IntBox& box) {
      const auto to = static_cast<std::uint32_t>(neighbour);
      if (to == near) return true;
      const Point next = representative_.of(intersection(cell, box));
      return relax(node, here, to, cost + distance(point, next), [&] { return distance(next, goal_); });
    };
    const bool all_kept = visit_neighbours(graph_, static_cast<CellIndex>(here), offer);
    return all_kept ? Status::kOk : Status::kSearchCapacity;
  }

  void relax_goal(std::uint32_t parent, float cost) {
    if (cost >= goal_cost_) return;
    goal_cost_ = cost;
    last_ = parent;
  }

  /// [unit] no way is shorter from the window between cell `from` and the neighbour that `at` stands on, seen at
  /// `point`, to the goal.
  [[nodiscard]] float lower_bound(std::uint32_t from, const NeighbourRange::Iterator& at, const Point& point) const {
    const float straight = distance(point, goal_);
    if (!bound_.is_used()) return straight;
    const auto cell = static_cast<CellIndex>(from);
    return std::max(straight, bound_.of(*at > cell ? graph_.landmarks(cell, at) : graph_.landmarks(cell, *at)));
  }

  /// Offers a way of `cost` to the window between `from` and `to`; `heuristic()` is what is left to the goal at least.
  /// False when that takes a node and the table is full.
  template <typename Heuristic>
  bool relax(std::uint32_t parent, std::uint32_t from, std::uint32_t to, float cost, const Heuristic& heuristic) {
    const std::uint32_t known = nodes_.find(from, to);
    if (known != kNone && cost >= nodes_[known].cost) return true;
    const float priority = cost + weight_ * heuristic();
    if (priority >= goal_cost_) return true;  // no part of a shorter way
    const bool closed = known != kNone && nodes_[known].position == kClosed;
    // The straight line never drops by more than the way, so what is expanded stays, whatever the weight.
    if (closed && !bound_.is_used()) return true;
    if (known == kNone || closed) {
      // A window that was expanded gets a second node: the first one stays, as its children's way back.
      if (nodes_.full()) return false;
      open_.push({priority, nodes_.add({to, parent, 0, cost})});
      return true;
    }
    SearchNode& node = nodes_[known];
    node.to = to;
    node.parent = parent;
    node.cost = cost;
    open_.lower({priority, known});
    return true;
  }

  const BoxGraphView& graph_;
  std::uint32_t start_cell_;
  std::uint32_t goal_cell_;
  Point start_;
  Point goal_;
  float weight_;
  Representative representative_;
  LandmarkBound bound_;
  NodeTable nodes_;
  OpenList open_;
  float goal_cost_ = std::numeric_limits<float>::infinity();
  std::uint32_t last_ = kNone;  ///< node through which the goal was reached
  std::uint32_t expanded_ = 0;
};

}  // namespace

Status find_cell_path(const BoxGraphView& graph, CellIndex start_cell, const Vector3& start, CellIndex goal_cell,
                      const Vector3& goal, const SearchOptions& options, const SearchScratch& scratch,
                      std::span<CellIndex> path, std::size_t& path_length, SearchReport& report) {
  SWIFTLET_ASSERT(scratch.open.size() >= scratch.nodes.size());
  SWIFTLET_ASSERT(std::has_single_bit(scratch.hash.size()) && scratch.hash.size() >= 2 * scratch.nodes.size());
  path_length = 0;
  report = {};
  if (!(options.weight >= 1 && options.weight <= kMaxWeight)) return Status::kBadRequest;
  if (graph.component(start_cell) != graph.component(goal_cell)) return Status::kNoPath;

  Search search(graph, start_cell, start, goal_cell, goal, options, scratch);
  Status status = search.run();
  report.expanded = search.expanded();
  report.reached = search.reached();
  if (status == Status::kOk) status = search.write_path(path, path_length);
  if (status == Status::kOk) report.cost = search.cost(path.first(path_length));
  return status;
}

}  // namespace swiftlet
