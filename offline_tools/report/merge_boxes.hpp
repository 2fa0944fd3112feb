#pragma once
#include <span>
#include <vector>

#include "swiftlet/types.hpp"

namespace swiftlet::tools {

/// Fewer boxes with the same union: neighbours with the same cross-section become one, along x, then y, then z. `boxes`
/// are disjoint, and so is the result, which does not depend on their order. Cost O(n log n).
std::vector<IntBox> merge_boxes(std::span<const IntBox> boxes);

}  // namespace swiftlet::tools
