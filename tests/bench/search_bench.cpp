// From a request to the taut corridor: location, search, corridor, taut path, on the reference maps beside the project
// and in generated worlds (seed 1).
//
// One benchmark a map and search mode. An iteration answers all queries of the map; each query counts with its fastest
// time over all iterations, of this thread's CPU clock. Columns: median_us and max_us over the queries, expanded
// (windows taken from the open list, median), boxes (median), ratio and max_ratio (length of the taut path over the
// query's reference: the voxel path pulled straight, in worlds the voxel path). Maps are built when first used: name
// some with --benchmark_filter=geb079.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "board_config.hpp"
#include "reference_map.hpp"
#include "swiftlet/storage.hpp"

namespace {

using swiftlet::SearchMode;
using swiftlet::test::SearchAnswer;
using swiftlet::test::SearchSite;

using Load = std::function<swiftlet::tools::Expected<SearchSite>()>;
constexpr std::uint64_t kSeed = 1;

/// Built on first use, kept for the other modes; null with the reason printed.
const SearchSite* load(const std::string& name, const Load& build) {
  static std::map<std::string, SearchSite> sites;
  const auto known = sites.find(name);
  if (known != sites.end()) return &known->second;
  auto site = build();
  if (site) return &sites.emplace(name, std::move(*site)).first->second;
  std::fprintf(stderr, "%s\n", site.error().message.c_str());
  return nullptr;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

double cpu_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

void search(benchmark::State& state, const std::string& name, const Load& build, SearchMode mode) {
  static swiftlet::PlannerStorage<swiftlet::kBoard> storage;
  const SearchSite* site = load(name, build);
  if (site == nullptr) {
    state.SkipWithError("no map");
    return;
  }
  std::vector<double> best(site->queries.size(), std::numeric_limits<double>::infinity());
  std::vector<double> expanded(best.size());
  std::vector<double> boxes(best.size());
  std::vector<double> ratio(best.size());
  for ([[maybe_unused]] const auto& iteration : state) {
    for (std::size_t i = 0; i < best.size(); ++i) {
      const double begin = cpu_us();
      const SearchAnswer found = answer(site->graph, site->queries[i], mode, storage.spans());
      best[i] = std::min(best[i], cpu_us() - begin);
      expanded[i] = found.search.expanded;
      boxes[i] = static_cast<double>(found.corridor.box_count);
      ratio[i] = found.corridor.taut.length / site->queries[i].reference;
    }
  }
  state.counters["median_us"] = median(best);
  state.counters["max_us"] = *std::max_element(best.begin(), best.end());
  state.counters["expanded"] = median(expanded);
  state.counters["boxes"] = median(boxes);
  state.counters["ratio"] = median(ratio);
  state.counters["max_ratio"] = *std::max_element(ratio.begin(), ratio.end());
}

void register_site(const std::string& name, const Load& build) {
  for (const auto& [word, mode] :
       {std::pair{"default", SearchMode::kDefault}, std::pair{"landmarks", SearchMode::kLandmarks},
        std::pair{"plain", SearchMode::kPlain}}) {
    benchmark::RegisterBenchmark((name + "/" + word).c_str(), search, name, build, mode)->Unit(benchmark::kMillisecond);
  }
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  for (const swiftlet::test::ReferenceMap& map : swiftlet::test::kReferenceMaps) {
    if (!std::ifstream(swiftlet::test::reference_folder(map) + "queries.csv")) continue;
    register_site(map.name, [map] { return swiftlet::test::reference_site(map); });
  }
  register_site("maze", [] { return swiftlet::test::world_site("maze", swiftlet::tools::make_maze(kSeed), kSeed); });
  register_site("office",
                [] { return swiftlet::test::world_site("office", swiftlet::tools::make_office(kSeed), kSeed); });
  benchmark::RunSpecifiedBenchmarks();
}
