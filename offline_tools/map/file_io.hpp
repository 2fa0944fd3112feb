#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "map/error.hpp"

namespace swiftlet::tools {

/// The whole file, at an address aligned for a map blob.
Expected<std::vector<std::byte>> read_file(const std::string& path);

/// The same file from every folder.
std::string absolute_path(const std::string& path);

/// Writes beside `path` and renames, so that nobody ever sees half a file and a failure leaves the old one alone. What
/// is no regular file (/dev/stdout, a pipe) is written directly.
Expected<void> write_file_atomically(const std::string& path, std::span<const std::byte> bytes);

}  // namespace swiftlet::tools
