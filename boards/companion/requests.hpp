#pragma once
#include "companion/journal.hpp"
#include "swiftlet/flight_time.hpp"
#include "swiftlet/mavlink/link.hpp"

namespace swiftlet::companion {

/// Asks the autopilot for a mode or to arm: one request at a time, and again a while after a refusal.
class Requests {
 public:
  Requests(mavlink::Link& link, Journal& journal) : link_(link), journal_(journal) {}

  /// Once a step: how the last request ended.
  void step(TimeUs now);
  /// Nothing is wanted any more: what was not answered is not repeated.
  void cancel();
  void shift_clock(TimeUs jump) { next_at_ += jump; }

  // May be called every step as long as it is wanted.
  void ask_for_mode(mavlink::Mode mode, TimeUs now);
  void ask_to_arm(TimeUs now);
  /// ArduPilot's own climb; `height` [m] above the ground.
  void ask_to_take_off(Real height, TimeUs now);

 private:
  [[nodiscard]] bool may_ask(TimeUs now) const { return !waiting_ && now >= next_at_; }
  void asked(bool taken, TimeUs now);

  mavlink::Link& link_;
  Journal& journal_;
  bool waiting_ = false;
  TimeUs next_at_ = 0;
};

}  // namespace swiftlet::companion
