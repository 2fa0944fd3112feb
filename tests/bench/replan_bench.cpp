// From a word that changes what is wanted to the plan that is committed, in flight: the companion of the program
// `companion` with its thread for plans, against the simulated autopilot.
//
// usage: replan_bench [--deadline UNITS]
// Flies through the classroom, the maze (seed 1) and, where it is found, the scan geb079 from goal to goal, and at more
// than half the speed limit gives another goal, other limits, or a blocked box across the path 2.5 s ahead. One line a
// map and word: how many were given; how many plans were committed while the reference moved on, how many of these in
// the very step that took the word, and their median, 99th percentile and largest time [ms]; how many only after a
// brake, since there was none from motion; how often there was no way at all. Times are the wall clock's, from the
// step that takes the word to the end of the step that commits. Between the two, steps begin 10 ms apart, as in flight;
// a word itself waits for the next step. --deadline sets planning.deadline [units of work].
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "board_config.hpp"
#include "companion/companion.hpp"
#include "linux/thread_worker.hpp"
#include "map/map_builder.hpp"
#include "map/voxel_map.hpp"
#include "sim/lockstep_uart.hpp"
#include "world/random.hpp"
#include "world/worlds.hpp"

namespace swiftlet::tools {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::size_t kWords = 300;  // of each kind
constexpr Real kRadius = Real(0.3);  // [m] of the maps
constexpr Real kHeight = Real(0.8);  // [m] of a take-off
constexpr milliseconds kStep{10};
constexpr double kAhead = 2.5;        // [s] of the box
constexpr double kFlown = 0.5;        // [s] of a plan before the next word
constexpr Real kHalfBox = Real(0.1);  // [m]
constexpr double kLongestPlan = 5;    // [s] until a word has its answer, brake included

struct Site {
  std::string name;
  std::vector<std::byte> blob;
  BoxGraphView map;
  std::vector<Vector3> places;  // free
};

std::optional<Site> make_site(const std::string& name, const VoxelMap& voxels, const std::vector<Vector3>& places) {
  MapBuildOptions options;
  options.radius = kRadius;
  auto built = build_map(voxels, name, options, [](std::string_view, double) {});
  if (!built) return std::nullopt;
  Site site{name, std::move(built->blob), {}, {}};
  site.map = *BoxGraphView::open(site.blob);
  for (const Vector3& place : places) {
    if (site.map.locate(place)) site.places.push_back(place);
  }
  return site;
}

std::optional<Site> make_site(const std::string& name, const World& world) {
  const std::string bt = to_bt(world.grid);
  const auto voxels = parse_octree(name, std::as_bytes(std::span(bt)));
  std::vector<Vector3> places;
  for (const WorldQuery& query : make_queries(world, 1, 100)) {
    for (const Voxel& end : {query.start, query.goal}) {
      const std::array<double, 3> centre = world.grid.centre(end);
      places.emplace_back(centre[0], centre[1], centre[2]);
    }
  }
  return voxels ? make_site(name, *voxels, places) : std::nullopt;
}

/// The ends of the scan's ten queries.
std::optional<Site> scanned_site(const std::string& path) {
  const auto voxels = read_octree(path);
  if (!voxels) return std::nullopt;
  std::vector<Vector3> places;
  std::ifstream rows(std::string(SWIFTLET_SOURCE_DIR) + "/tests/data/geb079_queries.csv");
  for (std::string row; std::getline(rows, row);) {
    std::replace(row.begin(), row.end(), ',', ' ');
    std::istringstream numbers(row);
    Vector3 start;
    Vector3 goal;
    if (numbers >> start.x() >> start.y() >> start.z() >> goal.x() >> goal.y() >> goal.z()) {
      places.push_back(start);
      places.push_back(goal);
    }
  }
  return make_site("geb079", *voxels, places);
}

struct Answer {
  enum class Kind : std::uint8_t { kInTheStep, kInMotion, kAfterABrake, kNone };
  Kind kind = Kind::kNone;
  double ms = 0;
};

/// A flight without end.
class Flight {
 public:
  Flight(const Site& site, std::uint64_t deadline)
      : site_(site),
        sim_(sim_settings(site)),
        line_(sim_),
        companion_(settings(site, deadline), site.map, memory_->memory(), {line_, worker_}) {}

  bool take_off() {
    (void)companion_.engage(true);
    for (int i = 0; i < 3000 && t_.phase != companion::Phase::kMission; ++i) step();
    sim_.simulation().set_ground(-1000);  // no obstacles either: this is about time
    return t_.phase == companion::Phase::kMission;
  }

  Answer give_goal() {
    get_under_way();
    const Vector3 goal = another_place();
    return measure([&] { (void)companion_.set_goal(goal); });
  }
  Answer give_limits() {
    get_under_way();
    slow_ = !slow_;
    return measure([&] { (void)companion_.set_limits(slow_ ? 0.8 : 1, slow_ ? 1.6 : 2); });
  }
  Answer block() {
    get_under_way();
    const Vector3 centre = sample_trajectory(t_.plan.segments, time_in_plan() + kAhead).position;
    const Vector3 half = Vector3::Constant(kHalfBox);
    const Answer answer = measure([&] { (void)companion_.block(1, {centre - half, centre + half}); });
    (void)companion_.unblock(1);
    step();
    return answer;
  }

 private:
  static companion::Settings settings(const Site& site, std::uint64_t deadline) {
    companion::Settings settings;
    settings.start = pad(site);
    settings.takeoff.height = kHeight;
    settings.takeoff.standing = kSecondUs / 2;
    settings.margins.vehicle_radius = Real(0.1);
    settings.margins.map_error = Real(0.04);
    settings.planning.budget.deadline = deadline;
    return settings;
  }
  static PixhawkSimSettings sim_settings(const Site& site) {
    PixhawkSimSettings sim;
    sim.simulation.start = pad(site);
    sim.link_delay = milliseconds(5);
    return sim;
  }
  static Vector3 pad(const Site& site) { return site.places[0] - Vector3{0, 0, kHeight}; }

  void step() {
    line_.advance(kStep);
    companion_.step(sim_.time());
  }

  const Vector3& another_place() { return site_.places[random_.below(site_.places.size())]; }

  [[nodiscard]] double time_in_plan() const { return static_cast<double>(t_.time - t_.plan.start) / 1e6; }

  /// On the way to some goal, fast, for a while, and with more to fly than a box lies ahead.
  void get_under_way() {
    for (std::uint32_t i = 0;; ++i) {
      if (t_.goals_waiting == 0 || i % 3000 == 2999) (void)companion_.set_goal(another_place());
      step();
      const bool flies = t_.state == FlightState::kFlying && t_.goals_waiting > 0;
      const double left = total_duration(t_.plan.segments) - time_in_plan();
      if (flies && time_in_plan() > kFlown && left > 2 * kAhead && t_.reference.sample.velocity.norm() > Real(0.5))
        return;
    }
  }

  /// From the word to the next plan that is committed.
  template <typename Tell>
  Answer measure(const Tell& tell) {
    const std::uint32_t plan = t_.plan.id;
    Answer answer;
    const Clock::time_point begin = Clock::now();
    tell();
    bool moves = true;
    for (int i = 0; i < kLongestPlan * 100; ++i) {
      if (moves) std::this_thread::sleep_until(begin + i * kStep);
      step();
      const std::chrono::duration<double, std::milli> took = Clock::now() - begin;
      moves = moves && t_.state == FlightState::kFlying;
      if (t_.plan.id != plan) {
        answer.ms = took.count();
        answer.kind = !moves ? Answer::Kind::kAfterABrake : i == 0 ? Answer::Kind::kInTheStep : Answer::Kind::kInMotion;
        return answer;
      }
      if (t_.goals_waiting == 0) return answer;
    }
    return answer;
  }

  const Site& site_;
  PixhawkSim sim_;
  LockstepUart line_;
  std::unique_ptr<companion::CompanionStorage<kBoard>> memory_ =
      std::make_unique<companion::CompanionStorage<kBoard>>();
  board::ThreadWorker worker_{planner_spans()};
  companion::Companion companion_;
  const companion::Telemetry& t_ = companion_.telemetry();
  SplitMix64 random_{1};
  bool slow_ = false;

  static PlannerSpans planner_spans() {
    static PlannerStorage<kBoard> storage;
    return storage.spans();
  }
};

double quantile(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return std::nan("");
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[std::max<std::size_t>(rank, 1) - 1];
}

template <typename Give>
void run(const Site& site, const char* word, const Give& give) {
  std::array<int, 4> counts{};
  std::vector<double> times;
  for (std::size_t i = 0; i < kWords; ++i) {
    const Answer answer = give();
    ++counts[static_cast<std::size_t>(answer.kind)];
    const bool moves = answer.kind == Answer::Kind::kInTheStep || answer.kind == Answer::Kind::kInMotion;
    if (moves) times.push_back(answer.ms);
  }
  std::sort(times.begin(), times.end());
  std::printf("%-10s %-12s %5zu  %8zu %8d  %6.2f %6.2f %6.2f  %7d  %6d\n", site.name.c_str(), word, kWords,
              times.size(), counts[0], quantile(times, 0.5), quantile(times, 0.99), quantile(times, 1), counts[2],
              counts[3]);
  std::fflush(stdout);
}

bool run(const Site& site, std::uint64_t deadline) {
  const auto flight = std::make_unique<Flight>(site, deadline);
  if (!flight->take_off()) return false;
  run(site, "new goal", [&] { return flight->give_goal(); });
  run(site, "new limits", [&] { return flight->give_limits(); });
  run(site, "blocked box", [&] { return flight->block(); });
  return true;
}

int run_all(std::uint64_t deadline) {
  const std::string scan = SWIFTLET_SCAN;
  std::printf("%-10s %-12s %5s  %8s %8s  %-20s  %7s  %6s\n", "map", "word", "given", "moving", "in step",
              "ms p50 / p99 / max", "braked", "no way");
  const std::array sites{make_site("classroom", make_classroom(1)), make_site("maze", make_maze(1)),
                         scanned_site(scan)};
  for (std::size_t i = 0; i < sites.size(); ++i) {
    if (sites[i] && !run(*sites[i], deadline)) return 1;
  }
  if (!sites[2]) std::printf("geb079: %s is not there\n", scan.c_str());
  return sites[0] && sites[1] ? 0 : 1;
}

}  // namespace
}  // namespace swiftlet::tools

int main(int argc, char** argv) {
  std::uint64_t deadline = swiftlet::companion::PlanningSettings{}.budget.deadline;
  if (argc == 3 && std::strcmp(argv[1], "--deadline") == 0) deadline = std::strtoull(argv[2], nullptr, 10);
  return swiftlet::tools::run_all(deadline);
}
