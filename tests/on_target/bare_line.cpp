// The emulated UART and the board's memory.
#include <array>

#include "devices.hpp"
#include "lockstep.hpp"
#include "semihosting.hpp"

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

hal::Storage& storage() { return board::log_storage(); }

bool hand_out(std::string_view name) {
  board::SemihostingFile file(name);
  static std::array<std::byte, 65536> buffer;
  for (std::size_t at = 0;;) {
    const std::size_t count = storage().read(name, at, buffer).value_or(0);
    if (count == 0) return at > 0;
    if (!file.write(std::span(buffer).first(count))) return false;
    at += count;
  }
}

}  // namespace swiftlet::lockstep
