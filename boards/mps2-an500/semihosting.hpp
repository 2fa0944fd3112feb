#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

/// Requests to the debugger or emulator that runs the board (Arm "Semihosting for AArch32 and AArch64").
namespace swiftlet::board {

/// Ends the emulation; `code` becomes the emulator's exit status.
[[noreturn]] void semihosting_exit(int code);

/// The words of the emulator's command line, zero-terminated and separated by single spaces; false when they do not
/// fit.
bool semihosting_command_line(std::span<char> text);

/// A new file of the machine that runs the emulator, or one written over.
class SemihostingFile {
 public:
  explicit SemihostingFile(std::string_view path);  ///< of less than 128 characters
  ~SemihostingFile();
  SemihostingFile(const SemihostingFile&) = delete;
  SemihostingFile& operator=(const SemihostingFile&) = delete;

  bool write(std::span<const std::byte> bytes);

 private:
  std::uint32_t file_;
};

}  // namespace swiftlet::board
