#pragma once
#include <cstdint>

#include "swiftlet/hal/console.hpp"

namespace swiftlet::hal {

/// Polled output on an Arm CMSDK APB UART.
class UartConsole final : public Console {
 public:
  /// `base` is the address of the UART's first register. Enables the transmitter.
  explicit UartConsole(std::uintptr_t base);
  void write(std::span<const char> text) override;

 private:
  volatile std::uint32_t* registers_;
};

}  // namespace swiftlet::hal
