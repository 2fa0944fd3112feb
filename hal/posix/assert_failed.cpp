#include <cstdio>
#include <cstdlib>

#include "swiftlet/assert.hpp"

extern "C" [[noreturn]] void swiftlet_assert_failed(const char* what, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: broken promise: %s\n", file, line, what);
  std::abort();
}
