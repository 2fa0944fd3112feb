#pragma once
#include "swiftlet/hal/console.hpp"

namespace swiftlet::hal {

/// Standard output of a POSIX process.
class StdoutConsole final : public Console {
 public:
  void write(std::span<const char> text) override;
};

}  // namespace swiftlet::hal
