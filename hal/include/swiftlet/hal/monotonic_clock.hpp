#pragma once
#include "swiftlet/hal/clock.hpp"

namespace swiftlet::hal {

/// CLOCK_MONOTONIC: time of day may be set without it noticing.
class MonotonicClock final : public Clock {
 public:
  std::chrono::microseconds now() override;
};

}  // namespace swiftlet::hal
