#pragma once
#include <cstdint>

#include "companion/journal.hpp"
#include "swiftlet/hal/console.hpp"

namespace swiftlet::companion {

/// Writes the notes of a journal on a console, each once and in order.
class NotePrinter {
 public:
  explicit NotePrinter(hal::Console& console) : console_(console) {}

  /// The next note, if there is one; false otherwise. One a call: a console lets its writer wait, for some milliseconds
  /// a line. What the journal no longer keeps is left out, and its number is told.
  bool print_next(const Journal& journal);

 private:
  hal::Console& console_;
  std::uint32_t printed_ = 0;
};

}  // namespace swiftlet::companion
