#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "map/map_builder.hpp"
#include "map_test_files.hpp"

namespace swiftlet::tools {
namespace {

/// The bytes of the one hex dump in docs/map_format.md: lines of an offset, a colon and up to 16 bytes.
std::string documented_dump() {
  std::ifstream document(std::filesystem::path(SWIFTLET_SOURCE_DIR) / "docs" / "map_format.md");
  std::string dump;
  for (std::string line; std::getline(document, line);) {
    const bool is_dump = line.size() > 5 && line[4] == ':' && line.find_first_not_of("0123456789abcdef: ") == line.npos;
    if (is_dump) dump += line + "\n";
  }
  return dump;
}

std::string dump_of(const std::vector<std::byte>& bytes) {
  std::ostringstream text;
  text << std::hex;
  const auto put = [&text](std::size_t value, int digits) {
    text.width(digits);
    text.fill('0');
    text << value;
  };
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (i % 16 == 0) {
      put(i, 4);
      text << ':';
    }
    text << ' ';
    put(std::to_integer<std::size_t>(bytes[i]), 2);
    if (i % 16 == 15 || i + 1 == bytes.size()) text << '\n';
  }
  return text.str();
}

TEST(MapFormat, TheWorkedExampleOfTheDocumentIsWhatTheBuilderWrites) {
  test::Voxels voxels;
  for (std::uint16_t x = 0; x < 4; ++x) {
    for (std::uint16_t y = 0; y < 3; ++y) {
      const auto key = [](int i) { return static_cast<std::uint16_t>(i); };
      voxels[{key(32'766 + x), key(32'768 + y), 32'772}] = x == 0 && y == 0;
    }
  }
  const auto map = parse_octree("example.bt", test::OctomapFile(voxels, 0.5, test::FileKind::kBt).bytes());
  ASSERT_TRUE(map.has_value());
  MapBuildOptions options;
  options.radius = 0.5;
  const auto built = build_map(*map, "example.bt", options, [](std::string_view, double) {});
  ASSERT_TRUE(built.has_value());
  EXPECT_EQ(dump_of(built->blob), documented_dump());
}

}  // namespace
}  // namespace swiftlet::tools
