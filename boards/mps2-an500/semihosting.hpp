#pragma once
#include <span>

/// Requests to the debugger or emulator that runs the board (Arm "Semihosting for AArch32 and AArch64").
namespace swiftlet::board {

/// Ends the emulation; `code` becomes the emulator's exit status.
[[noreturn]] void semihosting_exit(int code);

/// The words of the emulator's command line, zero-terminated and separated by single spaces; false when they do not
/// fit.
bool semihosting_command_line(std::span<char> text);

}  // namespace swiftlet::board
