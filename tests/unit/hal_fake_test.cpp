#include <array>
#include <cstring>

#include "swiftlet/hal/fake_clock.hpp"
#include "swiftlet/hal/fake_console.hpp"
#include "swiftlet/hal/fake_line.hpp"
#include "swiftlet/hal/fake_storage.hpp"
#include "swiftlet_test.hpp"

namespace {

using namespace std::chrono_literals;
using swiftlet::hal::FakeClock;
using swiftlet::hal::FakeLine;

std::span<const std::byte> bytes_of(const char* text) { return std::as_bytes(std::span(text, std::strlen(text))); }

/// Reads at most 64 bytes; whether they are `expected`.
bool reads(swiftlet::hal::Uart& uart, const char* expected) {
  std::array<std::byte, 64> got{};
  const std::size_t count = uart.read(got);
  return count == std::strlen(expected) && std::memcmp(got.data(), expected, count) == 0;
}

FakeClock the_clock;
FakeLine quiet_line(the_clock, 1);

TEST(FakeLine, CarriesBytesBothWays) {
  EXPECT_EQ(quiet_line.end_a().write(bytes_of("to b")), 4);
  EXPECT_EQ(quiet_line.end_b().write(bytes_of("to a!")), 5);
  EXPECT_TRUE(reads(quiet_line.end_b(), "to b"));
  EXPECT_TRUE(reads(quiet_line.end_a(), "to a!"));
  EXPECT_TRUE(reads(quiet_line.end_a(), ""));
}

TEST(FakeLine, DelaysAndStalls) {
  static FakeLine line(the_clock, 2);
  line.a_to_b().delay = 5ms;
  line.end_a().write(bytes_of("late"));
  the_clock.advance(4999us);
  EXPECT_TRUE(reads(line.end_b(), ""));
  the_clock.advance(1us);
  EXPECT_TRUE(reads(line.end_b(), "late"));
  line.a_to_b().stalled_until = the_clock.now() + 200ms;
  line.end_a().write(bytes_of("held"));
  the_clock.advance(199ms);
  EXPECT_TRUE(reads(line.end_b(), ""));
  the_clock.advance(1ms);
  EXPECT_TRUE(reads(line.end_b(), "held"));
}

TEST(FakeLine, CutsAfterTheByteThatWasAskedFor) {
  static FakeLine line(the_clock, 3);
  line.a_to_b().cut_after_bytes = 3;
  EXPECT_EQ(line.end_a().write(bytes_of("abcdef")), 6);
  EXPECT_TRUE(reads(line.end_b(), "abc"));
  line.end_b().write(bytes_of("still"));
  EXPECT_TRUE(reads(line.end_a(), "still"));
}

TEST(FakeLine, OverrunsKeepTheFirstBytesAndAreCounted) {
  static FakeLine line(the_clock, 4);
  line.a_to_b().receive_buffer = 4;
  line.end_a().write(bytes_of("123456"));
  EXPECT_TRUE(reads(line.end_b(), "1234"));
  EXPECT_EQ(line.end_b().overruns(), 2);
  line.end_a().write(bytes_of("78"));
  EXPECT_TRUE(reads(line.end_b(), "78"));
}

TEST(FakeLine, AFullDeviceTakesNoMoreThanItHolds) {
  static FakeLine line(the_clock, 5);
  static std::array<std::byte, 10000> many{};
  EXPECT_EQ(line.end_a().write(many), 4096);
  EXPECT_EQ(line.end_a().write(many), 0);
}

/// Sends 4000 zero bytes over a line that drops 10 % and corrupts 10 %; a sum that depends on every fault.
std::uint64_t fault_digest(FakeLine& line, std::size_t& arrived, std::size_t& damaged) {
  static std::array<std::byte, 4000> bytes;
  bytes.fill(std::byte{0});
  line.a_to_b().drop_ppm = 100'000;
  line.a_to_b().corrupt_ppm = 100'000;
  line.end_a().write(bytes);
  arrived = line.end_b().read(bytes);
  std::uint64_t digest = 0;
  damaged = 0;
  for (std::size_t i = 0; i < arrived; ++i) {
    damaged += bytes[i] != std::byte{0} ? 1 : 0;
    digest = digest * 31 + static_cast<std::uint64_t>(bytes[i]);
  }
  return digest;
}

TEST(FakeLine, FaultsComeAtTheirRateAndAreTheSameForTheSameSeed) {
  static FakeLine line(the_clock, 6);
  static FakeLine same(the_clock, 6);
  static FakeLine other(the_clock, 7);
  std::size_t arrived = 0;
  std::size_t damaged = 0;
  const std::uint64_t digest = fault_digest(line, arrived, damaged);
  EXPECT_NEAR(static_cast<double>(arrived), 3600, 80);
  EXPECT_NEAR(static_cast<double>(damaged), 360, 80);
  EXPECT_EQ(digest, fault_digest(same, arrived, damaged));
  EXPECT_NE(digest, fault_digest(other, arrived, damaged));
}

TEST(FakeConsole, KeepsWhatFitsAndCountsTheRest) {
  FakeClock clock;
  swiftlet::hal::FakeConsole console(clock);
  const std::array<char, 3000> text{};
  console.write(text);
  EXPECT_EQ(console.text().size(), 3000);
  console.write(text);
  EXPECT_EQ(console.text().size(), 4096);
  EXPECT_EQ(console.lost(), 6000 - 4096);
  EXPECT_TRUE(clock.now() == 0us);
}

TEST(FakeConsole, LetsItsWriterWait) {
  FakeClock clock;
  swiftlet::hal::FakeConsole console(clock);
  console.faults() = {.byte_time = 10us, .stalled_until = 5ms};
  console.write(std::string_view("late"));
  EXPECT_TRUE(clock.now() == 5040us);
  console.write(std::string_view("later"));
  EXPECT_TRUE(clock.now() == 5090us);
  EXPECT_TRUE(console.text() == "latelater");
}

TEST(FakeStorage, KeepsWhatWasAppendedUntilItIsFull) {
  static swiftlet::hal::FakeStorage storage;
  std::array<std::byte, 8> got{};
  EXPECT_FALSE(storage.read("log", 0, got).has_value());
  EXPECT_TRUE(storage.append("log", bytes_of("abc")));
  storage.set_free_bytes(4);
  EXPECT_TRUE(storage.append("log", bytes_of("def")));
  EXPECT_FALSE(storage.append("log", bytes_of("gh")));
  const auto count = storage.read("log", 1, got);
  ASSERT_TRUE(count.has_value());
  EXPECT_EQ(*count, 6);
  EXPECT_EQ(std::memcmp(got.data(), "bcdefg", 6), 0);
  EXPECT_TRUE(storage.remove("log"));
  EXPECT_FALSE(storage.read("log", 0, got).has_value());
}

TEST(FakeStorage, RefusesNamesThatCouldLeaveTheFolder) {
  EXPECT_TRUE(swiftlet::hal::is_storage_name("flight_12-a.ulg"));
  for (const char* name : {"", ".hidden", "..", "a/b", "a b", "\xC3\xA4"}) {
    EXPECT_FALSE(swiftlet::hal::is_storage_name(name));
  }
}

}  // namespace
