#include "swiftlet/hal/posix_uart.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace swiftlet::hal {
namespace {

bool is_temporary(int error) { return error == EAGAIN || error == EWOULDBLOCK || error == EINTR; }

}  // namespace

std::size_t PosixUart::write(std::span<const std::byte> bytes) {
  if (!is_open() || bytes.empty()) return 0;
  const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
  if (count < 0 && !is_temporary(errno)) close();
  return count > 0 ? static_cast<std::size_t>(count) : 0;
}

std::size_t PosixUart::read(std::span<std::byte> into) {
  if (!is_open() || into.empty()) return 0;
  const ssize_t count = ::read(descriptor_, into.data(), into.size());
  // A raw terminal without bytes says EAGAIN; end of file is a hang-up.
  if (count == 0 || (count < 0 && !is_temporary(errno))) close();
  return count > 0 ? static_cast<std::size_t>(count) : 0;
}

std::uint32_t PosixUart::overruns() const { return 0; }

void PosixUart::close() {
  if (is_open()) ::close(descriptor_);
  descriptor_ = -1;
}

void PosixUart::adopt(int descriptor) {
  close();
  descriptor_ = descriptor;
  ::fcntl(descriptor_, F_SETFL, ::fcntl(descriptor_, F_GETFL) | O_NONBLOCK);
}

bool PseudoTerminal::open() {
  const int controller = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (controller < 0) return false;
  std::array<char, 64> name{};
  const bool usable = ::grantpt(controller) == 0 && ::unlockpt(controller) == 0 &&
                      ::ptsname_r(controller, name.data(), name.size()) == 0;
  if (usable) peer_ = ::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (!usable || peer_ < 0) {
    ::close(controller);
    return false;
  }
  peer_path_ = name.data();
  adopt(controller);
  return true;
}

PseudoTerminal::~PseudoTerminal() {
  if (peer_ >= 0) ::close(peer_);
}

bool UdpUart::open(std::uint16_t local_port, const char* host, std::uint16_t port) {
  in_addr remote{};
  if (port != 0 && ::inet_pton(AF_INET, host, &remote) != 1) {
    errno = EINVAL;
    return false;
  }
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket < 0) return false;
  sockaddr_in local{};
  local.sin_family = AF_INET;
  local.sin_port = htons(local_port);
  local.sin_addr.s_addr = htonl(INADDR_ANY);
  if (::bind(socket, reinterpret_cast<const sockaddr*>(&local), sizeof local) != 0) {
    const int error = errno;
    ::close(socket);
    errno = error;
    return false;
  }
  remote_address_ = remote.s_addr;
  remote_port_ = htons(port);
  follows_sender_ = port == 0;
  adopt(socket);
  return true;
}

std::size_t UdpUart::write(std::span<const std::byte> bytes) {
  if (!is_open() || remote_port_ == 0) return 0;
  sockaddr_in remote{};
  remote.sin_family = AF_INET;
  remote.sin_port = remote_port_;
  remote.sin_addr.s_addr = remote_address_;
  const ssize_t count =
      ::sendto(descriptor(), bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&remote), sizeof remote);
  return count > 0 ? static_cast<std::size_t>(count) : 0;  // nobody there is no reason to close
}

std::size_t UdpUart::read(std::span<std::byte> into) {
  if (!is_open()) return 0;
  if (datagram_read_ == datagram_size_) {
    sockaddr_in sender{};
    socklen_t sender_bytes = sizeof sender;
    const ssize_t count =
        ::recvfrom(descriptor(), datagram_, sizeof datagram_, 0, reinterpret_cast<sockaddr*>(&sender), &sender_bytes);
    if (count <= 0) return 0;
    datagram_size_ = static_cast<std::size_t>(count);
    datagram_read_ = 0;
    if (follows_sender_) {
      remote_address_ = sender.sin_addr.s_addr;
      remote_port_ = sender.sin_port;
    }
  }
  const std::size_t count = std::min(into.size(), datagram_size_ - datagram_read_);
  std::memcpy(into.data(), datagram_ + datagram_read_, count);
  datagram_read_ += count;
  return count;
}

std::uint16_t UdpUart::local_port() const {
  sockaddr_in local{};
  socklen_t bytes = sizeof local;
  if (!is_open() || ::getsockname(descriptor(), reinterpret_cast<sockaddr*>(&local), &bytes) != 0) return 0;
  return ntohs(local.sin_port);
}

}  // namespace swiftlet::hal
