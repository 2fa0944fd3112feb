#include "companion/journal.hpp"

#include <algorithm>

namespace swiftlet::companion {

void Journal::add(mavlink::Severity severity, const Line& line) {
  keep(severity, line);
  (void)link_.send_text(severity, line.view());  // a full device loses it: the console and the log have it
}

void Journal::keep(mavlink::Severity severity, const Line& line) {
  Note& note = notes_[count_++ % kNotes];
  note = {now_, severity, {}};
  std::copy(line.view().begin(), line.view().end(), note.text.begin());
}

}  // namespace swiftlet::companion
