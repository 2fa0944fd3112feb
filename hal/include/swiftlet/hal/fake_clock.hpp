#pragma once
#include "swiftlet/hal/clock.hpp"

namespace swiftlet::hal {

/// A clock that stands still until it is told to move.
class FakeClock final : public Clock {
 public:
  std::chrono::microseconds now() override { return now_; }
  void advance(std::chrono::microseconds by) { now_ += by; }

 private:
  std::chrono::microseconds now_{0};
};

}  // namespace swiftlet::hal
