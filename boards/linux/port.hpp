#pragma once
#include <chrono>
#include <cstdint>
#include <string>

#include "swiftlet/hal/posix_uart.hpp"

namespace swiftlet::board {

/// "DEVICE", "DEVICE:BAUD", "udp:PORT" or "udp:PORT:HOST:PORT".
struct PortName {
  std::string device;  ///< empty: UDP
  std::uint32_t baud = 921'600;
  std::uint16_t local_port = 0;
  std::string host = "127.0.0.1";
  std::uint16_t remote_port = 0;  ///< 0: whoever sends
};

/// A device's last piece is its baud rate when it has digits only: /dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0 has
/// none. Throws tools::Failure.
PortName parse_port(const std::string& text);

/// The line to the autopilot. A device that has gone, an adapter that was pulled out for one, is opened again when it
/// is back: the flight, and what it knows of its frames, lives on.
class Port final : public hal::Uart {
 public:
  enum class Change : std::uint8_t { kNone, kGone, kBack };

  /// Throws tools::Failure when it cannot be opened.
  explicit Port(const PortName& name);

  std::size_t write(std::span<const std::byte> bytes) override { return uart_.write(bytes); }
  std::size_t read(std::span<std::byte> into) override { return uart_.read(into); }
  [[nodiscard]] std::uint32_t overruns() const override { return uart_.overruns(); }

  /// Asked once a step; tries to open a device that has gone once a second.
  Change keep(std::chrono::microseconds now);

 private:
  PortName name_;
  hal::SerialPort serial_;
  hal::UdpUart udp_;
  hal::PosixUart& uart_;
  bool gone_ = false;
  std::chrono::microseconds next_try_{0};
};

}  // namespace swiftlet::board
