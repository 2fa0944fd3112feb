// The flight log's writer against its reader: whatever is written, and wherever the storage ends, is read back; and the
// reader on bytes of anybody.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "companion/flight_log.hpp"
#include "flight/flight_inputs.hpp"
#include "flight/memory_storage.hpp"
#include "flight/ulog_reader.hpp"

namespace {

using namespace swiftlet;             // NOLINT(google-build-using-namespace): every name below is from there
using namespace swiftlet::companion;  // NOLINT(google-build-using-namespace)

void require(bool promise) {
  if (!promise) std::abort();
}

/// The input, piece by piece; zeros beyond its end.
class Source {
 public:
  explicit Source(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  [[nodiscard]] bool empty() const { return bytes_.empty(); }
  template <typename Number>
  Number get() {
    Number number{};
    const std::size_t count = std::min(sizeof(number), bytes_.size());
    if (count > 0) std::memcpy(&number, bytes_.data(), count);
    bytes_ = bytes_.subspan(count);
    return number;
  }
  std::size_t below(std::size_t most) { return get<std::uint8_t>() % most; }
  Vector3 vector() {
    const Real x = get<Real>();
    const Real y = get<Real>();
    return {x, y, get<Real>()};
  }
  /// Up to 255 bytes, repeated `times`.
  std::vector<std::byte> bytes(std::size_t times = 1) {
    const std::size_t wanted = get<std::uint8_t>();
    const std::size_t count = std::min(wanted, bytes_.size());
    const auto piece = std::as_bytes(bytes_.first(count));
    bytes_ = bytes_.subspan(count);
    std::vector<std::byte> all;
    for (std::size_t i = 0; i < times; ++i) all.insert(all.end(), piece.begin(), piece.end());
    return all;
  }

  /// Now and then more than any text may have.
  std::vector<std::byte> long_bytes() { return bytes(below(32) == 31 ? 256 : 1); }

 private:
  std::span<const std::uint8_t> bytes_;
};

/// Has room for so many bytes and no more; may take a part of what does not fit, as a disk does.
class SmallStorage final : public hal::Storage {
 public:
  SmallStorage(std::size_t room, bool takes_parts) : room_(room), takes_parts_(takes_parts) {}

  std::optional<std::size_t> read(std::string_view name, std::size_t offset, std::span<std::byte> into) override {
    return memory_.read(name, offset, into);
  }
  bool append(std::string_view name, std::span<const std::byte> bytes) override {
    require(!refused_);  // a log that is full keeps nothing more
    refused_ = bytes.size() > room_;
    const std::size_t taken = !refused_ ? bytes.size() : takes_parts_ ? room_ : 0;
    room_ -= taken;
    return memory_.append(name, bytes.first(taken)) && !refused_;
  }
  bool remove(std::string_view name) override { return memory_.remove(name); }

  [[nodiscard]] bool refused() const { return refused_; }
  [[nodiscard]] const std::vector<std::byte>& bytes() const { return memory_.bytes(); }

 private:
  tools::MemoryStorage memory_;
  std::size_t room_;
  bool takes_parts_;
  bool refused_ = false;
};

SmallStorage make_storage(Source& source) {
  const auto room = source.get<std::uint16_t>();
  return {room < 0x8000 ? room : SIZE_MAX, source.below(2) == 1};
}

/// What was stored is a log, but for one that ends within its first bytes.
std::optional<tools::Ulog> read_back(const SmallStorage& storage) {
  auto log = tools::parse_ulog("f", storage.bytes());
  constexpr std::size_t kHeader = 16;
  if (storage.bytes().size() < kHeader) {
    require(!log && storage.refused());
    return std::nullopt;
  }
  require(log.has_value());
  require(!log->truncated || storage.refused());
  return std::move(*log);
}

// ---- Any message

struct Told {
  bool is_text;
  std::vector<std::byte> bytes;
};

void write_messages(Source& source) {
  SmallStorage storage = make_storage(source);
  const auto writer = std::make_unique<UlogWriter>(storage);
  const std::size_t size = source.below(200);
  const std::string format = "t:uint64_t timestamp;uint8_t[" + std::to_string(size) + "] bytes;";
  (void)writer->begin("f.ulg", source.get<TimeUs>());
  const std::vector<std::byte> value = source.long_bytes();
  const std::string key = "key" + std::string(source.below(100), 'k');
  writer->format(format);
  writer->info(key, std::string_view(reinterpret_cast<const char*>(value.data()), value.size()));
  writer->info("number", source.get<std::uint32_t>());
  writer->parameter(key, source.get<float>());
  writer->subscribe(7, "t");
  std::vector<Told> told;
  while (!source.empty()) {
    const std::size_t kind = source.below(8);
    if (kind == 0) {
      writer->flush();
    } else if (kind == 1) {
      std::vector<std::byte> text = source.long_bytes();
      writer->text(source.get<TimeUs>(), source.get<std::uint8_t>(),
                   {reinterpret_cast<const char*>(text.data()), text.size()});
      constexpr std::size_t kLongest = 60'000;
      text.resize(std::min(text.size(), kLongest));
      told.push_back({true, std::move(text)});
    } else {
      std::vector<std::byte> bytes = source.bytes();
      bytes.resize(8 + size);
      writer->data(7, bytes);
      told.push_back({false, std::move(bytes)});
    }
  }
  writer->flush();
  require(writer->full() == storage.refused());
  const auto log = read_back(storage);
  if (!log) return;
  require(log->entries.size() <= told.size());
  require(storage.refused() || log->entries.size() == told.size());
  for (std::size_t i = 0; i < log->entries.size(); ++i) {
    const tools::UlogEntry& entry = log->entries[i];
    require(entry.is_text == told[i].is_text);
    require(std::equal(entry.bytes.begin(), entry.bytes.end(), told[i].bytes.begin(), told[i].bytes.end()));
  }
}

// ---- A flight

Telemetry make_telemetry(Source& source, TimeUs now) {
  static const std::array<Segment, 4> segments{};
  static const std::array<Box, 4> boxes{};
  Telemetry telemetry;
  telemetry.time = now;
  telemetry.state = static_cast<FlightState>(source.below(7));
  telemetry.reason = static_cast<Reason>(source.below(24));
  telemetry.phase = static_cast<Phase>(source.below(5));
  telemetry.has_estimate = source.below(2) == 1;
  telemetry.estimate.time = source.get<TimeUs>() % kSecondUs;
  telemetry.estimate.position = source.vector();
  telemetry.has_reference = source.below(2) == 1;
  telemetry.reference.sample.position = source.vector();
  telemetry.sent = source.below(2) == 1;
  telemetry.form = static_cast<SetpointForm>(source.below(3));
  telemetry.plan.id = static_cast<std::uint32_t>(source.below(4));
  telemetry.plan.segments = std::span(segments).first(source.below(5));
  telemetry.plan.boxes = boxes;
  telemetry.plan.latency = source.get<TimeUs>();
  return telemetry;
}

Word make_word(Source& source) {
  Word word;
  word.kind = static_cast<Word::Kind>(source.below(9));
  word.id = source.get<std::uint32_t>();
  word.a = source.vector();
  if (source.below(2) == 1) word.yaw = source.get<Real>();
  return word;
}

/// What may enter in a step.
void enter(Source& source, FlightLog& log, tools::FlightStep& step) {
  switch (source.below(4)) {
    case 0:
      step.reads.push_back(source.bytes(1 + source.below(9)));
      log.note_read(step.reads.back());
      return;
    case 1: {
      const std::vector<std::byte> offered = source.bytes();
      const std::size_t taken = std::min(source.below(256), offered.size());
      if (taken != offered.size()) step.short_writes[step.writes] = taken;
      ++step.writes;
      log.note_write(offered, taken);
      return;
    }
    case 2:
      ++step.plans_done;
      log.note_plan_done();
      return;
    default:
      return;
  }
}

void tell(Source& source, FlightLog& log, TimeUs now) {
  if (source.below(2) == 0) {
    return log.write(FlightEvent{now, static_cast<FlightState>(source.below(7)),
                                 static_cast<FlightState>(source.below(7)), static_cast<Reason>(source.below(24))});
  }
  Note note;
  note.time = now;
  const std::vector<std::byte> text = source.bytes();
  std::transform(text.begin(), text.begin() + std::min(std::ssize(text), std::ssize(note.text)), note.text.begin(),
                 [](std::byte b) { return static_cast<char>(b); });
  log.write(note);
}

void compare(const tools::FlightStep& was, const tools::FlightStep& is) {
  auto reads = was.reads;
  while (!reads.empty() && reads.back().empty()) reads.pop_back();  // left out: a device gives nothing anyway
  require(was.now == is.now && was.before.size() == is.before.size() && reads == is.reads);
  require(was.short_writes == is.short_writes && was.plans_done == is.plans_done && was.writes == is.writes);
}

void write_flight(Source& source) {
  SmallStorage storage = make_storage(source);
  const auto log = std::make_unique<FlightLog>(storage);
  const std::vector<std::byte> settings = source.long_bytes();
  (void)log->begin("f.ulg", source.get<TimeUs>(),
                   {"1", "test", {reinterpret_cast<const char*>(settings.data()), settings.size()}, 1});
  std::vector<tools::FlightStep> steps;
  while (!source.empty()) {
    tools::FlightStep& step = steps.emplace_back();
    for (std::size_t n = source.below(3); n > 0; --n) {
      const Word word = make_word(source);
      log->note_word(word);
      step.before.emplace_back(word);
    }
    step.now = TimeUs{source.get<std::uint32_t>()} * 1000;
    log->begin_step(step.now);
    for (std::size_t n = source.below(6); n > 0; --n) enter(source, *log, step);
    for (std::size_t n = source.below(3); n > 0; --n) tell(source, *log, step.now);
    log->end_step(make_telemetry(source, step.now));
  }
  log->end();
  require(log->full() == storage.refused());
  const auto ulog = read_back(storage);
  if (!ulog) return;
  const auto read = tools::flight_inputs(*ulog);
  if (!read) {  // the log ended before its topics began
    require(storage.refused() && ulog->entries.empty());
    return;
  }
  require(read->size() <= steps.size());
  require(storage.refused() || read->size() == steps.size());
  for (std::size_t i = 0; i < read->size(); ++i) compare(steps[i], (*read)[i]);
}

// ---- Bytes of anybody

void read_bytes(std::vector<std::byte> bytes) {
  const auto log = tools::parse_ulog("f", std::move(bytes));
  if (!log) return;
  for (const tools::UlogEntry& entry : log->entries) {
    require(entry.offset + entry.bytes.size() <= log->bytes.size());
    require(entry.is_text || log->topics.contains(entry.topic));
  }
  (void)tools::flight_inputs(*log);
}

/// A log of one topic, swiftlet_input, with the given stream: what the checks of the format would keep a fuzzer from.
void read_stream(Source& source) {
  tools::MemoryStorage storage;
  const auto writer = std::make_unique<UlogWriter>(storage);
  (void)writer->begin("f.ulg", 0);
  writer->format(topic::Input::kFormat);
  writer->subscribe(3, topic::kName<topic::Input>);
  while (!source.empty()) {
    const auto piece = source.get<topic::Input>();
    writer->data(3, std::as_bytes(std::span(&piece, 1)));
  }
  writer->flush();
  read_bytes(storage.bytes());
}

}  // namespace

/// The first byte says what the rest is.
// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer calls it so
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto rest = std::span(data, size).subspan(1);
  Source source(rest);
  switch (data[0] % 4) {
    case 0: {
      const auto bytes = std::as_bytes(rest);
      read_bytes({bytes.begin(), bytes.end()});
      break;
    }
    case 1:
      read_stream(source);
      break;
    case 2:
      write_messages(source);
      break;
    default:
      write_flight(source);
  }
  return 0;
}
