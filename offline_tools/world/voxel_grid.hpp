#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace swiftlet::tools {

using Voxel = std::array<int, 3>;

/// Voxels lo to hi, both included.
struct VoxelBox {
  Voxel lo;
  Voxel hi;
};

/// A world of cubes, each free or occupied, none unknown; the low corner of voxel (0, 0, 0) is the origin of frame W.
class VoxelGrid {
 public:
  VoxelGrid(const Voxel& size, double resolution);

  [[nodiscard]] const Voxel& size() const { return size_; }
  [[nodiscard]] double resolution() const { return resolution_; }  ///< [m] edge of a voxel
  [[nodiscard]] std::size_t voxel_count() const { return occupied_.size(); }
  [[nodiscard]] std::size_t occupied_count() const;

  [[nodiscard]] bool contains(const Voxel& voxel) const;
  [[nodiscard]] std::size_t index(const Voxel& voxel) const;
  [[nodiscard]] Voxel voxel(std::size_t index) const;
  [[nodiscard]] std::array<double, 3> centre(const Voxel& voxel) const;  ///< [m] frame W

  [[nodiscard]] bool occupied(const Voxel& voxel) const { return occupied_[index(voxel)] != 0; }
  /// Marks every voxel of the box, which must lie in the grid.
  void fill(const VoxelBox& box, bool occupied);

 private:
  Voxel size_;
  double resolution_;
  std::vector<std::uint8_t> occupied_;
};

/// For each voxel, whether its centre is at least `distance` [m] (to 1e-9) from every occupied cube. What lies outside
/// the grid is no obstacle.
std::vector<std::uint8_t> voxels_with_clearance(const VoxelGrid& grid, double distance);

/// The grid as the bytes of an OctoMap .bt file, pruned.
std::string to_bt(const VoxelGrid& grid);

/// What a .bt file says of a voxel.
enum VoxelCode : std::uint8_t { kUnknownVoxel = 0, kFreeVoxel = 1, kOccupiedVoxel = 2 };

/// The same for a grid that may hold unknown voxels, in the order of VoxelGrid::index.
std::string to_bt(const Voxel& size, double resolution, std::vector<std::uint8_t> codes);

}  // namespace swiftlet::tools
