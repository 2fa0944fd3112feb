#pragma once
#include "swiftlet/storage.hpp"

namespace swiftlet {

/// A companion computer of the Raspberry Pi or Jetson class.
inline constexpr Capacity kBoard{.segments = 512, .search_nodes = 262'144};

}  // namespace swiftlet
