// A socket as standard input, read and written; files of the working folder.
#include <unistd.h>

#include "lockstep.hpp"
#include "swiftlet/hal/file_storage.hpp"

namespace swiftlet::lockstep {
namespace {

class Socket final : public hal::Uart {
 public:
  std::size_t write(std::span<const std::byte> bytes) override {
    const ssize_t count = ::write(STDIN_FILENO, bytes.data(), bytes.size());
    return count < 0 ? 0 : static_cast<std::size_t>(count);
  }
  std::size_t read(std::span<std::byte> into) override {
    const ssize_t count = ::read(STDIN_FILENO, into.data(), into.size());
    return count < 0 ? 0 : static_cast<std::size_t>(count);
  }
  [[nodiscard]] std::uint32_t overruns() const override { return 0; }
};

}  // namespace

hal::Uart& line() {
  static Socket socket;
  return socket;
}

std::size_t wait_for_bytes(std::span<std::byte> into) { return line().read(into); }

hal::Storage& storage() {
  static hal::FileStorage files(".");
  return files;
}

bool hand_out(std::string_view /*name*/) { return true; }

}  // namespace swiftlet::lockstep
