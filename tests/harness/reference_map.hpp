#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <memory>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "map/map_builder.hpp"
#include "map/voxel_map.hpp"
#include "swiftlet/corridor.hpp"
#include "swiftlet/corridor_search.hpp"
#include "swiftlet/planner.hpp"
#include "world/worlds.hpp"

namespace swiftlet::test {

struct SearchQuery {
  Vector3 start;
  Vector3 goal;
  double reference;  ///< [m] of a voxel path: pulled straight on reference maps, as A* leaves it in generated worlds
};

/// A built map and its queries. Movable: the view points into the blob's memory, which moves along.
struct SearchSite {
  tools::BuiltMap built;
  BoxGraphView graph;
  std::vector<SearchQuery> queries;
};

/// What a reference map is called, the file below maps/NAME/ and the radius [m] of its queries.
struct ReferenceMap {
  const char* name;
  const char* file;
};
inline constexpr std::array<ReferenceMap, 4> kReferenceMaps{{{"geb079", "geb079.bt"},
                                                             {"power_plant", "power_plant.bt"},
                                                             {"rgbd_room", "rgbd_room.ot"},
                                                             {"lounge", "lounge.bt"}}};
inline constexpr double kReferenceRadius = 0.30;

inline std::string reference_folder(const ReferenceMap& map) {
  return std::string(SWIFTLET_SOURCE_DIR "/../shared/maps/") + map.name + "/";
}

inline std::vector<std::vector<double>> read_numbers(const std::string& path) {
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

inline tools::Expected<SearchSite> build_site(const std::string& name, const tools::Expected<tools::VoxelMap>& voxels,
                                              double radius) {
  if (!voxels) return tl::unexpected(voxels.error());
  tools::MapBuildOptions options;
  options.radius = radius;
  auto built = tools::build_map(*voxels, name, options, [](std::string_view, double) {});
  if (!built) return tl::unexpected(built.error());
  SearchSite site{std::move(*built), {}, {}};
  site.graph = *BoxGraphView::open(site.built.blob);
  return site;
}

/// A map of the reference set beside the project with its ten queries.
inline tools::Expected<SearchSite> reference_site(const ReferenceMap& map) {
  const std::string folder = reference_folder(map);
  auto site = build_site(map.name, tools::read_octree(folder + map.file), kReferenceRadius);
  if (!site) return site;
  const auto queries = read_numbers(folder + "queries.csv");
  const auto details = read_numbers(folder + "queries_detail.csv");
  for (std::size_t i = 0; i < std::min(queries.size(), details.size()); ++i) {
    const std::vector<double>& q = queries[i];
    site->queries.push_back({{q[0], q[1], q[2]}, {q[3], q[4], q[5]}, details[i][2]});
  }
  return site;
}

/// A generated world with its 100 queries.
inline tools::Expected<SearchSite> world_site(const std::string& name, const tools::World& world, std::uint64_t seed) {
  const std::string bt = tools::to_bt(world.grid);
  auto site = build_site(name, tools::parse_octree(name, std::as_bytes(std::span(bt))), world.radius);
  if (!site) return site;
  constexpr std::size_t kQueries = 100;
  for (const tools::WorldQuery& query : tools::make_queries(world, seed, kQueries)) {
    const auto start = world.grid.centre(query.start);
    const auto goal = world.grid.centre(query.goal);
    site->queries.push_back({{start[0], start[1], start[2]}, {goal[0], goal[1], goal[2]}, query.astar});
  }
  return site;
}

struct SearchAnswer {
  Status status = Status::kStartNotFree;
  SearchReport search;
  CorridorReport corridor;
};

/// From a request to the taut corridor: location, search, corridor, taut path.
inline SearchAnswer answer(const BoxGraphView& graph, const SearchQuery& query, SearchMode mode,
                           const PlannerSpans& spans) {
  SearchAnswer answer;
  const auto start_cell = graph.locate(query.start);
  const auto goal_cell = graph.locate(query.goal);
  if (!start_cell || !goal_cell) return answer;
  std::size_t length = 0;
  answer.status = find_cell_path(graph, *start_cell, query.start, *goal_cell, query.goal, {.mode = mode}, spans.search,
                                 spans.cell_path, length, answer.search);
  if (answer.status != Status::kOk) return answer;
  answer.status =
      build_corridor(graph, query.start, query.goal, spans.cell_path.first(length), CorridorKind::kExtents, true,
                     {spans.int_boxes, spans.boxes, spans.gates, spans.points, spans.taut_nodes}, answer.corridor);
  return answer;
}

}  // namespace swiftlet::test
