#pragma once

/// Supplied by hal/posix or by the board: reports the broken promise and stops. `what` is the text of the condition.
extern "C" [[noreturn]] void swiftlet_assert_failed(const char* what, const char* file, int line);

/// States what our own code promises, in every build. Outside data is checked and refused instead.
#define SWIFTLET_ASSERT(condition) \
  (static_cast<bool>(condition) ? static_cast<void>(0) : swiftlet_assert_failed(#condition, __FILE__, __LINE__))
