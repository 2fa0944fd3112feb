#include "map/alternatives.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <numeric>

#include "map/free_space.hpp"

namespace swiftlet::tools {
namespace {

/// Set cells lo to hi - 1 of a row along x.
struct Run {
  std::int32_t lo;
  std::int32_t hi;
};

std::vector<Run> runs_of(std::span<const BitGrid::Word> row, std::int32_t size) {
  std::vector<Run> runs;
  const auto is_set = [&](std::int32_t x) { return (row[static_cast<std::size_t>(x) / 64] >> (x % 64) & 1U) != 0; };
  for (std::int32_t x = 0; x < size; ++x) {
    if (row[static_cast<std::size_t>(x) / 64] == 0) {
      x |= BitGrid::kWordBits - 1;
    } else if (is_set(x)) {
      const std::int32_t lo = x;
      while (x < size && is_set(x)) ++x;
      runs.push_back({lo, x});
    }
  }
  return runs;
}

/// Disjoint sets of runs with their volumes.
class Components {
 public:
  std::size_t add(const Run& run) {
    parents_.push_back(parents_.size());
    volumes_.push_back(static_cast<std::uint64_t>(run.hi - run.lo));
    return parents_.size() - 1;
  }
  void join(std::size_t a, std::size_t b) {
    a = root(a);
    b = root(b);
    if (a == b) return;
    parents_[std::max(a, b)] = std::min(a, b);
    volumes_[std::min(a, b)] += volumes_[std::max(a, b)];
  }
  [[nodiscard]] std::uint64_t largest() const {
    return volumes_.empty() ? 0 : *std::max_element(volumes_.begin(), volumes_.end());
  }

 private:
  std::size_t root(std::size_t run) {
    while (parents_[run] != run) run = parents_[run] = parents_[parents_[run]];
    return run;
  }
  std::vector<std::size_t> parents_;
  std::vector<std::uint64_t> volumes_;
};

struct NumberedRuns {
  std::size_t first = 0;  ///< number of the first one
  std::vector<Run> runs;
};

void join_overlaps(const NumberedRuns& a, const NumberedRuns& b, Components& components) {
  for (std::size_t i = 0, j = 0; i < a.runs.size() && j < b.runs.size();) {
    if (a.runs[i].lo < b.runs[j].hi && b.runs[j].lo < a.runs[i].hi) components.join(a.first + i, b.first + j);
    (a.runs[i].hi < b.runs[j].hi ? i : j)++;
  }
}

std::string radius_option(double radius) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), radius);
  return "--radius " + std::string(text.data(), end.ptr);
}

struct Trial {
  std::string option;
  MapBuildOptions options;
};

std::vector<Trial> trials_for(const MapBuildOptions& options) {
  std::vector<Trial> trials;
  MapBuildOptions changed = options;
  if (options.coarsen > 1) {
    changed.coarsen = 1;
    trials.push_back({"no --coarsen", changed});
    changed = options;
  }
  if (options.unknown == UnknownPolicy::kOccupied) {
    changed.unknown = UnknownPolicy::kAvoid;
    trials.push_back({"--unknown avoid", changed});
  }
  if (options.unknown != UnknownPolicy::kFree) {
    changed.unknown = UnknownPolicy::kFree;
    trials.push_back({"--unknown free", changed});
    changed = options;
  }
  if (options.radius > 0) {
    changed.radius = options.radius / 2;
    trials.push_back({radius_option(changed.radius), changed});
  }
  return trials;
}

}  // namespace

double largest_share(const BitGrid& free) {
  Components components;
  std::vector<NumberedRuns> below(static_cast<std::size_t>(free.size()[1]));  // the rows at z - 1
  std::uint64_t total = 0;
  for (std::int32_t z = 0; z < free.size()[2]; ++z) {
    const NumberedRuns* before = nullptr;  // the row at y - 1
    for (std::int32_t y = 0; y < free.size()[1]; ++y) {
      NumberedRuns row{0, runs_of(free.row(y, z), free.size()[0])};
      for (std::size_t i = 0; i < row.runs.size(); ++i) {
        const std::size_t number = components.add(row.runs[i]);
        if (i == 0) row.first = number;
        total += static_cast<std::uint64_t>(row.runs[i].hi - row.runs[i].lo);
      }
      NumberedRuns& under = below[static_cast<std::size_t>(y)];
      if (before != nullptr) join_overlaps(row, *before, components);
      join_overlaps(row, under, components);
      under = std::move(row);
      before = &under;
    }
  }
  return total == 0 ? 0 : static_cast<double>(components.largest()) / static_cast<double>(total);
}

std::vector<Alternative> try_alternatives(const VoxelMap& map, const std::string& source,
                                          const MapBuildOptions& options, const Progress& progress) {
  std::vector<Alternative> alternatives;
  for (const Trial& trial : trials_for(options)) {
    const auto report = [&](std::string_view, double done) { progress("try " + trial.option, done); };
    const Expected<FreeSpace> space = compute_free_space(map, source, trial.options, report);
    if (!space) continue;  // half a radius may want a unit that makes the grid too large
    alternatives.push_back({trial.option, largest_share(space->free)});
    if (alternatives.back().largest_component >= kGoodShare) break;
  }
  return alternatives;
}

}  // namespace swiftlet::tools
