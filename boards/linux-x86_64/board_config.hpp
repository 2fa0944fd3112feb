#pragma once
#include "swiftlet/storage.hpp"

namespace swiftlet {

/// A desktop or a companion PC.
inline constexpr Capacity kBoard{.segments = 512, .search_nodes = 4'194'304};

}  // namespace swiftlet
