#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "flight/flight_inputs.hpp"
#include "flight/memory_storage.hpp"
#include "flight/ulog_reader.hpp"
#include "sample_flight_log.hpp"

namespace swiftlet::tools {
namespace {

const std::vector<std::byte>& sample() {
  static const std::vector<std::byte> bytes = [] {
    MemoryStorage storage;
    companion::FlightLog log(storage);
    companion::write_sample(log, "sample.ulg");
    return storage.bytes();
  }();
  return bytes;
}

std::string refusal(std::vector<std::byte> bytes) {
  const auto log = parse_ulog("a.ulg", std::move(bytes));
  if (!log) return log.error().message;
  const auto inputs = flight_inputs(*log);
  return inputs ? "" : inputs.error().message;
}

std::vector<std::byte> sample_with(std::size_t offset, char value) {
  std::vector<std::byte> bytes = sample();
  bytes[offset] = static_cast<std::byte>(value);
  return bytes;
}

std::size_t entry_offset(std::size_t number) { return parse_ulog("a.ulg", sample())->entries.at(number).offset; }

TEST(UlogReader, ReadsWhatTheWriterWrote) {
  const auto log = parse_ulog("a.ulg", sample());
  ASSERT_TRUE(log) << log.error().message;
  EXPECT_FALSE(log->truncated);
  EXPECT_EQ(log->start, 1'000'000U);
  EXPECT_EQ(log->texts.at("swiftlet_settings"), R"({"a": 1})");
  EXPECT_EQ(log->numbers.at("swiftlet_map_crc32"), 42U);
  ASSERT_TRUE(log->find_topic("swiftlet_status"));
  EXPECT_EQ(log->topics.at(*log->find_topic("swiftlet_status")).size, sizeof(companion::topic::Status));
  std::size_t estimates = 0;
  std::size_t texts = 0;
  for (const UlogEntry& entry : log->entries) {
    if (entry.is_text) {
      ++texts;
      EXPECT_EQ(entry.time, 1'500'000U);
      EXPECT_TRUE(entry.text().starts_with("flying -> braking: ")) << entry.text();
    } else if (log->topics.at(entry.topic).name == "vehicle_local_position") {
      ++estimates;
    }
  }
  EXPECT_EQ(estimates, std::size_t{companion::kSampleSteps});
  EXPECT_EQ(texts, 1U);
}

TEST(FlightInputs, AreWhatEntered) {
  const auto steps = flight_inputs(*parse_ulog("a.ulg", sample()));
  ASSERT_TRUE(steps) << steps.error().message;
  ASSERT_EQ(steps->size(), std::size_t{companion::kSampleSteps});
  ASSERT_EQ(steps->front().before.size(), 1U);
  const auto& word = std::get<companion::Word>(steps->front().before.front());
  EXPECT_EQ(word.kind, companion::Word::Kind::kAddGoal);
  EXPECT_EQ(word.a, Vector3(1, 2, 3));
  EXPECT_EQ(word.yaw, Real(0.5));
  for (std::size_t i = 0; i < steps->size(); ++i) {
    const FlightStep& step = (*steps)[i];
    EXPECT_EQ(step.now, companion::kSampleStart + 10'000 * static_cast<TimeUs>(i));
    ASSERT_EQ(step.reads.size(), i == 0 ? 0U : i % 10 == 3 ? 2U : 1U);
    if (i > 0) {
      EXPECT_EQ(step.reads.back().size(), 3 * i);
      EXPECT_EQ(step.reads.back().front(), static_cast<std::byte>(i));
    }
    if (i % 10 == 3) {
      EXPECT_TRUE(step.reads.front().empty());
    }
    EXPECT_EQ(step.plans_done, i == 20 ? 1U : 0U);
    EXPECT_EQ(step.writes, 1U);
    EXPECT_EQ(step.short_writes.size(), i == 5 ? 1U : 0U);
  }
  EXPECT_EQ(steps->at(5).short_writes.at(0), 100U);
  EXPECT_EQ(steps->at(0).sent_crc, 3040120786U);  // zlib.crc32(bytes(300))
  EXPECT_EQ(std::get<MapChange>(steps->at(31).before.at(0)).crc32, 43U);
}

TEST(UlogReader, ACutLogIsGoodUpToThere) {
  std::size_t steps_before = 0;
  const std::size_t first = entry_offset(0);
  for (std::size_t size = first; size < sample().size(); size += 13) {
    const auto log = parse_ulog("a.ulg", {sample().begin(), sample().begin() + static_cast<std::ptrdiff_t>(size)});
    ASSERT_TRUE(log) << size << ": " << log.error().message;
    const auto steps = flight_inputs(*log);
    ASSERT_TRUE(steps) << size << ": " << steps.error().message;
    EXPECT_GE(steps->size(), steps_before);
    EXPECT_LT(steps->size(), std::size_t{companion::kSampleSteps});
    steps_before = steps->size();
  }
  EXPECT_GE(steps_before, std::size_t{companion::kSampleSteps} - 3);
}

TEST(UlogReader, RefusesWhatIsNoLogAndSaysWhy) {
  EXPECT_EQ(refusal({}), "a.ulg: is no flight log: it does not begin with 'ULog'");
  EXPECT_EQ(refusal({sample().begin(), sample().begin() + 12}), "a.ulg: ends within its header");
  EXPECT_EQ(refusal(sample_with(7, 2)), "a.ulg: is of a newer version of ULog than 1");
  EXPECT_NE(refusal(sample_with(19 + 8, 1)).find("appended data"), std::string::npos);
}

TEST(UlogReader, RefusesADamagedLogWithTheByte) {
  const std::size_t at = entry_offset(3);
  const std::string begin = "a.ulg: damaged at byte " + std::to_string(at) + ": ";
  const std::string end = "; nothing after it can be trusted";
  EXPECT_EQ(refusal(sample_with(at + 2, 'z')), begin + "a message of the unknown type 122" + end);
  EXPECT_EQ(refusal(sample_with(at + 4, 9)), begin + "data of topic 2307, which has not begun" + end);
  EXPECT_EQ(refusal(sample_with(at + 3, 7)), begin + "swiftlet_plan of 64 bytes, its format has 68" + end);
}

TEST(FlightInputs, RefusesALogOfSomebodyElseAndADamagedStream) {
  std::vector<std::byte> other = sample();
  other.resize(entry_offset(0));
  const std::string text(reinterpret_cast<const char*>(other.data()), other.size());
  for (std::size_t at = text.find("swiftlet_input"); at != std::string::npos;
       at = text.find("swiftlet_input", at + 1)) {
    other[at] = std::byte{'S'};
  }
  EXPECT_EQ(refusal(other), "a.ulg: holds no topic swiftlet_input: it was not written by a companion");

  const auto log = parse_ulog("a.ulg", sample());
  for (const UlogEntry& entry : log->entries) {
    if (!entry.is_text && entry.topic == companion::topic::Input::kId) {
      EXPECT_EQ(refusal(sample_with(entry.offset + 3 + 2 + 8, 99)),
                "a.ulg: damaged: no input begins at byte 0 of the stream of inputs");
      break;
    }
  }
}

}  // namespace
}  // namespace swiftlet::tools
