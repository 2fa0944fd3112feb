#pragma once
#include <octomap/OcTree.h>

#include <string>
#include <vector>

namespace swiftlet::tools {

/// A map of two closed rooms: x -1 to 3, y -1 to 1, z 0 to 1 [m] in voxels of 0.1 m, a wall at x = 1, in the left room
/// a pillar (x -0.2 to 0, y -0.1 to 0.1) and a hole that was never observed (x -0.6 to -0.3, y 0.4 to 0.7, z 0.4 to
/// 0.7).
inline void write_two_rooms(const std::string& path) {
  octomap::OcTree tree(0.1);
  for (int x = -10; x < 30; ++x) {
    for (int y = -10; y < 10; ++y) {
      for (int z = 0; z < 10; ++z) {
        const bool unknown = x >= -6 && x < -3 && y >= 4 && y < 7 && z >= 4 && z < 7;
        const bool occupied = x == 10 || (x >= -2 && x < 0 && y >= -1 && y < 1);
        if (!unknown) tree.updateNode(0.1 * (x + 0.5), 0.1 * (y + 0.5), 0.1 * (z + 0.5), occupied);
      }
    }
  }
  tree.writeBinary(path);
}

// Points of that map for a vehicle of 0.15 m radius.
inline constexpr const char* kLeft = "-0.75,-0.75,0.5";     // free
inline constexpr const char* kLeftToo = "0.55,0.55,0.5";    // free
inline constexpr const char* kRight = "2.05,0.05,0.5";      // free, behind the wall
inline constexpr const char* kInPillar = "-0.1,0.05,0.5";   // occupied
inline constexpr const char* kNearPillar = "0.1,0.05,0.5";  // 0.1 m from it: too close
inline constexpr const char* kInHole = "-0.45,0.55,0.55";   // unknown
inline constexpr const char* kOutside = "7,0,0.5";

}  // namespace swiftlet::tools
