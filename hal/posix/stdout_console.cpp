#include "swiftlet/hal/stdout_console.hpp"

#include <unistd.h>

namespace swiftlet::hal {

void StdoutConsole::write(std::span<const char> text) {
  while (!text.empty()) {
    const ssize_t written = ::write(STDOUT_FILENO, text.data(), text.size());
    if (written <= 0) return;  // a closed pipe: nobody is listening
    text = text.subspan(static_cast<std::size_t>(written));
  }
}

}  // namespace swiftlet::hal
