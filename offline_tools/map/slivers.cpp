#include "map/slivers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>

#include "map/box_graph.hpp"

namespace swiftlet::tools {
namespace {

using Point = std::array<double, 3>;
constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr int kMostCells = 200;  // that one witness search looks at

double distance(const Point& a, const Point& b) {
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return std::sqrt(x * x + y * y + z * z);
}

/// The point of the window between two cells that is nearest to `p`.
Point nearest_in_window(const GridBox& a, const GridBox& b, const Point& p) {
  const GridBox window = intersection(a, b);
  Point nearest{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    nearest[axis] = std::clamp(p[axis], double{1} * window.lo[axis], double{1} * window.hi[axis]);
  }
  return nearest;
}

Point window_centre(const GridBox& a, const GridBox& b) {
  const GridBox window = intersection(a, b);
  Point centre{};
  for (std::size_t axis = 0; axis < 3; ++axis) centre[axis] = (window.lo[axis] + window.hi[axis]) / 2.0;
  return centre;
}

bool is_thin(const GridBox& cell, std::int32_t thickness) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (cell.hi[axis] - cell.lo[axis] <= thickness) return true;
  }
  return false;
}

class SliverDropper {
 public:
  SliverDropper(const std::vector<GridBox>& cells, double tolerance)
      : cells_(cells), tolerance_(tolerance), neighbours_(cells.size()), reached_(cells.size(), kFar) {
    for (const auto& [a, b] : find_windows(cells)) {
      neighbours_[a].push_back(b);
      neighbours_[b].push_back(a);
    }
  }

  /// Drops the cell unless a way needs it.
  bool try_drop(std::uint32_t cell) {
    const std::vector<std::uint32_t> around = neighbours_[cell];
    if (around.empty()) return false;
    for (std::size_t i = 0; i + 1 < around.size(); ++i) {
      if (!has_substitutes(cell, around[i], {around.begin() + static_cast<std::ptrdiff_t>(i) + 1, around.end()})) {
        return false;
      }
    }
    for (const std::uint32_t other : around) std::erase(neighbours_[other], cell);
    neighbours_[cell].clear();
    return true;
  }

 private:
  struct Arrival {
    double length;
    std::uint32_t cell;
    Point at;
    bool operator<(const Arrival& other) const {  // the shortest is the top of a queue
      return std::tuple(length, cell) > std::tuple(other.length, other.cell);
    }
  };

  /// Whether the ways from the window of `from` to those of all `targets` have substitutes that avoid the cell.
  bool has_substitutes(std::uint32_t cell, std::uint32_t from, std::vector<std::uint32_t> targets) {
    const Point start = window_centre(cells_[cell], cells_[from]);
    const auto allowed = [&](std::uint32_t target) {
      return distance(start, window_centre(cells_[cell], cells_[target])) + tolerance_;
    };
    double longest = 0;
    for (const std::uint32_t target : targets) longest = std::max(longest, allowed(target));

    std::priority_queue<Arrival> queue;
    std::vector<std::uint32_t> touched;
    const auto arrive = [&](const Arrival& arrival) {
      double& best = reached_[arrival.cell];
      if (arrival.length > longest || arrival.length >= best) return;
      if (best == kFar) touched.push_back(arrival.cell);
      best = arrival.length;
      queue.push(arrival);
    };
    arrive({0, from, start});
    for (int looked_at = 0; !queue.empty() && !targets.empty() && looked_at < kMostCells;) {
      const Arrival here = queue.top();
      queue.pop();
      if (here.length > reached_[here.cell]) continue;
      ++looked_at;
      std::erase_if(targets, [&](std::uint32_t target) {
        const Point end = window_centre(cells_[cell], cells_[target]);
        return target == here.cell && here.length + distance(here.at, end) <= allowed(target);
      });
      for (const std::uint32_t next : neighbours_[here.cell]) {
        if (next == cell) continue;
        const Point at = nearest_in_window(cells_[here.cell], cells_[next], here.at);
        arrive({here.length + distance(here.at, at), next, at});
      }
    }
    for (const std::uint32_t other : touched) reached_[other] = kFar;
    return targets.empty();
  }

  const std::vector<GridBox>& cells_;
  double tolerance_;
  std::vector<std::vector<std::uint32_t>> neighbours_;  ///< among the cells that are left
  std::vector<double> reached_;                         ///< scratch of one search; all kFar between searches
};

}  // namespace

std::uint64_t drop_slivers(std::vector<GridBox>& cells, std::int32_t thickness, double tolerance,
                           const std::function<void(double)>& done) {
  std::vector<std::uint32_t> thin;
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    if (is_thin(cells[i], thickness)) thin.push_back(i);
  }
  std::sort(thin.begin(), thin.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(volume(cells[a]), cells[a].lo) < std::tuple(volume(cells[b]), cells[b].lo);
  });

  SliverDropper dropper(cells, tolerance);
  std::vector<bool> dropped(cells.size());
  std::uint64_t lost = 0;
  for (std::size_t i = 0; i < thin.size(); ++i) {
    if (dropper.try_drop(thin[i])) {
      dropped[thin[i]] = true;
      lost += volume(cells[thin[i]]);
    }
    done(static_cast<double>(i + 1) / static_cast<double>(thin.size()));
  }
  std::vector<GridBox> kept;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!dropped[i]) kept.push_back(cells[i]);
  }
  cells = std::move(kept);
  return lost;
}

}  // namespace swiftlet::tools
