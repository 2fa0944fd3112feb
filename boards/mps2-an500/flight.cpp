#include "flight.hpp"

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

companion::Companion* begin_flight(const companion::Settings& settings, hal::Uart& autopilot) {
  const Result<BoxGraphView> map = BoxGraphView::open(trim_to_blob(map_region("")));
  if (!map.ok()) {
    print((companion::Line("no map at the map region: ") << describe(map.status())).view());
    return nullptr;
  }
  static companion::InlineWorker worker(planner_memory.spans());
  static companion::Companion companion(settings, *map, companion_memory.memory(), {autopilot, worker});
  return &companion;
}

void print_notes(const companion::Companion& companion) {
  static std::uint32_t printed = 0;
  const std::uint32_t count = companion.note_count();
  printed = std::max(printed, count - std::min(count, companion::Companion::kNotes));
  for (; printed != count; ++printed) print(companion.note(printed));
}

}  // namespace swiftlet::board
