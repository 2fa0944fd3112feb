#include "map/point_cloud.hpp"

#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

#include "map/file_io.hpp"

namespace swiftlet::tools {
namespace {

using Failure = std::string;  ///< empty: none

/// Lines of a text, one after the other.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}
  [[nodiscard]] bool next(std::string_view& line) {
    if (at_ >= text_.size()) return false;
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    line = text_.substr(at_, end - at_);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    at_ = end + 1;
    ++number_;
    return true;
  }
  [[nodiscard]] std::size_t number() const { return number_; }  ///< of the line last read, from 1
  [[nodiscard]] std::size_t offset() const { return std::min(at_, text_.size()); }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t number_ = 0;
};

constexpr std::string_view kSeparators = " \t,;";

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(kSeparators); at < line.size();) {
    const std::size_t end = std::min(line.find_first_of(kSeparators, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kSeparators, end);
  }
  return words;
}

/// Whether some words are parted by a lone comma and others without one: "1,5 2,5" may be two numbers or four.
bool may_hold_decimal_commas(std::string_view line) {
  bool lone_comma = false;
  bool other = false;
  std::size_t begin = line.find_first_of(kSeparators, line.find_first_not_of(kSeparators));
  while (begin < line.size()) {
    const std::size_t end = line.find_first_not_of(kSeparators, begin);
    if (end == std::string_view::npos) break;
    const std::string_view between = line.substr(begin, end - begin);
    lone_comma = lone_comma || between == ",";
    other = other || between.find(',') == std::string_view::npos;
    begin = line.find_first_of(kSeparators, end);
  }
  return lone_comma && other;
}

template <typename Number>
std::optional<Number> to_number(std::string_view word) {
  Number value{};
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return value;
}

void add_point(const std::array<double, 3>& point, PointCloud& cloud) {
  const bool finite = std::isfinite(point[0]) && std::isfinite(point[1]) && std::isfinite(point[2]);
  if (finite) {
    cloud.points.push_back(point);
  } else {
    ++cloud.dropped;
  }
}

/// One column of a point's record.
struct Field {
  char kind;         ///< 'I' signed, 'U' unsigned, 'F' floating point
  std::size_t size;  ///< bytes
};

/// A cloud's records as a header describes them.
struct Layout {
  std::vector<Field> fields;
  std::array<std::size_t, 3> xyz{};  ///< indices into fields
  std::uint64_t count = 0;
  bool ascii = false;
  bool big_endian = false;
};

template <typename T>
double load(const std::byte* at, bool swap) {
  std::array<std::byte, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), at, sizeof(T));
  if (swap) std::reverse(bytes.begin(), bytes.end());
  return static_cast<double>(std::bit_cast<T>(bytes));
}

double load_field(const Field& field, const std::byte* at, bool swap) {
  switch (field.size) {
    case 1:
      return field.kind == 'U' ? load<std::uint8_t>(at, swap) : load<std::int8_t>(at, swap);
    case 2:
      return field.kind == 'U' ? load<std::uint16_t>(at, swap) : load<std::int16_t>(at, swap);
    case 4:
      if (field.kind == 'F') return load<float>(at, swap);
      return field.kind == 'U' ? load<std::uint32_t>(at, swap) : load<std::int32_t>(at, swap);
    default:
      if (field.kind == 'F') return load<double>(at, swap);
      return field.kind == 'U' ? load<std::uint64_t>(at, swap) : load<std::int64_t>(at, swap);
  }
}

Failure read_binary(const Layout& layout, std::span<const std::byte> data, PointCloud& cloud) {
  std::size_t record = 0;
  std::vector<std::size_t> offsets;
  for (const Field& field : layout.fields) {
    offsets.push_back(record);
    record += field.size;
  }
  if (data.size() / record < layout.count) {
    return "is cut short: " + std::to_string(data.size() / record) + " of " + std::to_string(layout.count) + " points";
  }
  for (std::size_t i = 0; i < layout.count; ++i) {
    std::array<double, 3> point{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t field = layout.xyz[axis];
      point[axis] = load_field(layout.fields[field], data.data() + i * record + offsets[field], layout.big_endian);
    }
    add_point(point, cloud);
  }
  return {};
}

Failure read_row(std::string_view line, std::size_t number, const std::array<std::size_t, 3>& xyz, PointCloud& cloud) {
  if (may_hold_decimal_commas(line)) {
    return "parts numbers with commas and without in line " + std::to_string(number) + "; write decimals with a point";
  }
  const std::vector<std::string_view> words = words_of(line);
  std::array<double, 3> point{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto value = xyz[axis] < words.size() ? to_number<double>(words[xyz[axis]]) : std::nullopt;
    if (!value) return "has no point in line " + std::to_string(number);
    point[axis] = *value;
  }
  add_point(point, cloud);
  return {};
}

Failure read_ascii(const Layout& layout, Lines& lines, PointCloud& cloud) {
  std::string_view line;
  for (std::uint64_t i = 0; i < layout.count;) {
    if (!lines.next(line))
      return "is cut short: " + std::to_string(i) + " of " + std::to_string(layout.count) + " points";
    if (words_of(line).empty()) continue;
    Failure failure = read_row(line, lines.number(), layout.xyz, cloud);
    if (!failure.empty()) return failure;
    ++i;
  }
  return {};
}

Failure read_records(const Layout& layout, std::span<const std::byte> file, Lines& lines, PointCloud& cloud) {
  return layout.ascii ? read_ascii(layout, lines, cloud) : read_binary(layout, file.subspan(lines.offset()), cloud);
}

Failure find_xyz(const std::vector<std::string>& names, Layout& layout) {
  constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto found = std::find(names.begin(), names.end(), kAxes[axis]);
    if (found == names.end()) return "has points without " + std::string(kAxes[axis]);
    layout.xyz[axis] = static_cast<std::size_t>(found - names.begin());
  }
  return {};
}

// ---------------------------------------------------------------------------------------------------------------- ply

std::optional<Field> ply_field(std::string_view type) {
  if (type == "char" || type == "int8") return Field{'I', 1};
  if (type == "uchar" || type == "uint8") return Field{'U', 1};
  if (type == "short" || type == "int16") return Field{'I', 2};
  if (type == "ushort" || type == "uint16") return Field{'U', 2};
  if (type == "int" || type == "int32") return Field{'I', 4};
  if (type == "uint" || type == "uint32") return Field{'U', 4};
  if (type == "float" || type == "float32") return Field{'F', 4};
  if (type == "double" || type == "float64") return Field{'F', 8};
  return std::nullopt;
}

Failure parse_ply(std::span<const std::byte> file, std::string_view text, PointCloud& cloud) {
  Lines lines(text);
  std::string_view line;
  if (!lines.next(line) || line != "ply") return "is no .ply file: its first line is not `ply`";
  Layout layout;
  std::vector<std::string> names;
  bool in_vertices = false;
  bool has_format = false;
  while (lines.next(line)) {
    const std::vector<std::string_view> words = words_of(line);
    std::string place = "has a damaged header in line " + std::to_string(lines.number());
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") {
      if (!has_format) return "has a damaged header: no format";
      Failure failure = find_xyz(names, layout);
      return failure.empty() ? read_records(layout, file, lines, cloud) : failure;
    }
    if (words.size() < 3) return place;
    if (words[0] == "format") {
      layout.ascii = words[1] == "ascii";
      layout.big_endian = words[1] == "binary_big_endian";
      has_format = layout.ascii || layout.big_endian || words[1] == "binary_little_endian";
      if (!has_format) return place;
    } else if (words[0] == "element") {
      if (words[1] != "vertex" && names.empty()) return "does not begin with its vertices";
      in_vertices = words[1] == "vertex";
      if (!in_vertices) continue;
      const auto count = to_number<std::uint64_t>(words[2]);
      if (!count || !names.empty()) return place;
      layout.count = *count;
    } else if (words[0] == "property" && in_vertices) {
      const std::optional<Field> field = ply_field(words[1]);
      if (!field) return place + ": vertices of type " + std::string(words[1].substr(0, 20));
      layout.fields.push_back(*field);
      names.emplace_back(words[2]);
    }
  }
  return "has a damaged header: no end_header";
}

// ---------------------------------------------------------------------------------------------------------------- pcd

/// Header lines of a .pcd that matter, by key.
struct PcdHeader {
  std::vector<std::string_view> fields, sizes, types, counts;
};

Failure pcd_layout(const PcdHeader& header, Layout& layout) {
  const std::size_t columns = header.fields.size();
  if (header.sizes.size() != columns || header.types.size() != columns)
    return "has a damaged header: FIELDS, SIZE, TYPE";
  std::vector<std::string> names;
  for (std::size_t i = 0; i < columns; ++i) {
    const auto size = to_number<std::size_t>(header.sizes[i]);
    const auto repeat = i < header.counts.size() ? to_number<std::size_t>(header.counts[i]) : 1;
    const char kind = header.types[i].front();
    const bool known = size && (*size == 1 || *size == 2 || *size == 4 || *size == 8) && repeat && *repeat <= 4096 &&
                       (kind == 'I' || kind == 'U' || (kind == 'F' && *size >= 4));
    if (!known) return "has a damaged header: field " + std::to_string(i + 1);
    constexpr std::size_t kMaxColumns = 65'536;
    if (layout.fields.size() + *repeat > kMaxColumns) return "has a damaged header: too many fields";
    for (std::size_t k = 0; k < *repeat; ++k) {
      layout.fields.push_back({kind, *size});
      names.emplace_back(k == 0 ? header.fields[i] : "_");
    }
  }
  return find_xyz(names, layout);
}

Failure parse_pcd(std::span<const std::byte> file, std::string_view text, PointCloud& cloud) {
  Lines lines(text);
  std::string_view line;
  Layout layout;
  PcdHeader header;
  while (lines.next(line)) {
    std::vector<std::string_view> words = words_of(line);
    if (words.empty() || words[0].front() == '#') continue;
    const std::string key(words[0].substr(0, 20));
    words.erase(words.begin());
    if (words.empty()) return "is no .pcd file, or has a damaged header in line " + std::to_string(lines.number());
    if (key == "FIELDS") header.fields = words;
    if (key == "SIZE") header.sizes = words;
    if (key == "TYPE") header.types = words;
    if (key == "COUNT") header.counts = words;
    if (key == "POINTS") layout.count = to_number<std::uint64_t>(words[0]).value_or(0);
    if (key == "VIEWPOINT" && words.size() >= 3) {
      for (std::size_t axis = 0; axis < 3; ++axis) cloud.viewpoint[axis] = to_number<double>(words[axis]).value_or(0);
    }
    if (key != "DATA") continue;
    if (words[0] == "binary_compressed")
      return "is compressed; save it as DATA binary (pcl_convert_pcd_ascii_binary IN OUT 1)";
    layout.ascii = words[0] == "ascii";
    if (!layout.ascii && words[0] != "binary")
      return "has a damaged header: DATA " + std::string(words[0].substr(0, 20));
    Failure failure = pcd_layout(header, layout);
    return failure.empty() ? read_records(layout, file, lines, cloud) : failure;
  }
  return "is no .pcd file: no DATA line";
}

// ---------------------------------------------------------------------------------------------------------------- xyz

Failure parse_xyz(std::string_view text, PointCloud& cloud) {
  Lines lines(text);
  std::string_view line;
  while (lines.next(line)) {
    if (words_of(line).empty() || line.front() == '#' || line.substr(0, 2) == "//") continue;
    Failure failure = read_row(line, lines.number(), {0, 1, 2}, cloud);
    if (!failure.empty()) return failure;
  }
  return {};
}

// ------------------------------------------------------------------------------------------------------------- octree

constexpr int kDepth = 16;
using Key = std::array<std::int64_t, 3>;

/// Keys with the bits of x, y and z interleaved, so that sorting puts the children of every octree node side by side.
/// The lowest bit tells occupied from free and sorts occupied last within a voxel.
std::uint64_t to_code(const Key& key, bool occupied) {
  std::uint64_t code = 0;
  for (int bit = 0; bit < kDepth; ++bit) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      code |= (static_cast<std::uint64_t>(key[axis]) >> bit & 1U) << (3 * bit + static_cast<int>(axis));
    }
  }
  return code << 1 | (occupied ? 1U : 0U);
}

void sort_and_thin(std::vector<std::uint64_t>& codes) {
  std::sort(codes.begin(), codes.end());
  codes.erase(std::unique(codes.begin(), codes.end()), codes.end());
}

/// One code a voxel: occupied wins over free.
void let_occupied_win(std::vector<std::uint64_t>& codes) {
  sort_and_thin(codes);
  std::size_t kept = 0;
  for (const std::uint64_t code : codes) {
    if (kept > 0 && codes[kept - 1] >> 1 == code >> 1) --kept;
    codes[kept++] = code;
  }
  codes.resize(kept);
}

/// Child code of the .bt format for the voxels of one cube: a pruned leaf when all of them are known and alike.
unsigned code_of(std::span<const std::uint64_t> voxels, int log2_edge) {
  if (voxels.empty()) return 0;
  const bool occupied = (voxels[0] & 1U) != 0;
  const bool full = voxels.size() == std::uint64_t{1} << (3 * log2_edge);
  const auto alike = [occupied](std::uint64_t code) { return ((code & 1U) != 0) == occupied; };
  if (!full || !std::all_of(voxels.begin(), voxels.end(), alike)) return 3;
  return occupied ? 2 : 1;
}

/// Appends the record of an inner node and of all below it; returns how many nodes those are, leaves included.
std::size_t write_node(std::span<const std::uint64_t> voxels, int log2_edge, std::vector<std::byte>& stream) {
  const int child_log2_edge = log2_edge - 1;
  std::array<std::span<const std::uint64_t>, 8> children;
  unsigned codes = 0;
  std::size_t first = 0;
  for (unsigned child = 0; child < 8; ++child) {
    const auto belongs = [&](std::uint64_t code) { return (code >> (3 * child_log2_edge + 1) & 7U) == child; };
    const auto begin = voxels.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = std::partition_point(begin, voxels.end(), belongs);
    children[child] = {begin, end};
    first += children[child].size();
    codes |= code_of(children[child], child_log2_edge) << (2 * child);
  }
  stream.push_back(static_cast<std::byte>(codes & 255U));
  stream.push_back(static_cast<std::byte>(codes >> 8));
  std::size_t nodes = 1;
  for (unsigned child = 0; child < 8; ++child) {
    const unsigned code = codes >> (2 * child) & 3U;
    if (code == 3) nodes += write_node(children[child], child_log2_edge, stream);
    if (code == 1 || code == 2) ++nodes;
  }
  return nodes;
}

std::optional<Key> key_of(const std::array<double, 3>& point, double resolution) {
  constexpr double kHalf = 1 << (kDepth - 1);
  Key key{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double voxel = std::floor(point[axis] / resolution) + kHalf;
    if (!(voxel >= 0 && voxel < 2 * kHalf)) return std::nullopt;
    key[axis] = static_cast<std::int64_t>(voxel);
  }
  return key;
}

/// Calls `visit` for the voxels on the straight way between two points, the last one excluded (Amanatides and Woo).
template <typename Visit>
void walk(const std::array<double, 3>& from, const std::array<double, 3>& to, const Key& first, const Key& last,
          double resolution, const Visit& visit) {
  constexpr double kHalf = 1 << (kDepth - 1);
  Key key = first;
  std::array<double, 3> next{};  // at which share of the way the next face on each axis is crossed
  std::int64_t steps = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t ahead = last[axis] > first[axis] ? 1 : 0;
    const double face = (static_cast<double>(key[axis] + ahead) - kHalf) * resolution;
    next[axis] = first[axis] == last[axis] ? 2 : (face - from[axis]) / (to[axis] - from[axis]);
    steps += std::abs(last[axis] - first[axis]);
  }
  for (; steps > 0; --steps) {
    visit(key);
    std::size_t axis = key[0] == last[0] ? 1 : 0;
    for (std::size_t other = 0; other < 3; ++other) {
      const bool open = key[other] != last[other];
      if (open && (key[axis] == last[axis] || next[other] < next[axis])) axis = other;
    }
    const std::int64_t direction = last[axis] > first[axis] ? 1 : -1;
    key[axis] += direction;
    next[axis] += resolution / std::abs(to[axis] - from[axis]);
  }
}

}  // namespace

Expected<PointCloud> parse_point_cloud(const std::string& name, std::span<const std::byte> file) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  std::string lower = name;
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto ends_with = [&lower](std::string_view end) { return std::string_view(lower).ends_with(end); };
  PointCloud cloud;
  Failure failure;
  if (file.empty()) {
    failure = "is empty; expected a point cloud (.ply, .pcd, .xyz)";
  } else if (ends_with(".ply")) {
    failure = parse_ply(file, text, cloud);
  } else if (ends_with(".pcd")) {
    failure = parse_pcd(file, text, cloud);
  } else if (ends_with(".xyz")) {
    failure = parse_xyz(text, cloud);
  } else {
    failure = "is none of .ply, .pcd, .xyz; convert it (a .las as docs/import.md says)";
  }
  if (failure.empty() && cloud.points.empty()) failure = "holds no finite point";
  if (!failure.empty()) return bad_file(name + ": " + failure);
  return cloud;
}

Expected<PointCloud> read_point_cloud(const std::string& path) {
  const Expected<std::vector<std::byte>> file = read_file(path);
  if (!file) return tl::unexpected(file.error());
  return parse_point_cloud(path, *file);
}

Expected<std::vector<std::byte>> octree_of(const PointCloud& cloud, const std::string& name, double resolution,
                                           bool origin_rays, const Progress& progress) {
  const auto too_wide = [&](const char* what) {
    return bad_file(name + ": " + what +
                    " lies beyond the 32,768 voxels on each side of the origin; choose a larger --resolution");
  };
  const std::optional<Key> eye = key_of(cloud.viewpoint, resolution);
  if (origin_rays && !eye) return too_wide("the viewpoint");
  constexpr std::size_t kThinFrom = std::size_t{1} << 24;  // rays cross the same voxels over and over
  std::size_t limit = kThinFrom;
  std::vector<std::uint64_t> codes;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const auto& point = cloud.points[i];
    if (progress && i % 1024 == 0)
      progress("import", static_cast<double>(i) / static_cast<double>(cloud.points.size()));
    const std::optional<Key> key = key_of(point, resolution);
    if (!key) return too_wide("a point");
    codes.push_back(to_code(*key, true));
    if (!origin_rays) continue;
    walk(cloud.viewpoint, point, *eye, *key, resolution, [&](const Key& k) { codes.push_back(to_code(k, false)); });
    if (codes.size() < limit) continue;
    sort_and_thin(codes);
    limit = std::max(kThinFrom, 2 * codes.size());
  }
  let_occupied_win(codes);

  std::vector<std::byte> stream;
  const std::size_t nodes = write_node(codes, kDepth, stream);
  std::array<char, 32> number{};
  const auto printed = std::to_chars(number.data(), number.data() + number.size(), resolution);
  const std::string header = "# Octomap OcTree binary file\nid OcTree\nsize " + std::to_string(nodes) + "\nres " +
                             std::string(number.data(), printed.ptr) + "\ndata\n";
  std::vector<std::byte> file(header.size() + stream.size());
  std::memcpy(file.data(), header.data(), header.size());
  std::memcpy(file.data() + header.size(), stream.data(), stream.size());
  return file;
}

}  // namespace swiftlet::tools
