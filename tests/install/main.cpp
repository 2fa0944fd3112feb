// A project of its own that uses the installed package.
#include <cstdio>

#include "swiftlet/storage.hpp"
#include "swiftlet/version.hpp"

static swiftlet::PlannerStorage<swiftlet::Capacity{.segments = 16, .search_nodes = 64}> storage;

int main() {
  swiftlet::Planner planner(storage.spans());
  const swiftlet::Result<swiftlet::BoxGraphView> graph = swiftlet::BoxGraphView::open({});
  const bool refused = graph.status() == swiftlet::Status::kBlobTruncated;
  std::printf("swiftlet %s, a real has %zu bytes, an empty map: %s\n", swiftlet::kVersion, sizeof(swiftlet::Real),
              swiftlet::describe(graph.status()));
  return refused && planner.result().segments.empty() ? 0 : 1;
}
