// Echoes what the autopilot's UART receives, every byte plus one, until a zero byte; exits with 0 when nothing was lost
// and the clock went on.
#include <array>

#include "devices.hpp"

int main(int /*argc*/, char** /*argv*/) {
  swiftlet::hal::Uart& uart = swiftlet::board::autopilot_uart();
  swiftlet::hal::Clock& clock = swiftlet::board::clock();
  const std::chrono::microseconds begin = clock.now();
  std::array<std::byte, 64> bytes{};
  for (bool ended = false; !ended;) {
    const std::size_t count = uart.read(bytes);
    for (std::size_t i = 0; i < count; ++i) {
      ended = ended || bytes[i] == std::byte{0};
      bytes[i] = static_cast<std::byte>(static_cast<unsigned>(bytes[i]) + 1);
    }
    for (std::size_t sent = 0; sent < count;) sent += uart.write(std::span(bytes).subspan(sent, count - sent));
  }
  const std::chrono::microseconds flush_until = clock.now() + std::chrono::milliseconds(50);
  while (clock.now() < flush_until) {
  }
  return uart.overruns() == 0 && clock.now() > begin ? 0 : 1;
}
