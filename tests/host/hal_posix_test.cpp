#include <gtest/gtest.h>
#include <poll.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <string>

#include "swiftlet/hal/file_storage.hpp"
#include "swiftlet/hal/monotonic_clock.hpp"
#include "swiftlet/hal/posix_uart.hpp"

namespace {

using swiftlet::hal::PosixUart;
using swiftlet::hal::PseudoTerminal;
using swiftlet::hal::SerialPort;
using swiftlet::hal::UdpUart;

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

/// What arrives until there are `size` bytes; gives up after two seconds without any.
std::string read_text(PosixUart& uart, std::size_t size) {
  std::string text;
  while (text.size() < size) {
    pollfd waiting{uart.descriptor(), POLLIN, 0};
    if (::poll(&waiting, 1, 2000) <= 0) break;
    std::array<std::byte, 256> got{};
    const std::size_t count = uart.read(got);
    if (count == 0 && !uart.is_open()) break;
    text.append(reinterpret_cast<const char*>(got.data()), count);
  }
  return text;
}

TEST(SerialPort, CarriesEveryByteValueOverAPseudoTerminalAt921600Baud) {
  PseudoTerminal far_end;
  ASSERT_TRUE(far_end.open());
  SerialPort port;
  ASSERT_TRUE(port.open(far_end.peer_path().c_str(), 921600));
  std::string all;
  for (int value = 0; value < 256; ++value) all.push_back(static_cast<char>(value));
  EXPECT_EQ(port.write(bytes_of(all)), all.size());
  EXPECT_EQ(read_text(far_end, all.size()), all);
  EXPECT_EQ(far_end.write(bytes_of(all)), all.size());
  EXPECT_EQ(read_text(port, all.size()), all);
}

TEST(SerialPort, TakesAnyBaudRate) {
  PseudoTerminal far_end;
  ASSERT_TRUE(far_end.open());
  for (const std::uint32_t baud : {57600U, 123456U, 1'500'000U}) {
    SerialPort port;
    EXPECT_TRUE(port.open(far_end.peer_path().c_str(), baud)) << baud;
  }
}

TEST(SerialPort, DiscardsWhatWasWaitingWhenItOpened) {
  PseudoTerminal far_end;
  ASSERT_TRUE(far_end.open());
  {
    SerialPort first;  // makes the terminal raw, so that the stale bytes are not echoed
    ASSERT_TRUE(first.open(far_end.peer_path().c_str(), 921600));
  }
  far_end.write(bytes_of("stale"));
  SerialPort port;
  ASSERT_TRUE(port.open(far_end.peer_path().c_str(), 921600));
  far_end.write(bytes_of("fresh"));
  EXPECT_EQ(read_text(port, 5), "fresh");
}

TEST(SerialPort, NeverBlocksAndSurvivesAFullLineAndALostPeer) {
  SerialPort port;
  {
    PseudoTerminal far_end;
    ASSERT_TRUE(far_end.open());
    ASSERT_TRUE(port.open(far_end.peer_path().c_str(), 921600));
    std::array<std::byte, 16> none{};
    EXPECT_EQ(port.read(none), 0U);
    EXPECT_TRUE(port.is_open());
    const std::string block(4096, 'x');
    std::size_t taken = 0;
    for (int i = 0; i < 1000; ++i) taken += port.write(bytes_of(block));
    EXPECT_GT(taken, 0U);
    EXPECT_LT(taken, 4096U * 1000U);
  }
  std::array<std::byte, 16> none{};
  EXPECT_EQ(port.read(none), 0U);
  EXPECT_FALSE(port.is_open());
  EXPECT_EQ(port.write(bytes_of("gone")), 0U);
}

TEST(SerialPort, RefusesWhatIsNoTerminal) {
  SerialPort port;
  EXPECT_FALSE(port.open("/nonexistent", 921600));
  EXPECT_EQ(errno, ENOENT);
  EXPECT_FALSE(port.open("/dev/null", 921600));
  EXPECT_FALSE(port.is_open());
}

TEST(UdpUart, AnswersWhoeverSpokeLast) {
  UdpUart autopilot;
  ASSERT_TRUE(autopilot.open(0, "127.0.0.1", 0));
  EXPECT_EQ(autopilot.write(bytes_of("nobody yet")), 0U);
  UdpUart companion;
  ASSERT_TRUE(companion.open(0, "127.0.0.1", autopilot.local_port()));
  EXPECT_EQ(companion.write(bytes_of("hello")), 5U);
  EXPECT_EQ(read_text(autopilot, 5), "hello");
  EXPECT_EQ(autopilot.write(bytes_of("back")), 4U);
  std::array<std::byte, 1> one{};
  EXPECT_EQ(read_text(companion, 4), "back");
  EXPECT_EQ(companion.read(one), 0U);
  EXPECT_FALSE(UdpUart().open(0, "no address", 5));
}

TEST(MonotonicClock, DoesNotGoBack) {
  swiftlet::hal::MonotonicClock clock;
  const auto first = clock.now();
  EXPECT_GT(first.count(), 0);
  EXPECT_GE(clock.now(), first);
}

TEST(FileStorage, AppendsReadsAndRemoves) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "swiftlet_file_storage";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  swiftlet::hal::FileStorage storage(folder.string());
  std::array<std::byte, 8> got{};
  EXPECT_FALSE(storage.read("log", 0, got).has_value());
  EXPECT_TRUE(storage.append("log", bytes_of("abc")));
  EXPECT_TRUE(storage.append("other", bytes_of("x")));
  EXPECT_TRUE(storage.append("log", bytes_of("def")));
  EXPECT_EQ(storage.read("log", 1, got), 5U);
  EXPECT_EQ(std::memcmp(got.data(), "bcdef", 5), 0);
  EXPECT_EQ(storage.read("log", 6, got), 0U);
  EXPECT_FALSE(storage.append("../escape", bytes_of("x")));
  EXPECT_TRUE(storage.remove("log"));
  EXPECT_FALSE(storage.read("log", 0, got).has_value());
  EXPECT_TRUE(storage.append("log", bytes_of("new")));  // not into the file that was removed
  EXPECT_EQ(storage.read("log", 0, got), 3U);
}

TEST(FileStorage, SaysWhenTheDeviceIsFull) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP();
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "swiftlet_full_storage";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::filesystem::create_symlink("/dev/full", folder / "log");
  swiftlet::hal::FileStorage storage(folder.string());
  EXPECT_FALSE(storage.append("log", bytes_of("abc")));
}

}  // namespace
