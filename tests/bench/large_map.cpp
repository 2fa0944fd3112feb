// Writes a large map of real content: `large_map IN.bt OUT.bt` lays a scan out as many times as it takes to fill
// 300 x 170 x 28 m of voxels of 0.20 m with about 12 million free ones, whatever the scan's own resolution.
#include <array>
#include <cstdio>
#include <fstream>

#include "map/voxel_map.hpp"
#include "world/voxel_grid.hpp"

namespace {

using swiftlet::tools::Voxel;
using swiftlet::tools::VoxelMap;

constexpr Voxel kSize{1500, 850, 140};
constexpr double kResolution = 0.20;  // [m]
constexpr std::size_t kFreeVoxels = 12'000'000;

struct Canvas {
  std::vector<std::uint8_t> codes = std::vector<std::uint8_t>(std::size_t{1500} * 850 * 140);
  std::size_t free = 0;

  void draw(const VoxelMap& scan, const Voxel& corner) {
    for (const swiftlet::tools::VoxelLeaf& leaf : scan.leaves) {
      const int edge = 1 << leaf.log2_edge;
      for (int z = 0; z < edge; ++z) {
        for (int y = 0; y < edge; ++y) {
          for (int x = 0; x < edge; ++x) {
            const int number = ((corner[2] + leaf.lo[2] + z) * kSize[1] + corner[1] + leaf.lo[1] + y) * kSize[0] +
                               corner[0] + leaf.lo[0] + x;
            codes[static_cast<std::size_t>(number)] =
                leaf.occupied ? swiftlet::tools::kOccupiedVoxel : swiftlet::tools::kFreeVoxel;
            free += leaf.occupied ? 0 : 1;
          }
        }
      }
    }
  }
};

/// Tiles side by side at one of three heights in turn, round after round, until there is enough free space.
std::size_t fill(Canvas& canvas, const VoxelMap& scan) {
  std::array<int, 3> last{};   // low corner of the last tile along each axis
  std::array<int, 3> count{};  // of tiles along it
  for (std::size_t axis = 0; axis < 3; ++axis) {
    last[axis] = kSize[axis] - static_cast<int>(scan.size[axis]);
    count[axis] = kSize[axis] / static_cast<int>(scan.size[axis]);
    if (count[axis] < 2) return 0;
  }
  const int columns = count[0] * count[1];
  int tile = 0;
  for (; canvas.free < kFreeVoxels && tile < columns * count[2]; ++tile) {
    const std::array<int, 3> place{tile % count[0], tile % columns / count[0], (tile + tile / columns) % count[2]};
    Voxel corner{};
    for (std::size_t axis = 0; axis < 3; ++axis) corner[axis] = place[axis] * last[axis] / (count[axis] - 1);
    canvas.draw(scan, corner);
  }
  return static_cast<std::size_t>(tile);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: large_map IN.bt OUT.bt\n");
    return 2;
  }
  const auto scan = swiftlet::tools::read_octree(argv[1]);
  if (!scan) {
    std::fprintf(stderr, "%s\n", scan.error().message.c_str());
    return 3;
  }
  Canvas canvas;
  const std::size_t tiles = fill(canvas, *scan);
  std::printf("%zu tiles, %zu free voxels\n", tiles, canvas.free);
  const std::string bytes = swiftlet::tools::to_bt(kSize, kResolution, std::move(canvas.codes));
  return std::ofstream(argv[2], std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size())) ? 0
                                                                                                                  : 3;
}
