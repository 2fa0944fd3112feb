#include "swiftlet/hal/monotonic_clock.hpp"

#include <ctime>

namespace swiftlet::hal {

std::chrono::microseconds MonotonicClock::now() {
  timespec time{};
  ::clock_gettime(CLOCK_MONOTONIC, &time);
  return std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::seconds(time.tv_sec) +
                                                               std::chrono::nanoseconds(time.tv_nsec));
}

}  // namespace swiftlet::hal
