#include "no_heap/heap_guard.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <string_view>

namespace swiftlet::test {
namespace {

thread_local int guards_alive = 0;

void refuse_under_guard() {
  if (guards_alive == 0) return;
  guards_alive = 0;  // what follows may allocate
  constexpr std::string_view kMessage = "the heap was used under a HeapGuard\n";
  if (::write(STDERR_FILENO, kMessage.data(), kMessage.size()) < 0) std::_Exit(1);
  std::abort();
}

}  // namespace

HeapGuard::HeapGuard() { ++guards_alive; }
HeapGuard::~HeapGuard() { --guards_alive; }

#ifdef __SANITIZE_ADDRESS__

// The sanitizer's allocator cannot be replaced, but it tells.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*, std::size_t),
                                                         void (*free_hook)(const volatile void*));

[[maybe_unused]] const int kHooksInstalled =
    __sanitizer_install_malloc_and_free_hooks([](const volatile void*, std::size_t) { refuse_under_guard(); },
                                              [](const volatile void*) { refuse_under_guard(); });

}  // namespace swiftlet::test

#else

}  // namespace swiftlet::test

// Replaces the C library's allocator by itself with a check in front; operator new comes through malloc.
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): the C library's names
extern "C" {
void* __libc_malloc(std::size_t bytes);
void __libc_free(void* block);
void* __libc_calloc(std::size_t count, std::size_t bytes);
void* __libc_realloc(void* block, std::size_t bytes);
void* __libc_memalign(std::size_t alignment, std::size_t bytes);

void* malloc(std::size_t bytes) {
  swiftlet::test::refuse_under_guard();
  return __libc_malloc(bytes);
}
void free(void* block) {
  swiftlet::test::refuse_under_guard();
  __libc_free(block);
}
void* calloc(std::size_t count, std::size_t bytes) {
  swiftlet::test::refuse_under_guard();
  return __libc_calloc(count, bytes);
}
void* realloc(void* block, std::size_t bytes) {
  swiftlet::test::refuse_under_guard();
  return __libc_realloc(block, bytes);
}
void* memalign(std::size_t alignment, std::size_t bytes) {
  swiftlet::test::refuse_under_guard();
  return __libc_memalign(alignment, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) {
  swiftlet::test::refuse_under_guard();
  return __libc_memalign(alignment, bytes);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t bytes) {
  swiftlet::test::refuse_under_guard();
  *block = __libc_memalign(alignment, bytes);
  return *block == nullptr ? ENOMEM : 0;
}
}
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

#endif
