#pragma once
#include <array>
#include <cstdint>

#include "companion/telemetry.hpp"
#include "companion/text.hpp"
#include "swiftlet/flight_time.hpp"
#include "swiftlet/mavlink/link.hpp"

namespace swiftlet::companion {

/// What the companion has to say to people: kept for the console and the log, and sent as STATUSTEXT.
class Journal {
 public:
  static constexpr std::uint32_t kNotes = 32;

  explicit Journal(mavlink::Link& link) : link_(link) {}

  void set_time(TimeUs now) { now_ = now; }
  void info(const Line& line) { add(mavlink::Severity::kInfo, line); }
  void warn(const Line& line) { add(mavlink::Severity::kWarning, line); }
  /// What others said is kept but not sent back.
  void heard(mavlink::Severity severity, const Line& line) { keep(severity, line); }

  [[nodiscard]] std::uint32_t count() const { return count_; }
  [[nodiscard]] const Note& note(std::uint32_t n) const { return notes_[n % kNotes]; }

 private:
  void add(mavlink::Severity severity, const Line& line);
  void keep(mavlink::Severity severity, const Line& line);

  mavlink::Link& link_;
  TimeUs now_ = 0;
  std::uint32_t count_ = 0;
  std::array<Note, kNotes> notes_;
};

}  // namespace swiftlet::companion
