#include "semihosting.hpp"

#include <cstdint>

namespace swiftlet::board {
namespace {

constexpr std::uint32_t kGetCommandLine = 0x15;
constexpr std::uint32_t kExitExtended = 0x20;
constexpr std::uint32_t kApplicationExit = 0x20026;

std::uint32_t request(std::uint32_t operation, const void* argument) {
  register std::uint32_t r0 asm("r0") = operation;
  register const void* r1 asm("r1") = argument;
  asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

}  // namespace

void semihosting_exit(int code) {
  const std::uint32_t block[2] = {kApplicationExit, static_cast<std::uint32_t>(code)};
  request(kExitExtended, block);
  while (true) {
  }
}

bool semihosting_command_line(std::span<char> text) {
  const struct Block {
    char* buffer;
    std::uint32_t bytes;
  } block{text.data(), static_cast<std::uint32_t>(text.size())};
  return request(kGetCommandLine, &block) == 0;
}

}  // namespace swiftlet::board
