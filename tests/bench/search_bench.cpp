// From a request to the taut corridor: location, search, corridor, taut path, on the reference maps beside the project.
//
// One benchmark a map and search mode. An iteration answers all queries of the map; each query counts with its fastest
// time over all iterations. Columns: median_us and max_us over the queries, expanded (windows taken from the open list,
// median), boxes (median), ratio and max_ratio (length of the taut path over `shortcut_m`, the voxel path pulled
// straight). Maps are built when first used: name some with --benchmark_filter=geb079.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "board_config.hpp"
#include "map/map_builder.hpp"
#include "map/voxel_map.hpp"
#include "swiftlet/corridor.hpp"
#include "swiftlet/corridor_search.hpp"
#include "swiftlet/planner.hpp"
#include "swiftlet/storage.hpp"

namespace {

using swiftlet::BoxGraphView;
using swiftlet::CellIndex;
using swiftlet::CorridorKind;
using swiftlet::CorridorReport;
using swiftlet::SearchMode;
using swiftlet::SearchReport;
using swiftlet::Status;
using swiftlet::Vector3;

struct Query {
  Vector3 start;
  Vector3 goal;
  double shortcut;  ///< [m]
};

struct Map {
  std::vector<std::byte> blob;
  BoxGraphView graph;
  std::vector<Query> queries;
};

const std::string kMaps = SWIFTLET_SOURCE_DIR "/../shared/maps/";

std::vector<std::vector<double>> read_numbers(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::vector<double>> rows;
  std::string line;
  std::getline(file, line);  // header
  while (std::getline(file, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    rows.emplace_back();
    for (double value = 0; fields >> value;) rows.back().push_back(value);
  }
  return rows;
}

/// Built on first use, kept for the other modes; null with the reason printed.
const Map* load(const std::string& name, const std::string& file) {
  static std::map<std::string, std::unique_ptr<Map>> maps;
  std::unique_ptr<Map>& map = maps[name];
  if (map) return map.get();
  const std::string folder = kMaps + name + "/";
  const auto voxels = swiftlet::tools::read_octree(folder + file);
  if (!voxels) {
    std::fprintf(stderr, "%s\n", voxels.error().message.c_str());
    return nullptr;
  }
  swiftlet::tools::MapBuildOptions options;
  options.radius = 0.30;
  const auto built = swiftlet::tools::build_map(*voxels, name, options, [](std::string_view, double) {});
  if (!built) {
    std::fprintf(stderr, "%s\n", built.error().message.c_str());
    return nullptr;
  }
  map = std::make_unique<Map>();
  map->blob = built->blob;
  map->graph = *BoxGraphView::open(map->blob);
  const auto queries = read_numbers(folder + "queries.csv");
  const auto details = read_numbers(folder + "queries_detail.csv");
  for (std::size_t i = 0; i < std::min(queries.size(), details.size()); ++i) {
    const std::vector<double>& q = queries[i];
    map->queries.push_back({{q[0], q[1], q[2]}, {q[3], q[4], q[5]}, details[i][2]});
  }
  return map.get();
}

struct Answer {
  SearchReport search;
  CorridorReport corridor;
};

Answer answer(const BoxGraphView& graph, const Query& query, SearchMode mode, const swiftlet::PlannerSpans& spans) {
  Answer answer;
  const auto start_cell = graph.locate(query.start);
  const auto goal_cell = graph.locate(query.goal);
  if (!start_cell || !goal_cell) return answer;
  std::size_t length = 0;
  if (swiftlet::find_cell_path(graph, *start_cell, query.start, *goal_cell, query.goal, {.mode = mode}, spans.search,
                               spans.cell_path, length, answer.search) != Status::kOk) {
    return answer;
  }
  static_cast<void>(swiftlet::build_corridor(
      graph, query.start, query.goal, spans.cell_path.first(length), CorridorKind::kExtents, true,
      {spans.int_boxes, spans.boxes, spans.gates, spans.points, spans.taut_nodes}, answer.corridor));
  return answer;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void search(benchmark::State& state, const std::string& name, const std::string& file, SearchMode mode) {
  static swiftlet::PlannerStorage<swiftlet::kBoard> storage;
  const Map* map = load(name, file);
  if (map == nullptr) {
    state.SkipWithError("no map");
    return;
  }
  std::vector<double> best(map->queries.size(), std::numeric_limits<double>::infinity());
  std::vector<double> expanded(best.size());
  std::vector<double> boxes(best.size());
  std::vector<double> ratio(best.size());
  for ([[maybe_unused]] const auto& iteration : state) {
    for (std::size_t i = 0; i < best.size(); ++i) {
      const Query& query = map->queries[i];
      const auto begin = std::chrono::steady_clock::now();
      const Answer found = answer(map->graph, query, mode, storage.spans());
      const std::chrono::duration<double, std::micro> time = std::chrono::steady_clock::now() - begin;
      best[i] = std::min(best[i], time.count());
      expanded[i] = found.search.expanded;
      boxes[i] = static_cast<double>(found.corridor.box_count);
      ratio[i] = found.corridor.taut.length / query.shortcut;
    }
  }
  state.counters["median_us"] = median(best);
  state.counters["max_us"] = *std::max_element(best.begin(), best.end());
  state.counters["expanded"] = median(expanded);
  state.counters["boxes"] = median(boxes);
  state.counters["ratio"] = median(ratio);
  state.counters["max_ratio"] = *std::max_element(ratio.begin(), ratio.end());
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  for (const auto& [name, file] : {std::pair{"geb079", "geb079.bt"}, std::pair{"power_plant", "power_plant.bt"},
                                   std::pair{"rgbd_room", "rgbd_room.ot"}, std::pair{"lounge", "lounge.bt"}}) {
    if (!std::ifstream(kMaps + name + "/queries.csv")) continue;
    for (const auto& [word, mode] :
         {std::pair{"default", SearchMode::kDefault}, std::pair{"landmarks", SearchMode::kLandmarks},
          std::pair{"plain", SearchMode::kPlain}}) {
      benchmark::RegisterBenchmark((std::string(name) + "/" + word).c_str(), search, name, file, mode)
          ->Unit(benchmark::kMillisecond);
    }
  }
  benchmark::RunSpecifiedBenchmarks();
}
