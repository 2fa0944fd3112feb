#include "map/file_io.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>

namespace swiftlet::tools {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

std::string reason() { return std::strerror(errno); }

Expected<void> write_file(const std::string& path, std::span<const std::byte> bytes) {
  File file(std::fopen(path.c_str(), "wb"));
  if (!file) return bad_file(path + ": cannot be written: " + reason());
  const bool written = bytes.empty() || std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size();
  if (!written || std::fflush(file.get()) != 0) return bad_file(path + ": cannot be written: " + reason());
  if (std::fclose(file.release()) != 0) return bad_file(path + ": cannot be written: " + reason());
  return {};
}

}  // namespace

Expected<std::vector<std::byte>> read_file(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return bad_file(path + ": is a folder, not a file");
  const File file(std::fopen(path.c_str(), "rb"));
  if (!file) return bad_file(path + ": cannot be read: " + reason());
  std::vector<std::byte> bytes;
  constexpr std::size_t kChunk = std::size_t{1} << 20;
  std::size_t size = 0;
  for (;;) {
    bytes.resize(size + kChunk);
    const std::size_t count = std::fread(bytes.data() + size, 1, kChunk, file.get());
    size += count;
    if (count < kChunk) break;
  }
  if (std::ferror(file.get()) != 0) return bad_file(path + ": cannot be read: " + reason());
  bytes.resize(size);
  return bytes;
}

std::string absolute_path(const std::string& path) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::absolute(path, error);
  return error ? path : whole.string();
}

Expected<void> write_file_atomically(const std::string& path, std::span<const std::byte> bytes) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::is_directory(status)) return bad_file(path + ": cannot be written: it is a folder");
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) return write_file(path, bytes);

  const std::string beside = path + ".partial-" + std::to_string(::getpid());
  const Expected<void> written = write_file(beside, bytes);
  if (!written) {
    std::filesystem::remove(beside, error);
    // Name the file that was asked for, not the one beside it.
    return bad_file(path + written.error().message.substr(beside.size()));
  }
  std::filesystem::rename(beside, path, error);
  if (error) {
    const std::string why = error.message();
    std::filesystem::remove(beside, error);
    return bad_file(path + ": cannot be written: " + why);
  }
  return {};
}

}  // namespace swiftlet::tools
