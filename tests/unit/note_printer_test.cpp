#include "companion/note_printer.hpp"

#include "swiftlet/hal/fake_clock.hpp"
#include "swiftlet/hal/fake_console.hpp"
#include "swiftlet/hal/fake_line.hpp"
#include "swiftlet_test.hpp"

namespace {

using namespace std::chrono_literals;
using swiftlet::companion::Journal;
using swiftlet::companion::Line;
using swiftlet::companion::NotePrinter;
using swiftlet::hal::FakeClock;
using swiftlet::hal::FakeConsole;

/// A journal on a line that nobody listens to.
struct Told {
  FakeClock clock;
  FakeConsole console{clock};
  NotePrinter printer{console};
  swiftlet::hal::FakeLine line{clock, 1};
  swiftlet::mavlink::Link link{line.end_a(), {}};
  Journal journal{link};
};

TEST(NotePrinter, WritesEachNoteOnceWithItsTime) {
  static Told told;
  EXPECT_FALSE(told.printer.print_next(told.journal));
  told.journal.set_time(1'500'000);
  told.journal.info("ready");
  told.journal.warn("refused");
  EXPECT_TRUE(told.printer.print_next(told.journal));
  EXPECT_TRUE(told.console.text() == "1.50 ready\n");
  EXPECT_TRUE(told.printer.print_next(told.journal));
  EXPECT_FALSE(told.printer.print_next(told.journal));
  EXPECT_TRUE(told.console.text() == "1.50 ready\n1.50 ! refused\n");
}

TEST(NotePrinter, WaitsForASlowConsoleOneLineAtATime) {
  static Told told;
  for (int i = 0; i < 10; ++i) told.journal.info("123456789 123456789 123456789 123456789 123456789 ");
  told.console.faults().byte_time = 87us;  // 115,200 baud
  const auto begin = told.clock.now();
  EXPECT_TRUE(told.printer.print_next(told.journal));
  const auto of_one = told.clock.now() - begin;
  EXPECT_TRUE(of_one > 4ms);
  EXPECT_TRUE(of_one < 6ms);
  told.console.faults() = {.stalled_until = told.clock.now() + 50ms};
  EXPECT_TRUE(told.printer.print_next(told.journal));
  EXPECT_TRUE(told.clock.now() - begin - of_one == 50ms);
}

TEST(NotePrinter, AFullConsoleHoldsNothingUp) {
  static Told told;
  told.console.faults().full = true;
  told.journal.info("lost");
  EXPECT_TRUE(told.printer.print_next(told.journal));
  told.console.faults().full = false;
  EXPECT_FALSE(told.printer.print_next(told.journal));
  EXPECT_EQ(told.console.lost(), std::string_view("0.00 lost\n").size());
  told.journal.info("kept");
  EXPECT_TRUE(told.printer.print_next(told.journal));
  EXPECT_TRUE(told.console.text() == "0.00 kept\n");
}

TEST(NotePrinter, TellsHowManyNotesItWasTooLateFor) {
  static Told told;
  for (std::uint32_t i = 0; i < Journal::kNotes + 3; ++i) told.journal.info(Line("note ") << i);
  EXPECT_TRUE(told.printer.print_next(told.journal));
  EXPECT_TRUE(told.console.text() == "... 3 notes left out\n0.00 note 3\n");
  for (std::uint32_t i = 1; i < Journal::kNotes; ++i) EXPECT_TRUE(told.printer.print_next(told.journal));
  EXPECT_FALSE(told.printer.print_next(told.journal));
}

}  // namespace
