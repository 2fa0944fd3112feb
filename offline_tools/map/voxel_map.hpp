#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "map/error.hpp"

namespace swiftlet::tools {

/// A leaf of an octree: a cube of 2^log2_edge voxels along each edge.
struct VoxelLeaf {
  std::array<std::uint16_t, 3> lo;  ///< [voxel] low corner
  std::uint8_t log2_edge;           ///< 0 to 16
  bool occupied;                    ///< else observed free
};

/// A source map as the rest of the tool sees it: leaves in a box of voxels. What no leaf covers was never observed.
struct VoxelMap {
  double resolution = 0;                ///< [m] edge of a voxel
  std::array<double, 3> origin{};       ///< [m] low corner of the box of all leaves (OctoMap's metric minimum)
  std::array<std::uint32_t, 3> size{};  ///< [voxel] of that box; leaf coordinates are relative to its low corner
  std::array<std::uint16_t, 3> key{};   ///< OctoMap key of its low corner, for the alignment of octree leaves
  std::vector<VoxelLeaf> leaves;
  std::array<std::uint8_t, 32> source_digest{};  ///< SHA-256 of the file
};

inline constexpr int kOctreeDepth = 16;

/// Reads an OctoMap file, .bt (OcTree) or .ot (OcTree, ColorOcTree); a voxel is occupied from probability 0.5 on. Reads
/// the documented formats itself, with every length checked: the library's reader trusts the file, recurses as deep as
/// it says and reports to the terminal. Errors (exit status 3): unreadable, not OctoMap, another tree type, cut short,
/// damaged, no leaf.
Expected<VoxelMap> read_octree(const std::string& path);
Expected<VoxelMap> parse_octree(const std::string& name, std::span<const std::byte> file);

/// Decodes a .bt node stream: two bytes an inner node, two bits a child from the lowest on (0 nothing, 1 free, 2
/// occupied, 3 inner), children after their parent, depth first; child i lies at x = i & 1, y = i >> 1 & 1, z = i >> 2.
/// The root is an inner node of 2^depth voxels an edge, depth 1 to 16. Returns the leaves; errors carry the reason
/// alone.
tl::expected<std::vector<VoxelLeaf>, std::string> decode_node_stream(std::span<const std::byte> stream, int depth);

}  // namespace swiftlet::tools
