#pragma once
#include "swiftlet/planner.hpp"

namespace swiftlet::tools {

/// The memory of a run's one planner, as large as the board affords: allocated by the first call, so that a command
/// that plans nothing, or is refused, has none. Every call gives the same.
PlannerSpans planner_memory();

}  // namespace swiftlet::tools
