#pragma once
#include <cstdint>

#include "swiftlet/hal/clock.hpp"

namespace swiftlet::hal {

/// An Arm CMSDK APB timer, counting freely. Call `now` or `ticks` at least once in 2^32 ticks (171 s at 25 MHz), and
/// never from an interrupt.
class CmsdkClock final : public Clock {
 public:
  /// `base` is the address of the first register; `clock_hz`, the timer's clock, is a multiple of 1 MHz. Starts it.
  CmsdkClock(std::uintptr_t base, std::uint32_t clock_hz);
  std::chrono::microseconds now() override;

  /// [tick] since the start
  std::uint64_t ticks();

 private:
  volatile std::uint32_t* registers_;
  std::uint32_t ticks_per_microsecond_;
  std::uint32_t latest_ = 0;
  std::uint64_t ticks_ = 0;
};

}  // namespace swiftlet::hal
