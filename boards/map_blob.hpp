#pragma once
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>

#include "swiftlet/box_graph_view.hpp"

namespace swiftlet::board {

/// The blob at the front of a map region, without what follows it; the whole region when its header does not say.
inline std::span<const std::byte> trim_to_blob(std::span<const std::byte> region) {
  BlobHeader header{};
  if (region.size() < sizeof header) return region;
  std::memcpy(&header, region.data(), sizeof header);
  return region.first(std::min<std::size_t>(region.size(), header.blob_bytes));
}

}  // namespace swiftlet::board
