// Apart from posix_uart.cpp: the kernel's termios2, which knows every baud rate, and the C library's termios exclude
// each other.
#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>

#include "swiftlet/hal/posix_uart.hpp"

namespace swiftlet::hal {
namespace {

bool make_raw(int port, std::uint32_t baud) {
  termios2 settings{};
  if (::ioctl(port, TCGETS2, &settings) != 0) return false;
  settings.c_iflag = 0;
  settings.c_oflag = 0;
  settings.c_lflag = 0;
  settings.c_cflag = CS8 | CREAD | CLOCAL | BOTHER | (BOTHER << IBSHIFT);
  settings.c_ispeed = baud;
  settings.c_ospeed = baud;
  settings.c_cc[VMIN] = 1;  // no byte is EAGAIN, not an end of file
  settings.c_cc[VTIME] = 0;
  if (::ioctl(port, TCSETS2, &settings) != 0) return false;
  // A driver sets the nearest rate that it can do; 3 % is what a receiver tolerates.
  if (::ioctl(port, TCGETS2, &settings) != 0) return false;
  const std::uint32_t apart = settings.c_ospeed > baud ? settings.c_ospeed - baud : baud - settings.c_ospeed;
  if (apart > baud / 100 * 3) {
    errno = EINVAL;
    return false;
  }
  return true;
}

}  // namespace

bool SerialPort::open(const char* path, std::uint32_t baud) {
  const int port = ::open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (port < 0) return false;
  constexpr int kBothDirections = 2;  // TCIOFLUSH
  if (!make_raw(port, baud) || ::ioctl(port, TCFLSH, kBothDirections) != 0) {
    const int error = errno;
    ::close(port);
    errno = error;
    return false;
  }
  adopt(port);
  return true;
}

std::uint32_t SerialPort::overruns() const {
  serial_icounter_struct counts{};
  if (!is_open() || ::ioctl(descriptor(), TIOCGICOUNT, &counts) != 0) return 0;
  return static_cast<std::uint32_t>(counts.overrun) + static_cast<std::uint32_t>(counts.buf_overrun);
}

}  // namespace swiftlet::hal
