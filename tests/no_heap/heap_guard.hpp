#pragma once

namespace swiftlet::test {

/// While one lives, any allocation or release on this thread aborts the program with a message.
class HeapGuard {
 public:
  HeapGuard();
  ~HeapGuard();
  HeapGuard(const HeapGuard&) = delete;
  HeapGuard& operator=(const HeapGuard&) = delete;
};

}  // namespace swiftlet::test
