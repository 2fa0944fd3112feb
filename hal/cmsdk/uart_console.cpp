#include "swiftlet/hal/uart_console.hpp"

namespace swiftlet::hal {
namespace {

// Word offsets and bits: Arm DDI 0479, table 4-2.
constexpr std::size_t kData = 0;
constexpr std::size_t kState = 1;
constexpr std::size_t kControl = 2;
constexpr std::size_t kBaudDivider = 4;
constexpr std::uint32_t kTransmitBufferFull = 1;
constexpr std::uint32_t kTransmitEnable = 1;
constexpr std::uint32_t kLeastBaudDivider = 16;

}  // namespace

UartConsole::UartConsole(std::uintptr_t base) : registers_(reinterpret_cast<volatile std::uint32_t*>(base)) {
  registers_[kBaudDivider] = kLeastBaudDivider;
  registers_[kControl] = kTransmitEnable;
}

void UartConsole::write(std::span<const char> text) {
  for (const char c : text) {
    while ((registers_[kState] & kTransmitBufferFull) != 0) {
    }
    registers_[kData] = static_cast<unsigned char>(c);
  }
}

}  // namespace swiftlet::hal
