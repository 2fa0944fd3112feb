#pragma once
#include "swiftlet/storage.hpp"

namespace swiftlet {

/// A desktop or a companion PC, with 4 GiB of memory to spare.
inline namespace linux_x86_64 {

inline constexpr Capacity kBoard{.segments = 512, .search_nodes = 4'194'304};
inline constexpr BoardMemory kBoardMemory{.map_bytes = 1U << 31, .planner_bytes = 1U << 31};

/// Units of work (trajectory_generator.hpp) that this board does in a microsecond: budgets given in time are converted
/// by it, and by nothing else.
inline constexpr double kWorkPerMicrosecond = 10.0;

}  // namespace linux_x86_64

}  // namespace swiftlet
