#pragma once
#include <string>

#include "swiftlet/hal/uart.hpp"

namespace swiftlet::hal {

/// A Uart over a file descriptor of a POSIX system. `open` of a derived class makes it usable; until then, and after
/// the device has gone (unplugged, other end closed), it takes and gives nothing.
class PosixUart : public Uart {
 public:
  PosixUart() = default;
  PosixUart(const PosixUart&) = delete;
  PosixUart& operator=(const PosixUart&) = delete;

  std::size_t write(std::span<const std::byte> bytes) override;
  std::size_t read(std::span<std::byte> into) override;
  [[nodiscard]] std::uint32_t overruns() const override;

  [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }
  /// For poll(2).
  [[nodiscard]] int descriptor() const { return descriptor_; }
  void close();

 protected:
  ~PosixUart() { close(); }
  /// Takes over an open descriptor and makes it non-blocking.
  void adopt(int descriptor);

 private:
  int descriptor_ = -1;
};

/// A serial port, or the end of a pseudo-terminal that looks like one: raw, 8 data bits, no parity, one stop bit.
class SerialPort final : public PosixUart {
 public:
  /// `baud` is any rate that the device can do, 921600 for one. Discards what was waiting in either direction. False
  /// with errno set when it cannot be done; errno is EINVAL for a rate that the device refuses.
  bool open(const char* path, std::uint32_t baud);
  /// Framing errors and overruns are counted by some drivers.
  [[nodiscard]] std::uint32_t overruns() const override;
};

/// The controlling end of a new pseudo-terminal: a serial cable to whoever opens `peer_path`.
class PseudoTerminal final : public PosixUart {
 public:
  bool open();
  ~PseudoTerminal();
  /// Path of the other end, say /dev/pts/3.
  [[nodiscard]] const std::string& peer_path() const { return peer_path_; }

 private:
  std::string peer_path_;
  int peer_ = -1;  // held open, so that reading does not fail before a peer comes and after it leaves
};

/// UDP as autopilot simulators speak it: a datagram holds what one `write` gave.
class UdpUart final : public PosixUart {
 public:
  /// Listens on `local_port` (0: any) of all interfaces. Sends to `host`:`port`, where `host` is a dotted address; with
  /// port 0 to whoever sent the latest datagram, and nowhere before there was one.
  bool open(std::uint16_t local_port, const char* host, std::uint16_t port);
  std::size_t write(std::span<const std::byte> bytes) override;
  std::size_t read(std::span<std::byte> into) override;
  [[nodiscard]] std::uint16_t local_port() const;

 private:
  std::uint32_t remote_address_ = 0;  // network byte order
  std::uint16_t remote_port_ = 0;     // network byte order; 0: none yet
  bool follows_sender_ = false;
  std::byte datagram_[2048] = {};
  std::size_t datagram_size_ = 0;
  std::size_t datagram_read_ = 0;
};

}  // namespace swiftlet::hal
