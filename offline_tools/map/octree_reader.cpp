#include <openssl/sha.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>
#include <string_view>

#include "map/file_io.hpp"
#include "map/voxel_map.hpp"

namespace swiftlet::tools {
namespace {

using Failure = std::string;  ///< empty: none

constexpr const char* kCutShort = "is cut short";
constexpr const char* kTooDeep = "is damaged: a node lies below the 16th level";
constexpr const char* kChildless = "is damaged: an inner node has no children";

/// Depth-first walk over the node records of a file. Every step reads at least a byte and depth is limited, so neither
/// time, memory nor stack can exceed a small multiple of the file's size.
class NodeReader {
 public:
  NodeReader(std::span<const std::byte> bytes, std::vector<VoxelLeaf>& leaves) : bytes_(bytes), leaves_(leaves) {}

  Failure read_binary_node(const std::array<std::uint16_t, 3>& lo, int log2_edge) {
    if (log2_edge == 0) return kTooDeep;
    if (bytes_.size() - used_ < 2) return kCutShort;
    const unsigned codes = byte(used_) | byte(used_ + 1) << 8;
    used_ += 2;
    if (codes == 0) return kChildless;
    for (unsigned child = 0; child < 8; ++child) {
      const unsigned code = codes >> (2 * child) & 3U;
      if (code == 1 || code == 2) add_leaf(child_corner(lo, log2_edge, child), log2_edge - 1, code == 2);
    }
    for (unsigned child = 0; child < 8; ++child) {
      if ((codes >> (2 * child) & 3U) != 3) continue;
      Failure failure = read_binary_node(child_corner(lo, log2_edge, child), log2_edge - 1);
      if (!failure.empty()) return failure;
    }
    return {};
  }

  /// A record of the full format: float log-odds, `extra` bytes that do not matter here, one bit a child.
  Failure read_full_node(const std::array<std::uint16_t, 3>& lo, int log2_edge, std::size_t extra) {
    if (bytes_.size() - used_ < sizeof(float) + extra + 1) return kCutShort;
    float log_odds = 0;
    std::memcpy(&log_odds, bytes_.data() + used_, sizeof(float));
    used_ += sizeof(float) + extra;
    const unsigned children = byte(used_++);
    if (children == 0) {
      if (std::isnan(log_odds)) return "is damaged: a voxel's log-odds is no number";
      add_leaf(lo, log2_edge, log_odds >= 0);  // probability 0.5 is occupied
      return {};
    }
    if (log2_edge == 0) return kTooDeep;
    for (unsigned child = 0; child < 8; ++child) {
      if ((children >> child & 1U) == 0) continue;
      Failure failure = read_full_node(child_corner(lo, log2_edge, child), log2_edge - 1, extra);
      if (!failure.empty()) return failure;
    }
    return {};
  }

  [[nodiscard]] std::size_t used() const { return used_; }  ///< bytes that were read

 private:
  [[nodiscard]] unsigned byte(std::size_t i) const { return std::to_integer<unsigned>(bytes_[i]); }

  static std::array<std::uint16_t, 3> child_corner(std::array<std::uint16_t, 3> lo, int log2_edge, unsigned child) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const unsigned half = 1U << (log2_edge - 1);
      if ((child >> axis & 1U) != 0) lo[axis] = static_cast<std::uint16_t>(lo[axis] + half);
    }
    return lo;
  }
  void add_leaf(const std::array<std::uint16_t, 3>& lo, int log2_edge, bool occupied) {
    leaves_.push_back({lo, static_cast<std::uint8_t>(log2_edge), occupied});
  }

  std::span<const std::byte> bytes_;
  std::vector<VoxelLeaf>& leaves_;
  std::size_t used_ = 0;
};

struct FileHeader {
  bool binary = false;
  std::string tree_type;
  double resolution = 0;
  std::size_t nodes = 0;  ///< where the node records start
  bool empty = false;     ///< the header says that there are none
};

constexpr std::string_view kBinaryMagic = "# Octomap OcTree binary file";
constexpr std::string_view kFullMagic = "# Octomap OcTree file";

/// Lines up to `data`: comments, `id TYPE`, `size N`, `res R`.
Failure read_header(std::string_view text, FileHeader& header) {
  const auto next_line = [&](std::size_t& at) -> std::string_view {
    const std::size_t end = text.find('\n', at);
    if (end == std::string_view::npos) return {};
    std::string_view line = text.substr(at, end - at);
    at = end + 1;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    return line;
  };
  std::size_t at = 0;
  const std::string_view first = next_line(at);
  header.binary = first == kBinaryMagic;
  if (!header.binary && first != kFullMagic) return "is not an OctoMap file (.bt, or .ot)";

  constexpr int kMaxLines = 64;
  bool has_size = false;
  for (int lines = 0; lines < kMaxLines && at < text.size(); ++lines) {
    const std::string_view line = next_line(at);
    if (line == "data") {
      if (header.tree_type.empty()) return "has a damaged header: no `id` line";
      if (!has_size) return "has a damaged header: no `size` line";
      const bool usable = std::isfinite(header.resolution) && header.resolution >= 1e-6 && header.resolution <= 1e6;
      if (!usable) return "has a damaged header: `res` is missing or no usable length";
      header.nodes = at;
      return {};
    }
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words{std::string(line)};
    words.imbue(std::locale::classic());
    std::string key;
    words >> key;
    if (key == "id") {
      words >> header.tree_type;
    } else if (key == "size") {
      std::uint64_t size = 0;
      has_size = static_cast<bool>(words >> size);
      header.empty = size == 0;
    } else if (key == "res") {
      if (!(words >> header.resolution)) header.resolution = 0;
    } else {
      return "has a damaged header: unexpected `" + key.substr(0, 20) + "`";
    }
  }
  return "has a damaged header: no `data` line";
}

/// Moves the leaves' coordinates to the low corner of their common box and notes that box.
void fit_box(VoxelMap& map) {
  constexpr std::uint32_t kHalfTree = 1U << (kOctreeDepth - 1);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::uint32_t lo = std::numeric_limits<std::uint32_t>::max();
    std::uint32_t hi = 0;
    for (const VoxelLeaf& leaf : map.leaves) {
      lo = std::min<std::uint32_t>(lo, leaf.lo[axis]);
      hi = std::max<std::uint32_t>(hi, leaf.lo[axis] + (1U << leaf.log2_edge));
    }
    for (VoxelLeaf& leaf : map.leaves) leaf.lo[axis] = static_cast<std::uint16_t>(leaf.lo[axis] - lo);
    map.key[axis] = static_cast<std::uint16_t>(lo);
    map.size[axis] = hi - lo;
    map.origin[axis] = (static_cast<double>(lo) - static_cast<double>(kHalfTree)) * map.resolution;
  }
}

}  // namespace

tl::expected<std::vector<VoxelLeaf>, std::string> decode_node_stream(std::span<const std::byte> stream, int depth) {
  std::vector<VoxelLeaf> leaves;
  Failure failure = NodeReader(stream, leaves).read_binary_node({0, 0, 0}, depth);
  if (!failure.empty()) return tl::unexpected(std::move(failure));
  return leaves;
}

Expected<VoxelMap> parse_octree(const std::string& name, std::span<const std::byte> file) {
  const auto refuse = [&name](const std::string& what) { return bad_file(name + ": " + what); };
  if (file.empty()) return refuse("is empty; expected an OctoMap file (.bt, or .ot)");
  FileHeader header;
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  Failure failure = read_header(text, header);
  if (!failure.empty()) return refuse(failure);
  const bool color = header.tree_type == "ColorOcTree";
  if (header.tree_type != "OcTree" && !(color && !header.binary)) {
    return refuse("holds a tree of type " + header.tree_type.substr(0, 40) +
                  "; convert it to an OcTree (.bt, .ot) or a ColorOcTree (.ot)");
  }
  if (header.empty) return refuse("holds no voxel");

  VoxelMap map;
  map.resolution = header.resolution;
  NodeReader reader(file.subspan(header.nodes), map.leaves);
  constexpr std::size_t kColorBytes = 3;
  failure = header.binary ? reader.read_binary_node({0, 0, 0}, kOctreeDepth)
                          : reader.read_full_node({0, 0, 0}, kOctreeDepth, color ? kColorBytes : 0);
  if (!failure.empty()) {
    return refuse(failure + ", at byte " + std::to_string(header.nodes + reader.used()) + "; write or copy it again");
  }
  fit_box(map);
  SHA256(reinterpret_cast<const unsigned char*>(file.data()), file.size(), map.source_digest.data());
  return map;
}

Expected<VoxelMap> read_octree(const std::string& path) {
  const Expected<std::vector<std::byte>> file = read_file(path);
  if (!file) return tl::unexpected(file.error());
  return parse_octree(path, *file);
}

}  // namespace swiftlet::tools
