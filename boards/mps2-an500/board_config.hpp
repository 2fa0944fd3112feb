#pragma once
#include "swiftlet/storage.hpp"

namespace swiftlet {

/// A Cortex-M7 with 4 MiB of data memory, of which the stack and other data take less than a quarter, and 16 MiB of
/// PSRAM for the map and the flight logs (linker.ld).
inline namespace mps2_an500 {

inline constexpr Capacity kBoard{.segments = 128, .search_nodes = 16'384};
inline constexpr BoardMemory kBoardMemory{.map_bytes = 12U << 20, .planner_bytes = 3U << 20};

/// Units of work (trajectory_generator.hpp) that this board does in a microsecond: budgets given in time are converted
/// by it, and by nothing else.
inline constexpr double kWorkPerMicrosecond = 0.2;

}  // namespace mps2_an500

}  // namespace swiftlet
