#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "map/voxel_map.hpp"

/// Any bytes are an octree or one line of refusal.
// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer calls it so
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto map = swiftlet::tools::parse_octree("input", std::as_bytes(std::span(data, size)));
  const bool usable = map ? !map->leaves.empty() : map.error().exit_status == 3 && !map.error().message.empty();
  if (!usable) std::abort();
  return 0;
}
