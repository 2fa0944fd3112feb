#include "board.hpp"

#include <cstdint>
#include <cstring>

#include "board_config.hpp"
#include "devices.hpp"
#include "semihosting.hpp"
#include "swiftlet/assert.hpp"
#include "swiftlet/hal/cmsdk_clock.hpp"
#include "swiftlet/hal/cmsdk_uart.hpp"
#include "swiftlet/hal/region_storage.hpp"
#include "swiftlet/hal/uart_console.hpp"

extern "C" const std::byte map_region_begin[];  // linker.ld
extern "C" const std::byte map_region_end[];
extern "C" std::byte log_region_begin[];
extern "C" std::byte log_region_end[];

namespace swiftlet::board {
namespace {

constexpr std::uintptr_t kTimer0 = 0x40000000;
constexpr std::uintptr_t kUart0 = 0x40004000;
constexpr std::uintptr_t kUart1 = 0x40005000;
constexpr std::uint32_t kPeripheralHz = 25'000'000;
constexpr std::uint32_t kInstructionsPerTick = 1'000'000'000 / kPeripheralHz;  // one a nanosecond: toolchain.cmake
constexpr std::uint32_t kUart1Lines = 0b1100;                                  // interrupt 2 receives, 3 transmits

hal::CmsdkUart& uart1() {
  static hal::CmsdkUart uart(kUart1, kPeripheralHz, 921'600);
  return uart;
}

hal::CmsdkClock& timer0() {
  static hal::CmsdkClock timer(kTimer0, kPeripheralHz);
  return timer;
}

static_assert(sizeof(PlannerStorage<kBoard>) <= kBoardMemory.planner_bytes);

}  // namespace

hal::Console& console() {
  static hal::UartConsole uart(kUart0);
  return uart;
}

std::span<const std::byte> map_region(const char* /*path*/) {
  const std::span<const std::byte> region{map_region_begin, map_region_end};
  SWIFTLET_ASSERT(region.size() == kBoardMemory.map_bytes);  // the linker script and the board's promise agree
  return region;
}

hal::Clock& clock() { return timer0(); }

std::uint64_t instructions_executed() { return timer0().ticks() * kInstructionsPerTick; }

hal::Uart& autopilot_uart() {
  hal::CmsdkUart& uart = uart1();
  auto* const enable_interrupts = reinterpret_cast<volatile std::uint32_t*>(0xE000E100);  // NVIC_ISER0
  *enable_interrupts = kUart1Lines;
  return uart;
}

hal::Storage& log_storage() {
  static hal::RegionStorage storage({log_region_begin, log_region_end});
  return storage;
}

}  // namespace swiftlet::board

extern "C" void uart1_receive_handler() { swiftlet::board::uart1().on_receive_interrupt(); }
extern "C" void uart1_transmit_handler() { swiftlet::board::uart1().on_transmit_interrupt(); }

extern "C" [[noreturn]] void swiftlet_assert_failed(const char* what, const char* file, int /*line*/) {
  for (const char* text : {file, ": broken promise: ", what, "\n"}) {
    swiftlet::board::console().write({text, std::strlen(text)});
  }
  swiftlet::board::semihosting_exit(255);
}
