#include "bare/flight.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "board.hpp"
#include "board_config.hpp"
#include "companion/flight_log.hpp"
#include "companion/text.hpp"
#include "map_blob.hpp"
#include "swiftlet/version.hpp"

namespace swiftlet::board {
namespace {

PlannerStorage<kBoard> planner_memory;
companion::CompanionStorage<kBoard> companion_memory;
std::optional<companion::FlightLog> flight_log;
std::array<char, 16> log_name{"flight_0000.ulg"};

/// flight_settings() as a swiftlet-config/1 text, in `text`: if it were not, the log would not replay.
std::string_view settings_text(std::span<char> text) {
  constexpr std::string_view kHead =
      R"({"format":"swiftlet-config/1","start_m":[0.48,0.48,0],"start_yaw_rad":0.4,)"
      R"("margins":{"vehicle_radius_m":0.1,"map_error_m":0.03},"takeoff":{"height_m":0.8},)"
      R"("supervisor":{"storage_needed":false},"planning":{"deadline":)";
  constexpr std::string_view kTail = "}}";
  char* end = std::copy(kHead.begin(), kHead.end(), text.data());
  end = std::to_chars(end, text.data() + text.size(), flight_settings().planning.budget.deadline).ptr;
  end = std::copy(kTail.begin(), kTail.end(), end);
  return {text.data(), static_cast<std::size_t>(end - text.data())};
}

/// The next of flight_0001.ulg to flight_9999.ulg.
void count_up(std::span<char> name) {
  for (char* digit = name.data() + 10; digit >= name.data() + 7; --digit) {
    if (++*digit <= '9') return;
    *digit = '0';
  }
}

void begin_log(hal::Storage& logs, std::uint32_t map_crc32) {
  do count_up(log_name);
  while (logs.read(log_name.data(), 0, {}).has_value());
  std::array<char, 320> text{};
  flight_log.emplace(logs);
  (void)flight_log->begin(log_name.data(), 0, {kVersion, "boards/bare", settings_text(text), map_crc32});
}

}  // namespace

/// A small vehicle in the classroom (tests/on_target/companion_peer.cpp). A plan holds up the set-points, so its
/// trajectory gets half the worst-case latency; search and step have the rest.
companion::Settings flight_settings() {
  companion::Settings settings;
  settings.start = {Real(0.48), Real(0.48), 0};
  settings.start_yaw = Real(0.4);
  settings.margins.vehicle_radius = Real(0.1);
  settings.margins.map_error = Real(0.03);
  settings.takeoff.height = Real(0.8);
  const double units = static_cast<double>(settings.planning.latency) / 2 * kWorkPerMicrosecond;
  settings.planning.budget.deadline = static_cast<std::uint64_t>(units);
  settings.supervisor.storage_needed = false;  // memory is soon full
  return settings;
}

companion::Companion* begin_flight(hal::Uart& autopilot, hal::Storage& logs, const char* map_path) {
  const Result<BoxGraphView> map = BoxGraphView::open(trim_to_blob(map_region(map_path)));
  if (!map.ok()) {
    console().write((companion::Line("no map at the map region: ") << describe(map.status()) << "\n").view());
    return nullptr;
  }
  begin_log(logs, map->header().crc32);
  static companion::InlineWorker worker(planner_memory.spans());
  static companion::Companion companion(flight_settings(), *map, companion_memory.memory(),
                                        {autopilot, worker, &*flight_log});
  return &companion;
}

std::string_view end_log() {
  if (flight_log) flight_log->end();
  return log_name.data();
}

}  // namespace swiftlet::board
