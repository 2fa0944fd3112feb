#include "board.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "board_config.hpp"
#include "swiftlet/hal/stdout_console.hpp"

namespace swiftlet::board {

static_assert(sizeof(PlannerStorage<kBoard>) <= kBoardMemory.planner_bytes);

hal::Console& console() {
  static hal::StdoutConsole stdout_console;
  return stdout_console;
}

std::span<const std::byte> map_region(const char* path) {
  const int file = ::open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) return {};
  std::span<const std::byte> region;
  struct stat info {};
  if (::fstat(file, &info) == 0 && info.st_size > 0) {
    const auto bytes = static_cast<std::size_t>(info.st_size);
    void* const begin = ::mmap(nullptr, bytes, PROT_READ, MAP_PRIVATE, file, 0);
    if (begin != MAP_FAILED) region = {static_cast<const std::byte*>(begin), bytes};
  }
  ::close(file);  // the mapping outlives it
  return region;
}

std::size_t stack_bytes_used() { return 0; }

std::uint64_t instructions_executed() { return 0; }

}  // namespace swiftlet::board
