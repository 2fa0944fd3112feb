#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "map/voxel_map.hpp"

namespace swiftlet::test {

using Voxel = std::array<std::uint16_t, 3>;  ///< OctoMap key
using Voxels = std::map<Voxel, bool>;        ///< known voxels; true: occupied

enum class FileKind { kBt, kOt, kColorOt };

inline const char* tree_type(FileKind kind) { return kind == FileKind::kColorOt ? "ColorOcTree" : "OcTree"; }

/// Writes OctoMap files from the format's description alone, voxel by voxel, without pruning.
class OctomapFile {
 public:
  OctomapFile(const Voxels& voxels, double resolution, FileKind kind) : kind_(kind) {
    const std::string first = kind == FileKind::kBt ? "# Octomap OcTree binary file" : "# Octomap OcTree file";
    text_ =
        first + "\n# a comment\nid " + tree_type(kind) + "\nsize 17\nres " + std::to_string(resolution) + "\ndata\n";
    if (kind == FileKind::kBt) {
      write_binary(voxels, 15);
    } else {
      write_full(voxels, 15);
    }
  }
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] std::vector<std::byte> bytes() const {
    std::vector<std::byte> copy(text_.size());
    std::memcpy(copy.data(), text_.data(), text_.size());
    return copy;
  }

 private:
  static std::array<Voxels, 8> by_child(const Voxels& voxels, int bit) {
    std::array<Voxels, 8> parts;
    for (const auto& [key, occupied] : voxels) {
      const unsigned child = (key[0] >> bit & 1U) | (key[1] >> bit & 1U) << 1 | (key[2] >> bit & 1U) << 2;
      parts[child][key] = occupied;
    }
    return parts;
  }
  void write_binary(const Voxels& voxels, int bit) {
    const auto parts = by_child(voxels, bit);
    unsigned codes = 0;
    for (unsigned child = 0; child < 8; ++child) {
      if (parts[child].empty()) continue;
      const unsigned leaf = parts[child].begin()->second ? 2 : 1;
      codes |= (bit == 0 ? leaf : 3U) << (2 * child);
    }
    text_ += static_cast<char>(codes & 255U);
    text_ += static_cast<char>(codes >> 8);
    if (bit == 0) return;
    for (const Voxels& part : parts) {
      if (!part.empty()) write_binary(part, bit - 1);
    }
  }
  void write_full(const Voxels& voxels, int bit) {
    const float log_odds = voxels.begin()->second ? 0.0F : -0.4F;  // exactly 0: probability 0.5, which is occupied
    text_.append(reinterpret_cast<const char*>(&log_odds), sizeof(float));
    if (kind_ == FileKind::kColorOt) text_ += "rgb";
    if (bit < 0) {
      text_ += '\0';
      return;
    }
    const auto parts = by_child(voxels, bit);
    unsigned children = 0;
    for (unsigned child = 0; child < 8; ++child) children |= (parts[child].empty() ? 0U : 1U) << child;
    text_ += static_cast<char>(children);
    for (const Voxels& part : parts) {
      if (!part.empty()) write_full(part, bit - 1);
    }
  }

  FileKind kind_;
  std::string text_;
};

}  // namespace swiftlet::test
