#include "semihosting.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace swiftlet::board {
namespace {

constexpr std::uint32_t kOpen = 0x01;
constexpr std::uint32_t kClose = 0x02;
constexpr std::uint32_t kWrite = 0x05;
constexpr std::uint32_t kGetCommandLine = 0x15;
constexpr std::uint32_t kExitExtended = 0x20;
constexpr std::uint32_t kApplicationExit = 0x20026;
constexpr std::uint32_t kWriteBinary = 5;  // fopen's "wb"
constexpr std::uint32_t kNoFile = 0xFFFFFFFF;

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

SemihostingFile::SemihostingFile(std::string_view path) : file_(kNoFile) {
  std::array<char, 128> text{};
  if (path.size() >= text.size()) return;
  std::copy(path.begin(), path.end(), text.begin());
  const struct {
    const char* path;
    std::uint32_t mode;
    std::uint32_t path_bytes;
  } block{text.data(), kWriteBinary, static_cast<std::uint32_t>(path.size())};
  file_ = request(kOpen, &block);
}

SemihostingFile::~SemihostingFile() {
  if (file_ != kNoFile) request(kClose, &file_);
}

bool SemihostingFile::write(std::span<const std::byte> bytes) {
  if (file_ == kNoFile) return false;
  const struct {
    std::uint32_t file;
    const std::byte* bytes;
    std::uint32_t count;
  } block{file_, bytes.data(), static_cast<std::uint32_t>(bytes.size())};
  return request(kWrite, &block) == 0;  // bytes that were not written
}

}  // namespace swiftlet::board
