#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "swiftlet/hal/console.hpp"

/// What every board offers to the programs that run on it.
namespace swiftlet::board {

/// The board's console.
hal::Console& console();

/// The memory that holds the map blob, 8-byte aligned; it may reach past the blob's end. A Linux board maps the file
/// `path` and returns nothing when it cannot; a bare board ignores `path` and returns its map region.
std::span<const std::byte> map_region(const char* path);

/// The most stack that was ever in use [byte]; 0 on a board that cannot tell.
std::size_t stack_bytes_used();

/// Instructions executed since an arbitrary start; 0 on a board that cannot tell.
std::uint64_t instructions_executed();

}  // namespace swiftlet::board
