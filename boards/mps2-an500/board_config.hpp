#pragma once
#include "swiftlet/storage.hpp"

namespace swiftlet {

/// A Cortex-M7 with 4 MB of data memory.
inline constexpr Capacity kBoard{.segments = 128, .search_nodes = 16'384};

}  // namespace swiftlet
