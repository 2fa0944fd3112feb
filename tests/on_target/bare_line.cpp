// The emulated UART.
#include "devices.hpp"
#include "lockstep.hpp"

namespace swiftlet::lockstep {

hal::Uart& line() { return board::autopilot_uart(); }

/// An interrupt between look and sleep would be slept through, so interrupts wait; they end the sleep all the same.
std::size_t wait_for_bytes(std::span<std::byte> into) {
  std::size_t count = 0;
  while (count == 0 && !into.empty()) {
    asm volatile("cpsid i" ::: "memory");
    count = line().read(into);
    if (count == 0) asm volatile("wfi" ::: "memory");
    asm volatile("cpsie i" ::: "memory");
  }
  return count;
}

}  // namespace swiftlet::lockstep
