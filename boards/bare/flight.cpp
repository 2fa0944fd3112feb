#include "bare/flight.hpp"

#include <algorithm>
#include <string_view>

#include "board.hpp"
#include "board_config.hpp"
#include "companion/text.hpp"
#include "map_blob.hpp"

namespace swiftlet::board {
namespace {

PlannerStorage<kBoard> planner_memory;
companion::CompanionStorage<kBoard> companion_memory;

void print(std::string_view line) {
  console().write(line);
  console().write({"\n", 1});
}

void print(const companion::Note& note) {
  const bool warns = note.severity <= mavlink::Severity::kWarning;
  companion::Line time;
  time << static_cast<Real>(note.time) / kSecondUs << (warns ? " ! " : " ");
  console().write(time.view());
  print(note.view());
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
  return settings;
}

companion::Companion* begin_flight(hal::Uart& autopilot, const char* map_path) {
  const Result<BoxGraphView> map = BoxGraphView::open(trim_to_blob(map_region(map_path)));
  if (!map.ok()) {
    print((companion::Line("no map at the map region: ") << describe(map.status())).view());
    return nullptr;
  }
  static companion::InlineWorker worker(planner_memory.spans());
  static companion::Companion companion(flight_settings(), *map, companion_memory.memory(), {autopilot, worker});
  return &companion;
}

void print_notes(const companion::Companion& companion) {
  static std::uint32_t printed = 0;
  const std::uint32_t count = companion.note_count();
  printed = std::max(printed, count - std::min(count, companion::Companion::kNotes));
  for (; printed != count; ++printed) print(companion.note(printed));
}

}  // namespace swiftlet::board
