// From a request to the certified trajectory, on the generated worlds (seed 1, their 100 queries): cold, refinement and
// certificate included.
//
// usage: plan_bench [--norm euclidean] [--sweep]
// One line a world and limit V = A: median, 99th percentile and largest time of search, trajectory and the whole [us];
// the duration over astar / V + V / A (median, worst); the summed jerk cost times that ratio's fifth power (median);
// boxes (median); statuses. Times are those of this thread's CPU clock, each query's fastest of five.
// --sweep instead raises V and A from 0.5 to 10 in twelve steps each on the maze and counts the steps that make an
// answer slower.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "board_config.hpp"
#include "map/map_builder.hpp"
#include "map/voxel_map.hpp"
#include "swiftlet/planner.hpp"
#include "swiftlet/storage.hpp"
#include "world/worlds.hpp"

namespace {

using swiftlet::Plan;
using swiftlet::Planner;
using swiftlet::PlanRequest;
using swiftlet::Status;
using swiftlet::tools::World;

constexpr std::size_t kQueries = 100;
constexpr int kRepeats = 5;
constexpr std::uint64_t kSeed = 1;

struct Site {
  std::string name;
  std::vector<std::byte> blob;
  swiftlet::BoxGraphView graph;
  std::vector<PlanRequest> requests;
  std::vector<double> astar;  ///< [m]
};

std::unique_ptr<Site> build(const std::string& name, const World& world) {
  const std::string bt = swiftlet::tools::to_bt(world.grid);
  const auto voxels = swiftlet::tools::parse_octree(name, std::as_bytes(std::span(bt)));
  if (!voxels) return nullptr;
  swiftlet::tools::MapBuildOptions options;
  options.radius = world.radius;
  const auto built = swiftlet::tools::build_map(*voxels, name, options, [](std::string_view, double) {});
  if (!built) return nullptr;
  auto site = std::make_unique<Site>();
  site->name = name;
  site->blob = built->blob;
  site->graph = *swiftlet::BoxGraphView::open(site->blob);
  for (const auto& query : swiftlet::tools::make_queries(world, kSeed, kQueries)) {
    const auto start = world.grid.centre(query.start);
    const auto goal = world.grid.centre(query.goal);
    PlanRequest request;
    request.start.position = {start[0], start[1], start[2]};
    request.goal.position = {goal[0], goal[1], goal[2]};
    site->requests.push_back(request);
    site->astar.push_back(query.astar);
  }
  return site;
}

double cpu_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values[std::max<std::size_t>(rank, 1) - 1];
}

Planner& planner() {
  static swiftlet::PlannerStorage<swiftlet::kBoard> storage;
  static Planner planner(storage.spans());
  return planner;
}

struct Times {
  double search = std::numeric_limits<double>::infinity();
  double total = std::numeric_limits<double>::infinity();
};

Times time_plan(const Site& site, const PlanRequest& request) {
  Times best;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    const double begin = cpu_us();
    const bool found = planner().find_corridor(site.graph, request) == Status::kOk;
    const double searched = cpu_us();
    if (found) (void)planner().fit_trajectory(request);
    best.search = std::min(best.search, searched - begin);
    best.total = std::min(best.total, cpu_us() - begin);
  }
  return best;
}

void run(const Site& site, double limit, swiftlet::LimitNorm norm) {
  std::vector<double> search;
  std::vector<double> trajectory;
  std::vector<double> total;
  std::vector<double> ratio;
  std::vector<double> cost;
  std::vector<double> boxes;
  std::array<int, 3> counts{};  // optimal, fallback, none
  for (std::size_t i = 0; i < site.requests.size(); ++i) {
    PlanRequest request = site.requests[i];
    request.v_max = request.a_max = limit;
    request.norm = norm;
    const Times times = time_plan(site, request);
    search.push_back(times.search);
    trajectory.push_back(times.total - times.search);
    total.push_back(times.total);
    const Plan& plan = planner().result();
    ++counts[plan.status == Status::kOk ? 0 : plan.status == Status::kFallback ? 1 : 2];
    if (plan.segments.empty()) continue;
    const double r = total_duration(plan.segments) / (site.astar[i] / limit + 1);
    ratio.push_back(r);
    cost.push_back((jerk_cost(plan.segments, 0) + jerk_cost(plan.segments, 1) + jerk_cost(plan.segments, 2)) *
                   std::pow(r, 5));
    boxes.push_back(static_cast<double>(plan.boxes.size()));
  }
  std::printf("%-10s %3.0f", site.name.c_str(), limit);
  for (const std::vector<double>& times : {search, trajectory, total}) {
    std::printf("  %7.0f %7.0f %7.0f", quantile(times, 0.5), quantile(times, 0.99), quantile(times, 1));
  }
  std::printf("  %6.3f %6.3f  %8.2f  %4.0f  %d / %d / %d\n", quantile(ratio, 0.5), quantile(ratio, 1),
              quantile(cost, 0.5), quantile(boxes, 0.5), counts[0], counts[1], counts[2]);
}

/// Durations of all queries at one pair of limits; nothing where there is no answer.
std::vector<std::optional<double>> durations(const Site& site, double v_max, double a_max) {
  std::vector<std::optional<double>> durations;
  for (PlanRequest request : site.requests) {
    request.v_max = v_max;
    request.a_max = a_max;
    const Plan& plan = planner().plan(site.graph, request);
    durations.push_back(plan.segments.empty() ? std::optional<double>{} : total_duration(plan.segments));
  }
  return durations;
}

void sweep(const Site& site) {
  constexpr std::size_t kSteps = 12;
  std::vector<std::vector<std::vector<std::optional<double>>>> table(kSteps);
  const auto limit = [](std::size_t i) { return 0.5 * std::pow(20.0, static_cast<double>(i) / (kSteps - 1)); };
  for (std::size_t i = 0; i < kSteps; ++i) {
    for (std::size_t j = 0; j < kSteps; ++j) table[i].push_back(durations(site, limit(i), limit(j)));
  }
  int steps = 0;
  int slower = 0;
  int much_slower = 0;
  int lost = 0;
  double worst = 0;
  const auto compare = [&](const auto& before, const auto& after) {
    for (std::size_t k = 0; k < before.size(); ++k) {
      if (!before[k]) continue;
      ++steps;
      lost += after[k] ? 0 : 1;
      const double change = after[k] ? *after[k] / *before[k] - 1 : 0;
      slower += change > 1e-6 ? 1 : 0;
      much_slower += change > 0.01 ? 1 : 0;
      worst = std::max(worst, change);
    }
  };
  for (std::size_t i = 0; i < kSteps; ++i) {
    for (std::size_t j = 0; j < kSteps; ++j) {
      if (i + 1 < kSteps) compare(table[i][j], table[i + 1][j]);
      if (j + 1 < kSteps) compare(table[i][j], table[i][j + 1]);
    }
  }
  std::printf(
      "%d steps: %d lose their answer, %d (%.2f %%) get slower, %d (%.2f %%) by more than 1 %%, worst %.1f %%\n", steps,
      lost, slower, 100.0 * slower / steps, much_slower, 100.0 * much_slower / steps, 100 * worst);
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string_view> words(argv + 1, argv + argc);
  const auto has = [&](std::string_view word) { return std::find(words.begin(), words.end(), word) != words.end(); };
  const swiftlet::LimitNorm norm = has("euclidean") ? swiftlet::LimitNorm::kEuclidean : swiftlet::LimitNorm::kAxis;
  if (has("--sweep")) {
    const std::unique_ptr<Site> maze = build("maze", swiftlet::tools::make_maze(kSeed));
    if (maze) sweep(*maze);
    return maze ? 0 : 1;
  }
  std::printf("%-10s %3s  %-23s  %-23s  %-23s  %-13s  %8s  %4s  %s\n", "world", "V=A", "search us p50/p99/max",
              "trajectory us", "total us", "T ratio", "J R^5", "M", "optimal / fallback / none");
  struct Kind {
    const char* name;
    World (*make)(std::uint64_t seed);
  };
  constexpr std::array<Kind, 4> kKinds{
      {{"classroom", swiftlet::tools::make_classroom},
       {"maze", swiftlet::tools::make_maze},
       {"office", [](std::uint64_t seed) { return swiftlet::tools::make_office(seed); }},
       {"forest", swiftlet::tools::make_forest}}};
  for (const Kind& kind : kKinds) {
    const std::unique_ptr<Site> site = build(kind.name, kind.make(kSeed));
    if (!site) return 1;
    for (const double limit : {1.0, 2.0}) run(*site, limit, norm);
  }
}
