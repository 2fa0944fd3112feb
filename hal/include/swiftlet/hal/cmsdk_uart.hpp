#pragma once
#include <array>
#include <cstdint>

#include "swiftlet/hal/uart.hpp"

namespace swiftlet::hal {

/// An Arm CMSDK APB UART, driven by its receive and transmit interrupts. The device holds a single byte, so polling
/// would lose some.
class CmsdkUart final : public Uart {
 public:
  /// `base` is the address of the first register, `clock_hz` the peripheral clock. Enables both directions and their
  /// interrupts in the device; the board enables the two lines at the processor and calls the handlers below.
  CmsdkUart(std::uintptr_t base, std::uint32_t clock_hz, std::uint32_t baud);

  std::size_t write(std::span<const std::byte> bytes) override;
  std::size_t read(std::span<std::byte> into) override;
  /// Bytes that found the buffer full, plus the overruns that the device noticed (each at least one byte).
  [[nodiscard]] std::uint32_t overruns() const override { return overruns_; }

  void on_receive_interrupt();
  void on_transmit_interrupt();

 private:
  /// One writer and one reader, of which one is an interrupt: each index has a single writer.
  struct Ring {
    std::array<std::byte, 1024> bytes{};
    volatile std::uint32_t written = 0;
    volatile std::uint32_t read = 0;
    [[nodiscard]] bool empty() const { return written == read; }
    [[nodiscard]] bool full() const { return written - read == bytes.size(); }
    void push(std::byte byte);
    std::byte pop();
  };

  void start_transmission();

  volatile std::uint32_t* registers_;
  Ring received_;
  Ring sent_;
  volatile std::uint32_t overruns_ = 0;
};

}  // namespace swiftlet::hal
