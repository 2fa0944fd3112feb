// The board's logs across a reset: the first start writes one and resets the processor, the second must find it.
#include <array>
#include <cstdint>
#include <string_view>

#include "devices.hpp"

namespace {

constexpr const char* kLog = "before";
constexpr std::string_view kText = "written before the reset";

[[noreturn]] void reset() {
  auto* const interrupt_and_reset_control = reinterpret_cast<volatile std::uint32_t*>(0xE000ED0C);
  asm volatile("dsb" ::: "memory");
  *interrupt_and_reset_control = 0x05FA0004;  // the key, and SYSRESETREQ
  while (true) {
  }
}

}  // namespace

int main(int /*argc*/, char** /*argv*/) {
  swiftlet::hal::Storage& logs = swiftlet::board::log_storage();
  std::array<std::byte, 64> found{};
  const auto count = logs.read(kLog, 0, found);
  if (!count) {
    if (!logs.append(kLog, std::as_bytes(std::span(kText)))) return 1;
    reset();
  }
  return std::string_view(reinterpret_cast<const char*>(found.data()), *count) == kText ? 0 : 2;
}
