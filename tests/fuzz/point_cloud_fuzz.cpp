#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>

#include "map/point_cloud.hpp"
#include "map/voxel_map.hpp"

/// The first byte chooses the format. Any bytes are a cloud of finite points or one line of refusal, and a cloud's
/// octree is readable.
// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer calls it so
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string name = data[0] % 3 == 0 ? "a.ply" : data[0] % 3 == 1 ? "a.pcd" : "a.xyz";
  const auto cloud = swiftlet::tools::parse_point_cloud(name, std::as_bytes(std::span(data + 1, size - 1)));
  if (!cloud) return cloud.error().message.empty() ? (std::abort(), 0) : 0;
  for (const auto& point : cloud->points) {
    for (const double x : point) {
      if (!std::isfinite(x)) std::abort();
    }
  }
  const auto file = swiftlet::tools::octree_of(*cloud, name, 0.5, cloud->points.size() < 16);
  if (file && !swiftlet::tools::parse_octree("a.bt", *file)) std::abort();
  return 0;
}
