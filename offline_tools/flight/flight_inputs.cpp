#include "flight/flight_inputs.hpp"

#include <cstring>
#include <string>

#include "companion/flight_log.hpp"

namespace swiftlet::tools {
namespace {

using companion::InputKind;
using companion::Word;

/// Takes the stream apart. Reading past its end is remembered, not done.
class Decoder {
 public:
  Decoder(const Ulog& log, std::vector<std::byte> stream) : log_(log), stream_(std::move(stream)) {}

  Expected<std::vector<FlightStep>> run() {
    while (at_ < stream_.size()) {
      const std::size_t record = at_;
      const bool known = take(static_cast<InputKind>(get<std::uint8_t>()));
      if (short_) break;  // the log ends within a record: as good as if it ended before it
      if (!known) {
        return bad_file(log_.path + ": damaged: no input begins at byte " + std::to_string(record) +
                        " of the stream of inputs");
      }
      if (ended_) break;
    }
    return std::move(steps_);
  }

 private:
  template <typename Number>
  Number get() {
    Number number{};
    if (stream_.size() - at_ < sizeof(number)) {
      short_ = true;
      at_ = stream_.size();
      return number;
    }
    std::memcpy(&number, stream_.data() + at_, sizeof(number));
    at_ += sizeof(number);
    return number;
  }

  std::vector<std::byte> get_bytes(std::size_t count) {
    if (stream_.size() - at_ < count) {
      short_ = true;
      at_ = stream_.size();
      return {};
    }
    const auto first = stream_.begin() + static_cast<std::ptrdiff_t>(at_);
    at_ += count;
    return {first, first + static_cast<std::ptrdiff_t>(count)};
  }

  Vector3 get_vector() {
    const auto x = static_cast<Real>(get<double>());
    const auto y = static_cast<Real>(get<double>());
    return {x, y, static_cast<Real>(get<double>())};
  }

  /// False for an unknown kind, or one that belongs into a step, or not into one.
  bool take(InputKind kind) {
    switch (kind) {
      case InputKind::kEnd:
        ended_ = true;
        return true;
      case InputKind::kStep:
        if (in_step_) return false;
        in_step_ = true;
        step_.now = get<TimeUs>();
        return true;
      case InputKind::kWrite: {
        const auto number = get<std::uint16_t>();
        step_.short_writes[number] = get<std::uint16_t>();
        return true;
      }
      case InputKind::kWord:
        return !in_step_ && take_word();
      case InputKind::kMap:
        step_.before.emplace_back(MapChange{get<std::uint32_t>()});
        return !in_step_;
      default:
        return in_step_ && take_in_step(kind);
    }
  }

  bool take_in_step(InputKind kind) {
    switch (kind) {
      case InputKind::kRead:
        step_.reads.push_back(get_bytes(get<std::uint16_t>()));
        return true;
      case InputKind::kPlanDone:
        ++step_.plans_done;
        return true;
      case InputKind::kSent:
        step_.writes = get<std::uint16_t>();
        step_.sent_crc = get<std::uint32_t>();
        finish_step();
        return true;
      default:
        return false;
    }
  }

  bool take_word() {
    Word word;
    word.kind = static_cast<Word::Kind>(get<std::uint8_t>());
    word.id = get<std::uint32_t>();
    word.a = get_vector();
    word.b = get_vector();
    const bool has_yaw = get<std::uint8_t>() != 0;
    const auto yaw = static_cast<Real>(get<double>());
    if (has_yaw) word.yaw = yaw;
    step_.before.emplace_back(word);
    return word.kind <= Word::Kind::kLimits;
  }

  void finish_step() {
    if (!short_) steps_.push_back(std::move(step_));
    step_ = {};
    in_step_ = false;
  }

  const Ulog& log_;
  std::vector<std::byte> stream_;
  std::size_t at_ = 0;
  bool short_ = false;
  bool ended_ = false;
  bool in_step_ = false;
  FlightStep step_;
  std::vector<FlightStep> steps_;
};

}  // namespace

Expected<std::vector<FlightStep>> flight_inputs(const Ulog& log) {
  const auto topic = log.find_topic(companion::topic::kName<companion::topic::Input>);
  if (!topic) return bad_file(log.path + ": holds no topic swiftlet_input: it was not written by a companion");
  if (log.topics.at(*topic).size != sizeof(companion::topic::Input)) {
    return bad_file(log.path +
                    ": its topic swiftlet_input has another format; replay it with the version that wrote it");
  }
  std::vector<std::byte> stream;
  for (const UlogEntry& entry : log.entries) {
    if (entry.is_text || entry.topic != *topic) continue;
    constexpr std::size_t kTime = offsetof(companion::topic::Input, bytes);
    stream.insert(stream.end(), entry.bytes.begin() + kTime, entry.bytes.end());
  }
  return Decoder(log, std::move(stream)).run();
}

}  // namespace swiftlet::tools
