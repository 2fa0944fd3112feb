#include "companion/note_printer.hpp"

namespace swiftlet::companion {

bool NotePrinter::print_next(const Journal& journal) {
  const std::uint32_t waiting = journal.count() - printed_;
  if (waiting == 0) return false;
  if (waiting > Journal::kNotes) {
    console_.write((Line("... ") << waiting - Journal::kNotes << " notes left out\n").view());
    printed_ = journal.count() - Journal::kNotes;
  }
  const Note& note = journal.note(printed_++);
  const bool warns = note.severity <= mavlink::Severity::kWarning;
  console_.write((Line() << static_cast<Real>(note.time) / kSecondUs << (warns ? " ! " : " ")).view());
  console_.write(note.view());
  console_.write({"\n", 1});
  return true;
}

}  // namespace swiftlet::companion
