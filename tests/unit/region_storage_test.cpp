#include "swiftlet/hal/region_storage.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include "swiftlet_test.hpp"

namespace {

using swiftlet::hal::RegionStorage;

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

bool holds(RegionStorage& storage, const char* name, std::string_view expected) {
  std::array<std::byte, 600> got{};
  const auto count = storage.read(name, 0, got);
  return count && *count == expected.size() && std::memcmp(got.data(), expected.data(), expected.size()) == 0;
}

TEST(RegionStorage, KeepsFilesThatGrowInTurns) {
  std::array<std::byte, 1000> region{};
  RegionStorage storage(region);
  std::array<std::byte, 4> got{};
  EXPECT_FALSE(storage.read("a", 0, got).has_value());
  EXPECT_TRUE(storage.append("a", bytes_of("one ")));
  EXPECT_TRUE(storage.append("a", bytes_of("two ")));
  EXPECT_TRUE(storage.append("b", bytes_of("other")));
  EXPECT_TRUE(storage.append("a", bytes_of("three")));
  EXPECT_TRUE(holds(storage, "a", "one two three"));
  EXPECT_TRUE(holds(storage, "b", "other"));
  EXPECT_EQ(storage.read("a", 6, got).value_or(0), 4);
  EXPECT_EQ(std::memcmp(got.data(), "o th", 4), 0);
  EXPECT_EQ(storage.read("a", 13, got).value_or(99), 0);
  EXPECT_EQ(storage.read("a", 99, got).value_or(99), 0);
}

TEST(RegionStorage, AnEmptyAppendMakesAFile) {
  std::array<std::byte, 200> region{};
  RegionStorage storage(region);
  EXPECT_TRUE(storage.append("a", {}));
  EXPECT_TRUE(holds(storage, "a", ""));
}

TEST(RegionStorage, StoresWhatFitsAndSaysSo) {
  std::array<std::byte, 200> region{};
  RegionStorage storage(region);
  EXPECT_TRUE(storage.append("a", bytes_of("x")));
  const std::size_t left = storage.free_bytes();
  const std::array<std::byte, 200> many{};
  EXPECT_FALSE(storage.append("a", many));
  std::array<std::byte, 200> got{};
  EXPECT_EQ(storage.read("a", 0, got).value_or(0), 1 + left);
  EXPECT_EQ(storage.free_bytes(), 0);
  EXPECT_FALSE(storage.append("b", {}));
  EXPECT_FALSE(storage.read("b", 0, got).has_value());
}

TEST(RegionStorage, GivesBackTheRoomOfWhatIsRemoved) {
  std::array<std::byte, 1000> region{};
  RegionStorage storage(region);
  const std::size_t empty = storage.free_bytes();
  for (const char* text : {"1", "2", "3"}) {
    EXPECT_TRUE(storage.append("gone", bytes_of(text)));
    EXPECT_TRUE(storage.append("kept", bytes_of(text)));
  }
  EXPECT_TRUE(storage.append("gone", bytes_of("4")));
  EXPECT_TRUE(storage.remove("gone"));
  EXPECT_TRUE(storage.remove("gone"));
  EXPECT_FALSE(storage.remove("../gone"));
  EXPECT_TRUE(holds(storage, "kept", "123"));
  EXPECT_TRUE(storage.append("kept", bytes_of("5")));
  EXPECT_TRUE(holds(storage, "kept", "1235"));
  EXPECT_TRUE(storage.remove("kept"));
  EXPECT_EQ(storage.free_bytes(), empty);
}

TEST(RegionStorage, RefusesNamesThatAreNone) {
  std::array<std::byte, 1000> region{};
  RegionStorage storage(region);
  EXPECT_FALSE(storage.append("", bytes_of("x")));
  EXPECT_FALSE(storage.append("a/b", bytes_of("x")));
  std::array<std::byte, 1> got{};
  EXPECT_FALSE(storage.read("", 0, got).has_value());
}

TEST(RegionStorage, ASmallRegionIsAFullOne) {
  std::array<std::byte, 90> region{};
  for (const std::size_t size : {0, 3, 12, 79, 80}) {
    const std::span<std::byte> all = region;
    RegionStorage storage(all.first(size));
    EXPECT_EQ(storage.append("a", {}), size >= 80);
    EXPECT_FALSE(storage.append("a", bytes_of("x")));
  }
}

TEST(RegionStorage, FindsItsFilesAgainInARegionThatKeptThem) {
  std::array<std::byte, 1000> region{};
  {
    RegionStorage storage(region);
    EXPECT_TRUE(storage.append("a", bytes_of("one")));
    EXPECT_TRUE(storage.append("b", bytes_of("two")));
  }
  RegionStorage again(region);
  EXPECT_TRUE(holds(again, "a", "one"));
  EXPECT_TRUE(again.append("b", bytes_of(" more")));
  EXPECT_TRUE(holds(again, "b", "two more"));
}

/// Whatever the region holds, what opens is a storage that works.
TEST(RegionStorage, BeginsEmptyInARegionThatIsDamaged) {
  std::array<std::byte, 400> region{};
  for (std::size_t damaged = 0; damaged < 250; ++damaged) {
    region.fill(std::byte{0});
    {
      RegionStorage storage(region);
      EXPECT_TRUE(storage.append("a", bytes_of("one")));
      EXPECT_TRUE(storage.append("b", bytes_of("two")));
    }
    region[damaged] ^= std::byte{0x80};
    RegionStorage storage(region);
    EXPECT_TRUE(storage.append("c", bytes_of("three")));
    EXPECT_TRUE(holds(storage, "c", "three"));
    std::array<std::byte, 1> got{};
    const bool has_a = storage.read("a", 0, got).has_value();
    const bool has_b = storage.read("b", 0, got).has_value();
    EXPECT_EQ(has_a, has_b);  // all or nothing
    const bool in_front = damaged < 12;
    const bool in_name_or_size = damaged == 12 || (damaged >= 76 && damaged < 80);
    EXPECT_TRUE(!has_a || !(in_front || in_name_or_size));
  }
}

/// A reset may come between any two stores of an append: all states of the region that it can leave are whole.
TEST(RegionStorage, AppendsAreWholeOrWereNot) {
  std::array<std::byte, 400> before{};
  std::array<std::byte, 400> after{};
  {
    RegionStorage storage(before);
    EXPECT_TRUE(storage.append("a", bytes_of("one")));
    after = before;
    RegionStorage later(after);
    EXPECT_TRUE(later.append("b", bytes_of("two")));
  }
  // In the order of writing: the new bytes, the size of the piece before them, the number of bytes in use.
  constexpr std::size_t kUsed = 8;
  constexpr std::size_t kSizeOfA = 12 + 64;
  std::array<std::byte, 400> torn = after;
  std::copy_n(before.begin() + kUsed, 4, torn.begin() + kUsed);
  RegionStorage closed(torn);
  EXPECT_TRUE(holds(closed, "a", "one"));
  EXPECT_TRUE(closed.append("a", bytes_of(" more")));
  EXPECT_TRUE(holds(closed, "a", "one more"));
  torn = after;
  std::copy_n(before.begin() + kUsed, 4, torn.begin() + kUsed);
  std::copy_n(before.begin() + kSizeOfA, 4, torn.begin() + kSizeOfA);
  RegionStorage open(torn);
  EXPECT_TRUE(holds(open, "a", "one"));
}

}  // namespace
