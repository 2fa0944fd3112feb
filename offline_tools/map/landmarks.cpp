#include "map/landmarks.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>

#include "swiftlet/corridor.hpp"
#include "swiftlet/corridor_search.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kSpreadCandidates = 8;
constexpr std::size_t kCandidates = 64;
constexpr std::size_t kSamplePairs = 3000;
// How much longer taut paths may be over window centres than along the straight line, on random pairs. Measured on 256
// pairs, mean and 95 %: a scanned floor 1.002 and 1.011, with 0.28 of the expansions; open worlds 1.010
// and 1.067, 1.013 and 1.085.
constexpr int kPairs = 128;
constexpr double kMeanDetour = 1.005;
constexpr double kLongDetour = 1.05;
constexpr int kLongDetours = kPairs / 100;

using Distances = std::vector<double>;
using Point = std::array<double, 3>;

/// SplitMix64, the same on every machine.
class Random {
 public:
  std::uint64_t below(std::uint64_t end) {
    std::uint64_t x = state_ += 0x9E3779B97F4A7C15U;
    x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9U;
    x = (x ^ x >> 27) * 0x94D049BB133111EBU;
    return (x ^ x >> 31) % end;
  }

 private:
  std::uint64_t state_ = 1;
};

/// Shortest paths from one window.
struct Tree {
  std::vector<std::uint32_t> order;  ///< by distance
  std::vector<std::uint32_t> parent;
};

/// The windows of component 0 at their centres; windows of one cell are joined by straight legs.
class CentreGraph {
 public:
  CentreGraph(const std::vector<GridBox>& cells, std::span<const std::pair<std::uint32_t, std::uint32_t>> windows,
              const std::vector<std::uint16_t>& labels)
      : first_(cells.size() + 1) {
    for (const auto& window : windows) {
      if (labels[window.first] != 0) continue;
      const GridBox box = intersection(cells[window.first], cells[window.second]);
      Point centre{};
      for (std::size_t axis = 0; axis < 3; ++axis) centre[axis] = 0.5 * (box.lo[axis] + box.hi[axis]);
      centres_.push_back(centre);
      sides_.push_back(window);
      ++first_[window.first + 1];
      ++first_[window.second + 1];
    }
    for (std::size_t cell = 0; cell < cells.size(); ++cell) first_[cell + 1] += first_[cell];
    of_cell_.resize(2 * centres_.size());
    std::vector<std::uint32_t> end(first_.begin(), first_.end() - 1);
    for (std::uint32_t window = 0; window < size(); ++window) {
      of_cell_[end[sides_[window].first]++] = window;
      of_cell_[end[sides_[window].second]++] = window;
    }
  }

  [[nodiscard]] std::size_t size() const { return centres_.size(); }

  /// Dijkstra's distances from one window to all. `tree` receives the windows in the order in which they are reached
  /// and the parent of each, itself for the source.
  [[nodiscard]] Distances distances_from(std::uint32_t source, Tree* tree = nullptr) const {
    using Entry = std::pair<double, std::uint32_t>;
    Distances distance(size(), kInfinity);
    if (tree != nullptr) *tree = {{}, std::vector<std::uint32_t>(size(), source)};
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    distance[source] = 0;
    open.emplace(0, source);
    while (!open.empty()) {
      const auto [cost, window] = open.top();
      open.pop();
      if (cost > distance[window]) continue;
      if (tree != nullptr) tree->order.push_back(window);
      for (const std::uint32_t cell : {sides_[window].first, sides_[window].second}) {
        for (std::uint32_t i = first_[cell]; i < first_[cell + 1]; ++i) {
          const std::uint32_t next = of_cell_[i];
          const double through = cost + leg(window, next);
          if (through >= distance[next]) continue;
          distance[next] = through;
          if (tree != nullptr) tree->parent[next] = window;
          open.emplace(through, next);
        }
      }
    }
    return distance;
  }

 private:
  [[nodiscard]] double leg(std::uint32_t a, std::uint32_t b) const {
    const double x = centres_[a][0] - centres_[b][0];
    const double y = centres_[a][1] - centres_[b][1];
    const double z = centres_[a][2] - centres_[b][2];
    return std::sqrt(x * x + y * y + z * z);
  }

  std::vector<Point> centres_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> sides_;
  std::vector<std::uint32_t> first_;    ///< of each cell in of_cell_
  std::vector<std::uint32_t> of_cell_;  ///< windows
};

std::uint32_t farthest(const Distances& distance) {
  return static_cast<std::uint32_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
}

/// Windows that may become landmarks, each with its distances to all windows.
struct Candidates {
  std::vector<std::uint32_t> windows;
  std::vector<std::vector<float>> distances;

  void add(const CentreGraph& graph, std::uint32_t window) {
    const Distances exact = graph.distances_from(window);
    windows.push_back(window);
    distances.emplace_back(exact.begin(), exact.end());
  }
  [[nodiscard]] float bound(std::size_t candidate, std::size_t a, std::size_t b) const {
    return std::abs(distances[candidate][a] - distances[candidate][b]);
  }
};

/// The window farthest from all candidates; without any, from window 0.
std::uint32_t farthest_window(const CentreGraph& graph, const Candidates& candidates) {
  if (candidates.windows.empty()) return farthest(graph.distances_from(0));
  Distances nearest(graph.size(), kInfinity);
  for (const std::vector<float>& distance : candidates.distances) {
    for (std::size_t i = 0; i < graph.size(); ++i) nearest[i] = std::min(nearest[i], static_cast<double>(distance[i]));
  }
  return farthest(nearest);
}

/// The end of the branch of shortest paths from `root` that the candidates bound worst in sum (the method "avoid" of
/// Goldberg and Werneck, "Computing point-to-point shortest paths from external memory", 2005).
std::uint32_t badly_bounded_window(const CentreGraph& graph, const Candidates& candidates, std::uint32_t root) {
  Tree tree;
  const Distances distance = graph.distances_from(root, &tree);
  std::vector<double> gap(graph.size());  // of the window's bound, then of the whole branch behind it
  std::vector<bool> holds_candidate(graph.size());
  for (const std::uint32_t window : candidates.windows) holds_candidate[window] = true;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    float bound = 0;
    for (std::size_t k = 0; k < candidates.windows.size(); ++k) bound = std::max(bound, candidates.bound(k, i, root));
    gap[i] = std::max(distance[i] - static_cast<double>(bound), 0.0);
  }
  for (std::size_t i = graph.size(); i-- > 1;) {  // the root comes first
    const std::uint32_t window = tree.order[i];
    const std::uint32_t parent = tree.parent[window];
    gap[parent] += gap[window];
    if (holds_candidate[window]) holds_candidate[parent] = true;
  }
  std::vector<std::uint32_t> worst_child(graph.size(), root);
  std::uint32_t worst = root;
  for (std::size_t i = 1; i < graph.size(); ++i) {
    const std::uint32_t window = tree.order[i];
    if (holds_candidate[window]) continue;
    if (worst == root || gap[window] > gap[worst]) worst = window;
    std::uint32_t& best = worst_child[tree.parent[window]];
    if (best == root || gap[window] > gap[best]) best = window;
  }
  while (worst_child[worst] != root) worst = worst_child[worst];
  return worst;
}

/// A few windows far from each other, then those that the ones before them bound badly.
Candidates find_candidates(const CentreGraph& graph, Random& random) {
  Candidates candidates;
  while (candidates.windows.size() < std::min(kCandidates, graph.size())) {
    const bool spread = candidates.windows.size() < kSpreadCandidates;
    const std::uint32_t window =
        spread ? farthest_window(graph, candidates)
               : badly_bounded_window(graph, candidates, static_cast<std::uint32_t>(random.below(graph.size())));
    if (std::find(candidates.windows.begin(), candidates.windows.end(), window) != candidates.windows.end()) break;
    candidates.add(graph, window);
  }
  return candidates;
}

/// Greedily the candidates that raise the sum of the bounds on the distances of random pairs most, the first of equals.
std::vector<std::uint32_t> best_of(const Candidates& candidates, std::size_t window_count, std::size_t count,
                                   Random& random) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs(kSamplePairs);
  for (auto& [a, b] : pairs) {
    a = random.below(window_count);
    b = random.below(window_count);
  }
  std::vector<std::uint32_t> chosen;
  std::vector<float> best(kSamplePairs);
  while (chosen.size() < std::min(count, candidates.windows.size())) {
    std::size_t winner = 0;
    double most = -1;
    for (std::size_t i = 0; i < candidates.windows.size(); ++i) {
      if (std::find(chosen.begin(), chosen.end(), candidates.windows[i]) != chosen.end()) continue;
      double gain = 0;
      for (std::size_t p = 0; p < pairs.size(); ++p) {
        gain += static_cast<double>(std::max(candidates.bound(i, pairs[p].first, pairs[p].second) - best[p], 0.0F));
      }
      if (gain <= most) continue;
      most = gain;
      winner = i;
    }
    chosen.push_back(candidates.windows[winner]);
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      best[p] = std::max(best[p], candidates.bound(winner, pairs[p].first, pairs[p].second));
    }
  }
  return chosen;
}

struct Place {
  CellIndex cell;
  Vector3 point;  ///< [m] frame W, in the cell
};

/// Places in the largest component, all of its space alike.
class Places {
 public:
  explicit Places(const BoxGraphView& view) : view_(view) {
    for (std::size_t i = 0; i < view.cell_count(); ++i) {
      const auto cell = static_cast<CellIndex>(i);
      if (view.component(cell) != 0) continue;
      const IntBox box = view.cell(cell);
      cells_.push_back(cell);
      volume_ += volume(GridBox{{box.lo[0], box.lo[1], box.lo[2]}, {box.hi[0], box.hi[1], box.hi[2]}});
      volumes_.push_back(volume_);
    }
  }

  [[nodiscard]] bool empty() const { return cells_.empty(); }

  [[nodiscard]] Place pick(Random& random) const {
    const auto at = std::upper_bound(volumes_.begin(), volumes_.end(), random.below(volume_));
    const CellIndex cell = cells_[static_cast<std::size_t>(at - volumes_.begin())];
    const Box box = view_.to_world(view_.cell(cell));
    Vector3 share;
    for (Eigen::Index axis = 0; axis < 3; ++axis) share[axis] = static_cast<Real>(random.below(1025)) / 1024;
    return {cell, box.lo + share.cwiseProduct(box.hi - box.lo)};
  }

 private:
  const BoxGraphView& view_;
  std::vector<CellIndex> cells_;
  std::vector<std::uint64_t> volumes_;  ///< [unit^3] of the cells so far
  std::uint64_t volume_ = 0;
};

struct Route {
  double length = kInfinity;  ///< [m] of the taut path
  std::uint32_t expanded = 0;
};

/// Storage of a search and a corridor of usual size for the map.
class RoomyCorridor {
 public:
  explicit RoomyCorridor(const BoxGraphView& view)
      : nodes_(view.header().neighbour_count + 16),
        open_(nodes_.size()),
        hash_(std::bit_ceil(2 * nodes_.size())),
        path_(view.cell_count()),
        int_boxes_(view.cell_count()),
        boxes_(view.cell_count()),
        gates_(view.cell_count()),
        points_(view.cell_count() + 1),
        taut_(view.cell_count() + 1) {}

  Route route(const BoxGraphView& view, const Place& from, const Place& to, SearchMode mode) {
    std::size_t length = 0;
    SearchReport search;
    CorridorReport corridor;
    const Status found = find_cell_path(view, from.cell, from.point, to.cell, to.point, {.mode = mode},
                                        {nodes_, open_, hash_}, path_, length, search);
    if (found != Status::kOk) return {};
    const Status built =
        build_corridor(view, from.point, to.point, std::span(path_).first(length), CorridorKind::kExtents, true,
                       {int_boxes_, boxes_, gates_, points_, taut_}, corridor);
    if (built != Status::kOk) return {};
    return {corridor.taut.length, search.expanded};
  }

 private:
  std::vector<SearchNode> nodes_;
  std::vector<OpenEntry> open_;
  std::vector<std::uint32_t> hash_;
  std::vector<CellIndex> path_;
  std::vector<IntBox> int_boxes_;
  std::vector<Box> boxes_;
  std::vector<Box> gates_;
  std::vector<Vector3> points_;
  std::vector<TautNode> taut_;
};

}  // namespace

std::uint32_t affordable_landmarks(std::size_t windows, std::size_t blob_bytes) {
  constexpr double kShare = 0.6;
  constexpr std::uint32_t kMost = 16;
  const double row = 2 * static_cast<double>(std::max<std::size_t>(windows, 1));
  return static_cast<std::uint32_t>(
      std::min<double>(kMost, std::floor(kShare * static_cast<double>(blob_bytes) / row)));
}

LandmarkTable choose_landmarks(const std::vector<GridBox>& cells,
                               std::span<const std::pair<std::uint32_t, std::uint32_t>> windows,
                               const std::vector<std::uint16_t>& labels, std::uint32_t count) {
  const CentreGraph graph(cells, windows, labels);
  if (count == 0 || graph.size() == 0) return {};
  std::vector<Distances> distances;
  double longest = 0;
  Random random;
  const Candidates candidates = find_candidates(graph, random);
  for (const std::uint32_t window : best_of(candidates, graph.size(), count, random)) {
    distances.push_back(graph.distances_from(window));
    longest = std::max(longest, distances.back()[farthest(distances.back())]);
  }

  constexpr std::uint32_t kMostShift = 16;
  constexpr double kLongest = 65'534;  // of a distance in steps
  LandmarkTable table;
  while (table.shift < kMostShift && std::ldexp(longest, static_cast<int>(table.shift) + 1) < kLongest) {
    ++table.shift;
  }
  if (distances.empty()) return {};
  table.too_far = table.shift == 0;
  if (table.too_far) return table;
  table.count = static_cast<std::uint32_t>(distances.size());
  table.distances.reserve(graph.size() * distances.size());
  for (std::size_t window = 0; window < graph.size(); ++window) {
    for (const Distances& from : distances) {
      table.distances.push_back(
          static_cast<std::uint16_t>(std::lround(std::ldexp(from[window], static_cast<int>(table.shift)))));
    }
  }
  return table;
}

SearchPoints measure_search_points(const BoxGraphView& view) {
  const Places places(view);
  if (places.empty() || !view.has_landmarks(0)) return SearchPoints::kLine;
  RoomyCorridor corridor(view);
  Random random;
  double ratios = 0;
  int long_detours = 0;
  std::uint64_t expanded_over_centres = 0;
  std::uint64_t expanded_along_line = 0;
  for (int pair = 0; pair < kPairs; ++pair) {
    const Place from = places.pick(random);
    const Place to = places.pick(random);
    const Route centres = corridor.route(view, from, to, SearchMode::kLandmarks);
    const Route line = corridor.route(view, from, to, SearchMode::kDefault);  // as long as the header says so
    const double ratio = line.length > 0 ? centres.length / line.length : 1;
    ratios += ratio;
    long_detours += ratio > kLongDetour ? 1 : 0;
    if (long_detours > kLongDetours) return SearchPoints::kLine;
    expanded_over_centres += centres.expanded;
    expanded_along_line += line.expanded;
  }
  const bool is_short = ratios <= kMeanDetour * kPairs;
  return is_short && 3 * expanded_over_centres < 2 * expanded_along_line ? SearchPoints::kCentres : SearchPoints::kLine;
}

}  // namespace swiftlet::tools
