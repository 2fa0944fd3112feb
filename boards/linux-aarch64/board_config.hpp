#pragma once
#include "swiftlet/storage.hpp"

namespace swiftlet {

/// A companion computer of the Raspberry Pi or Jetson class, with 1 GiB of memory to spare.
inline namespace linux_aarch64 {

inline constexpr Capacity kBoard{.segments = 512, .search_nodes = 262'144};
inline constexpr BoardMemory kBoardMemory{.map_bytes = 1U << 29, .planner_bytes = 1U << 29};

/// Units of work (trajectory_generator.hpp) that this board does in a microsecond: budgets given in time are converted
/// by it, and by nothing else.
inline constexpr double kWorkPerMicrosecond = 3.0;

}  // namespace linux_aarch64

}  // namespace swiftlet
