#include "companion/flight_log.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include "swiftlet/hal/fake_storage.hpp"
#include "swiftlet_test.hpp"

namespace {

using namespace swiftlet;             // NOLINT(google-build-using-namespace)
using namespace swiftlet::companion;  // NOLINT(google-build-using-namespace)
using swiftlet::hal::FakeStorage;

constexpr LogHeader kHeader{
    .version = "1", .board = "test", .settings = "{}", .map_crc32 = 0x1234, .map_file = "/a.swm"};

/// The bytes of a log in a storage.
struct Stored {
  std::array<std::byte, FakeStorage::kBytes> bytes{};
  std::size_t size = 0;
};
Stored the_stored;  // too large for a stack

const Stored& stored(FakeStorage& storage) {
  the_stored.size = storage.read("a.ulg", 0, the_stored.bytes).value_or(0);
  return the_stored;
}

std::size_t size_of_message(const Stored& log, std::size_t at) {
  std::uint16_t size = 0;
  std::memcpy(&size, &log.bytes[at], sizeof(size));
  return 3 + std::size_t{size};
}

/// The messages of a type, and whether the log ends with a whole one.
struct Messages {
  std::size_t count = 0;
  std::size_t last = 0;  ///< where it begins
  bool whole = false;
};
Messages find_messages(const Stored& log, char type) {
  Messages found;
  std::size_t at = 16;
  while (at + 3 <= log.size) {
    if (at + size_of_message(log, at) > log.size) break;
    if (log.bytes[at + 2] == static_cast<std::byte>(type)) {
      ++found.count;
      found.last = at;
    }
    at += size_of_message(log, at);
  }
  found.whole = at == log.size;
  return found;
}

Telemetry flying(TimeUs now) {
  Telemetry telemetry;
  telemetry.time = now;
  telemetry.state = FlightState::kFlying;
  telemetry.has_estimate = true;
  telemetry.estimate.time = now - 5000;
  telemetry.estimate.position = {1, 2, 3};
  telemetry.has_reference = true;
  telemetry.reference.sample = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {0, 0, 0}};
  telemetry.sent = true;
  telemetry.form = SetpointForm::kAttitude;
  return telemetry;
}

void fly(FlightLog& log, int steps) {
  for (int i = 0; i < steps; ++i) {
    const TimeUs now = 1'000'000 + 10'000 * TimeUs{i};
    log.begin_step(now);
    log.end_step(flying(now));
  }
}

}  // namespace

TEST(UlogFormat, KnowsTheSizesOfItsTypes) {
  EXPECT_EQ(ulog_format_size("a:uint64_t timestamp;float x;bool b;char[12] c;"), std::size_t{25});
  EXPECT_EQ(ulog_format_size("a:uint64_t timestamp;vec3 x;"), std::size_t{0});
}

TEST(FlightLog, BeginsAsTheFormatSays) {
  FakeStorage storage;
  FlightLog log(storage);
  EXPECT_TRUE(log.full());
  ASSERT_TRUE(log.begin("a.ulg", 7, kHeader));
  EXPECT_FALSE(log.full());
  const Stored& bytes = stored(storage);
  const std::array<std::uint8_t, 16> header{'U', 'L', 'o', 'g', 1, 0x12, 0x35, 1, 7, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(std::memcmp(bytes.bytes.data(), header.data(), header.size()), 0);
  EXPECT_EQ(bytes.bytes[18], static_cast<std::byte>('B'));  // the flags are the first message
  EXPECT_EQ(find_messages(bytes, 'F').count, std::size_t{topic::kCount});
  EXPECT_EQ(find_messages(bytes, 'A').count, std::size_t{topic::kCount});
  EXPECT_TRUE(find_messages(bytes, 'A').whole);
  EXPECT_EQ(bytes.size, log.bytes());
}

TEST(FlightLog, NamesTheFileOfEachMap) {
  FakeStorage storage;
  FlightLog log(storage);
  ASSERT_TRUE(log.begin("a.ulg", 0, kHeader));
  const auto holds = [&storage](std::string_view text) {
    const Stored& bytes = stored(storage);
    const auto begin = reinterpret_cast<const char*>(bytes.bytes.data());
    return std::string_view(begin, bytes.size).find(text) != std::string_view::npos;
  };
  EXPECT_TRUE(holds("char[6] swiftlet_map_file_00001234/a.swm"));
  const std::size_t before = find_messages(stored(storage), 'I').count;
  log.note_map(0xFEDCBA98, "/maps/b.swm");
  log.note_map(0x76543210, {});  // of no file
  fly(log, 1);
  EXPECT_TRUE(holds("char[11] swiftlet_map_file_fedcba98/maps/b.swm"));
  EXPECT_EQ(find_messages(stored(storage), 'I').count, before + 1);
  EXPECT_TRUE(find_messages(stored(storage), 'D').whole);
}

TEST(FlightLog, IsWholeAfterEveryStep) {
  FakeStorage storage;
  FlightLog log(storage);
  ASSERT_TRUE(log.begin("a.ulg", 0, kHeader));
  for (int i = 1; i < 20; ++i) {
    fly(log, 1);
    EXPECT_TRUE(find_messages(stored(storage), 'D').whole);
    EXPECT_EQ(the_stored.size, log.bytes());
  }
}

TEST(FlightLog, WritesAnEstimateOnce) {
  FakeStorage storage;
  FlightLog log(storage);
  ASSERT_TRUE(log.begin("a.ulg", 0, kHeader));
  const std::size_t before = find_messages(stored(storage), 'D').count;
  for (int i = 0; i < 2; ++i) {
    Telemetry telemetry = flying(1'000'000);
    telemetry.sent = false;
    telemetry.time += 10'000 * TimeUs{i};
    log.end_step(telemetry);
  }
  EXPECT_EQ(find_messages(stored(storage), 'D').count, before + 3 + 1);  // position, attitude, rates; one status
}

TEST(FlightLog, WritesTransitionsAndNotesAsTexts) {
  FakeStorage storage;
  FlightLog log(storage);
  ASSERT_TRUE(log.begin("a.ulg", 0, kHeader));
  log.write(FlightEvent{5, FlightState::kFlying, FlightState::kBraking, Reason::kOdometryStale});
  Note note;
  note.time = 6;
  std::strncpy(note.text.data(), "goal refused", note.text.size() - 1);
  log.write(note);
  log.end();
  const Messages texts = find_messages(stored(storage), 'L');
  EXPECT_EQ(texts.count, std::size_t{2});
  EXPECT_EQ(std::memcmp(&the_stored.bytes[texts.last + 3], "6\x06\0\0\0\0\0\0\0goal refused", 21), 0);
}

TEST(FlightLog, AFullStorageEndsItAndNothingMoreIsKept) {
  FakeStorage storage;
  FlightLog log(storage);
  ASSERT_TRUE(log.begin("a.ulg", 0, kHeader));
  storage.set_free_bytes(1000);
  fly(log, 3);
  EXPECT_FALSE(log.full());
  fly(log, 20);
  EXPECT_TRUE(log.full());
  const std::size_t size = stored(storage).size;
  storage.set_free_bytes(10'000);
  fly(log, 3);
  log.end();
  EXPECT_EQ(stored(storage).size, size);
}

TEST(FlightLog, IsFullFromTheBeginningWithoutRoomOrWithAnUsedName) {
  FakeStorage storage;
  FlightLog log(storage);
  storage.set_free_bytes(100);
  EXPECT_FALSE(log.begin("a.ulg", 0, kHeader));
  EXPECT_TRUE(log.full());
  storage.set_free_bytes(10'000);
  EXPECT_FALSE(log.begin("a.ulg", 0, kHeader));
  EXPECT_FALSE(log.begin("no such/name", 0, kHeader));
  EXPECT_TRUE(log.begin("b.ulg", 0, kHeader));
}

TEST(FlightLog, ALongReadAndTextPassThroughItsBuffer) {
  FakeStorage storage;
  FlightLog log(storage);
  std::array<char, 5000> settings{};
  settings.fill('x');
  LogHeader header = kHeader;
  header.settings = {settings.data(), settings.size()};
  ASSERT_TRUE(log.begin("a.ulg", 0, header));
  EXPECT_TRUE(find_messages(stored(storage), 'I').whole);
  const std::array<std::byte, 4096> bytes{};
  log.begin_step(1);
  log.note_read(bytes);
  log.end();
  EXPECT_TRUE(find_messages(stored(storage), 'D').whole);
  EXPECT_EQ(find_messages(the_stored, 'D').count, (9 + 3 + 4096) / sizeof(topic::Input::bytes) + 1);
}
