#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "map/error.hpp"
#include "map/map_builder.hpp"

namespace swiftlet::tools {

struct PointCloud {
  std::vector<std::array<double, 3>> points;  ///< [m], finite
  std::array<double, 3> viewpoint{};          ///< [m] of the sensor: a .pcd's VIEWPOINT, else the origin
  std::size_t dropped = 0;                    ///< points that were not finite, as scanners mark missing returns
};

/// Reads .ply (ascii, binary of either byte order), .pcd (ascii, binary) or .xyz (a point a line, further columns
/// ignored, separated by spaces, commas or semicolons). Errors (exit status 3) name the place: unreadable, not one of
/// these, damaged or cut short, no finite point; a compressed .pcd.
Expected<PointCloud> read_point_cloud(const std::string& path);
/// The same for the contents of a file; the ending of `name` chooses the format.
Expected<PointCloud> parse_point_cloud(const std::string& name, std::span<const std::byte> file);

/// The octree of a cloud as a .bt file: voxels that hold a point are occupied. With `origin_rays` the voxels on the way
/// from the viewpoint to each point are free; without, nothing is known to be free. Error (exit status 3): the cloud
/// spans more than the 65,536 voxels of an octree around the origin. `progress` may be empty.
Expected<std::vector<std::byte>> octree_of(const PointCloud& cloud, const std::string& name, double resolution,
                                           bool origin_rays, const Progress& progress = {});

}  // namespace swiftlet::tools
