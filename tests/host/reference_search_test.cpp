// Sizes of the reference maps and the search over them, against the bars that docs/performance.md states. Needs the
// folder ../shared; skipped where it is absent.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <limits>
#include <vector>

#include "board_config.hpp"
#include "reference_map.hpp"
#include "swiftlet/storage.hpp"

namespace swiftlet::test {
namespace {

constexpr std::size_t kAny = std::numeric_limits<std::size_t>::max();

struct Bars {
  ReferenceMap map;
  std::size_t cells;
  std::size_t graph_bytes;  ///< header, cells, adjacency, index
  double fewer_expansions;  ///< of the default than of plain, median
};

constexpr std::array<Bars, 4> kBars{{{kReferenceMaps[0], 17'000, 750'000, 5},
                                     {kReferenceMaps[1], 1'600, kAny, 1},
                                     {kReferenceMaps[2], 6'000, 260'000, 1},
                                     {kReferenceMaps[3], 190'000, kAny, 5}}};

std::ostream& operator<<(std::ostream& out, const Bars& bars) { return out << bars.map.name; }

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

struct Figures {
  std::vector<double> expanded;
  std::vector<double> ratio;  ///< taut length over the voxel path pulled straight
};

Figures search_all(const SearchSite& site, SearchMode mode) {
  static PlannerStorage<kBoard> storage;
  Figures figures;
  for (const SearchQuery& query : site.queries) {
    const SearchAnswer found = answer(site.graph, query, mode, storage.spans());
    EXPECT_EQ(found.status, Status::kOk);
    figures.expanded.push_back(found.search.expanded);
    figures.ratio.push_back(static_cast<double>(found.corridor.taut.length) / query.reference);
  }
  return figures;
}

class ReferenceSearch : public testing::TestWithParam<Bars> {};

TEST_P(ReferenceSearch, MapAndSearchKeepTheirBars) {
  const Bars& bars = GetParam();
  if (!std::ifstream(reference_folder(bars.map) + "queries.csv")) {
    GTEST_SKIP() << "the reference maps are not there: ../shared/maps";
  }
  const auto site = reference_site(bars.map);
  ASSERT_TRUE(site.has_value()) << site.error().message;
  const tools::MapReport& report = site->built.report;
  EXPECT_LE(report.cells, bars.cells);
  EXPECT_LE(report.blob_bytes - report.landmark_bytes -
                report.section_bytes[static_cast<std::size_t>(BlobSection::kObstacles)],
            bars.graph_bytes);

  ASSERT_EQ(site->queries.size(), 10U);
  const Figures found = search_all(*site, SearchMode::kDefault);
  EXPECT_LE(*std::max_element(found.ratio.begin(), found.ratio.end()), 1.05);
  EXPECT_LE(median(found.ratio), 1.01);
  const Figures plain = search_all(*site, SearchMode::kPlain);
  EXPECT_GE(median(plain.expanded), bars.fewer_expansions * median(found.expanded));
}

INSTANTIATE_TEST_SUITE_P(Maps, ReferenceSearch, testing::ValuesIn(kBars),
                         [](const auto& param) { return std::string(param.param.map.name); });

}  // namespace
}  // namespace swiftlet::test
