#include "cli/planner_memory.hpp"

#include <memory>

#include "board_config.hpp"
#include "swiftlet/storage.hpp"

namespace swiftlet::tools {

PlannerSpans planner_memory() {
  static const auto storage = std::make_unique_for_overwrite<PlannerStorage<kBoard>>();
  return storage->spans();
}

}  // namespace swiftlet::tools
