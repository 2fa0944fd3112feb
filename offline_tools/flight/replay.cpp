#include "flight/replay.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "flight/memory_storage.hpp"
#include "flight/renamed_map.hpp"

namespace swiftlet::tools {
namespace {

using companion::Word;

/// The device of the recorded flight: gives what it gave, takes what it took.
class RecordedDevice final : public hal::Uart {
 public:
  void begin(const FlightStep& step) {
    step_ = &step;
    reads_ = 0;
    writes_ = 0;
  }
  std::size_t write(std::span<const std::byte> bytes) override {
    const std::uint32_t number = writes_++;
    if (step_ == nullptr) return bytes.size();
    const auto cut = step_->short_writes.find(number);
    return cut == step_->short_writes.end() ? bytes.size() : std::min(cut->second, bytes.size());
  }
  std::size_t read(std::span<std::byte> into) override {
    if (step_ == nullptr || reads_ == step_->reads.size()) return 0;
    const std::vector<std::byte>& given = step_->reads[reads_++];
    const std::size_t count = std::min(given.size(), into.size());
    std::copy_n(given.begin(), count, into.begin());
    return count;
  }
  [[nodiscard]] std::uint32_t overruns() const override { return 0; }

 private:
  const FlightStep* step_ = nullptr;
  std::size_t reads_ = 0;
  std::uint32_t writes_ = 0;
};

/// Plans at once, and is done when the recorded one was.
class RecordedWorker final : public companion::PlanWorker {
 public:
  explicit RecordedWorker(const PlannerSpans& spans) : planner_(spans) {}

  void begin(const FlightStep& step) { left_ = step.plans_done; }
  void start(const companion::PlanJob& job) override { (void)planner_.plan(job.map, job.request); }
  bool done() override {
    if (left_ == 0) return false;
    --left_;
    return true;
  }
  [[nodiscard]] const Plan& result() const override { return planner_.result(); }

 private:
  Planner planner_;
  std::uint32_t left_ = 0;
};

std::string crc_text(std::uint32_t crc) {
  std::array<char, 9> text{};
  std::snprintf(text.data(), text.size(), "%08x", crc);
  return text.data();
}

std::string map_key(std::uint32_t crc) { return std::string(companion::kMapFileKey) + crc_text(crc); }

std::uint32_t number_of(const Ulog& log, const std::string& name) {
  const auto found = log.numbers.find(name);
  return found == log.numbers.end() ? 0 : found->second;
}

std::string text_of(const Ulog& log, const std::string& name) {
  const auto found = log.texts.find(name);
  return found == log.texts.end() ? std::string() : found->second;
}

/// The maps of a flight by their CRC-32: those given, and the first as a simulated flight replaces it.
class Maps {
 public:
  explicit Maps(std::span<const BoxGraphView> given) : given_(given), renamed_(given.front()) {}

  [[nodiscard]] const BoxGraphView* find(std::uint32_t crc) const {
    for (const BoxGraphView& map : given_) {
      if (map.header().crc32 == crc) return &map;
    }
    return renamed_.view().header().crc32 == crc ? &renamed_.view() : nullptr;
  }

 private:
  std::span<const BoxGraphView> given_;
  RenamedMap renamed_;
};

/// Why the log cannot be replayed with this program and these maps.
std::optional<Error> find_obstacle(const Ulog& log, const std::vector<FlightStep>& steps, const Maps& maps,
                                   const BoxGraphView& first) {
  const auto refuse = [&log](const std::string& why) { return Error{kExitBadFile, log.path + ": " + why}; };
  if (const std::uint32_t bytes = number_of(log, "swiftlet_real_bytes"); bytes != sizeof(Real)) {
    return refuse("was computed with numbers of " + std::to_string(bytes) + " bytes, this program's have " +
                  std::to_string(sizeof(Real)));
  }
  if (number_of(log, "swiftlet_signed") != 0) {
    return refuse("its messages were signed, and a log does not hold the key: it can be read but not replayed");
  }
  if (const std::uint32_t crc = number_of(log, "swiftlet_map_crc32"); crc != first.header().crc32) {
    return refuse("was flown in the map with the CRC-32 " + crc_text(crc) + ", not " + crc_text(first.header().crc32));
  }
  for (const FlightStep& step : steps) {
    for (const auto& event : step.before) {
      const MapChange* change = std::get_if<MapChange>(&event);
      if (change == nullptr || maps.find(change->crc32) != nullptr) continue;
      return refuse("was given the map with the CRC-32 " + crc_text(change->crc32) +
                    " under way: name it with a further --map");
    }
  }
  return std::nullopt;
}

/// The log that the companion writes when it is given `steps`.
std::vector<std::byte> fly_again(const Ulog& log, const std::vector<FlightStep>& steps, const Maps& maps,
                                 const ReplayWorld& world) {
  MemoryStorage storage;
  companion::FlightLog copy(storage);
  const std::string version = text_of(log, "ver_sw");
  const std::string board = text_of(log, "ver_hw");
  (void)copy.begin("replay.ulg", static_cast<TimeUs>(log.start), {version, board, {}, world.maps[0].header().crc32});
  RecordedDevice device;
  RecordedWorker worker(world.planner);
  if (!steps.empty()) device.begin(steps.front());
  const auto companion = std::make_unique<companion::Companion>(world.settings, world.maps[0], world.memory,
                                                                companion::Devices{device, worker, &copy});
  for (const FlightStep& step : steps) {
    if (&step != &steps.front()) device.begin(step);
    worker.begin(step);
    for (const auto& event : step.before) {
      if (const Word* word = std::get_if<Word>(&event)) (void)companion->tell(*word);
      if (const MapChange* change = std::get_if<MapChange>(&event)) {
        (void)companion->replace_map(*maps.find(change->crc32));
      }
    }
    companion->step(std::chrono::microseconds(step.now));
  }
  copy.end();
  return storage.bytes();
}

// ---- Comparison

/// What is told: everything but the stream of inputs, which is compared step by step.
std::vector<const UlogEntry*> told(const Ulog& log) {
  std::vector<const UlogEntry*> entries;
  for (const UlogEntry& entry : log.entries) {
    if (entry.is_text || entry.topic != companion::topic::Input::kId) entries.push_back(&entry);
  }
  return entries;
}

TimeUs time_of(const UlogEntry& entry) {
  std::uint64_t time = entry.time;
  if (!entry.is_text && entry.bytes.size() >= sizeof(time)) std::memcpy(&time, entry.bytes.data(), sizeof(time));
  return static_cast<TimeUs>(time);
}

std::string name_of(const Ulog& log, const UlogEntry& entry) {
  return entry.is_text ? "the text '" + std::string(entry.text()) + "'" : log.topics.at(entry.topic).name;
}

bool same(const UlogEntry& a, const UlogEntry& b) {
  return a.is_text == b.is_text && a.topic == b.topic && a.severity == b.severity && a.time == b.time &&
         std::equal(a.bytes.begin(), a.bytes.end(), b.bytes.begin(), b.bytes.end());
}

std::string describe_difference(const Ulog& log, const UlogEntry& recorded, const Ulog& copy,
                                const UlogEntry& replayed) {
  const std::string was = name_of(log, recorded);
  const std::string is = name_of(copy, replayed);
  return was == is ? was + " has other values" : is + " in the place of " + was;
}

std::optional<ReplayDifference> compare_steps(const std::vector<FlightStep>& recorded,
                                              const std::vector<FlightStep>& replayed) {
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    const FlightStep& was = recorded[i];
    const std::string where = "step " + std::to_string(i) + ": ";
    if (i >= replayed.size()) return ReplayDifference{was.now, where + "it is not made"};
    const FlightStep& is = replayed[i];
    if (was.reads != is.reads) return ReplayDifference{was.now, where + "other bytes are read"};
    if (was.plans_done != is.plans_done) return ReplayDifference{was.now, where + "another number of plans ends"};
    if (was.writes != is.writes || was.sent_crc != is.sent_crc) {
      return ReplayDifference{was.now, where + "other bytes are sent"};
    }
  }
  return std::nullopt;
}

/// Entry by entry, up to the end of the shorter one: a log may end before its last step does.
void compare_told(const Ulog& log, const Ulog& copy, ReplayReport& report) {
  const std::vector<const UlogEntry*> was = told(log);
  const std::vector<const UlogEntry*> is = told(copy);
  for (std::size_t i = 0; i < std::min(was.size(), is.size()); ++i) {
    if (!same(*was[i], *is[i])) {
      report.difference = {time_of(*was[i]), describe_difference(log, *was[i], copy, *is[i])};
      return;
    }
    ++report.messages;
    report.plans += !was[i]->is_text && was[i]->topic == companion::topic::Plan::kId ? 1 : 0;
  }
  if (is.size() > was.size()) {
    const UlogEntry& first = *is[was.size()];
    report.difference = {time_of(first), name_of(copy, first) + " is told beyond the log"};
  }
}

}  // namespace

Expected<std::vector<NamedMap>> named_maps(const Ulog& log) {
  const std::uint32_t first = number_of(log, "swiftlet_map_crc32");
  std::vector<NamedMap> maps{{first, text_of(log, map_key(first))}};
  if (maps[0].file.empty()) {
    return bad_file(log.path + ": does not say where the map with the CRC-32 " + crc_text(first) +
                    " is: name it with --map");
  }
  for (const auto& [key, file] : log.texts) {
    if (!key.starts_with(companion::kMapFileKey) || key == map_key(first)) continue;
    const auto crc = std::strtoul(key.c_str() + companion::kMapFileKey.size(), nullptr, 16);
    maps.push_back({static_cast<std::uint32_t>(crc), file});
  }
  return maps;
}

Expected<ReplayReport> replay(const Ulog& log, const ReplayWorld& world) {
  const auto steps = flight_inputs(log);
  if (!steps) return tl::unexpected(steps.error());
  const Maps maps(world.maps);
  if (auto error = find_obstacle(log, *steps, maps, world.maps[0])) return tl::unexpected(std::move(*error));
  const auto copy = parse_ulog("replay of " + log.path, fly_again(log, *steps, maps, world));
  if (!copy) return tl::unexpected(copy.error());
  const auto steps_again = flight_inputs(*copy);
  if (!steps_again) return tl::unexpected(steps_again.error());

  ReplayReport report;
  report.steps = steps->size();
  compare_told(log, *copy, report);
  const std::optional<ReplayDifference> in_steps = compare_steps(*steps, *steps_again);
  if (in_steps && (!report.difference || in_steps->time <= report.difference->time)) report.difference = in_steps;
  return report;
}

}  // namespace swiftlet::tools
