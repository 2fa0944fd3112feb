// The flight application as an image: the map lies in the map region, the autopilot is on UART 1, goals and the words
// to fly and to land come over the link (docs/flight.md).
#include <chrono>

#include "bare/flight.hpp"
#include "board.hpp"
#include "companion/note_printer.hpp"
#include "devices.hpp"

namespace {

using std::chrono::microseconds;

constexpr microseconds kPeriod{10'000};
constexpr microseconds kGiveUp{50'000};  // a step that late starts a new rhythm instead of being caught up with

}  // namespace

int main(int /*argc*/, char** /*argv*/) {
  swiftlet::companion::Companion* const companion =
      swiftlet::board::begin_flight(swiftlet::board::autopilot_uart(), swiftlet::board::log_storage());
  if (companion == nullptr) return 3;
  swiftlet::hal::Clock& clock = swiftlet::board::clock();
  swiftlet::companion::NotePrinter printer(swiftlet::board::console());
  microseconds next = clock.now();
  while (true) {
    while (clock.now() < next) {
    }
    companion->step(clock.now());
    (void)printer.print_next(companion->journal());
    next += kPeriod;
    if (clock.now() - next > kGiveUp) next = clock.now();
  }
}
