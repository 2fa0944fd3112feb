#include "board.hpp"

#include <cstdint>
#include <cstring>

#include "semihosting.hpp"
#include "swiftlet/assert.hpp"
#include "swiftlet/hal/uart_console.hpp"

extern "C" const std::byte map_region_begin[];  // linker.ld
extern "C" const std::byte map_region_end[];

namespace swiftlet::board {
namespace {

constexpr std::uintptr_t kUart0 = 0x40004000;

}  // namespace

hal::Console& console() {
  static hal::UartConsole uart(kUart0);
  return uart;
}

std::span<const std::byte> map_region(const char* /*path*/) { return {map_region_begin, map_region_end}; }

}  // namespace swiftlet::board

extern "C" [[noreturn]] void swiftlet_assert_failed(const char* what, const char* file, int /*line*/) {
  for (const char* text : {file, ": broken promise: ", what, "\n"}) {
    swiftlet::board::console().write({text, std::strlen(text)});
  }
  swiftlet::board::semihosting_exit(255);
}
