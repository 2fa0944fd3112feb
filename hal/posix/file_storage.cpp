#include "swiftlet/hal/file_storage.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace swiftlet::hal {

FileStorage::FileStorage(std::string folder) : folder_(std::move(folder)) {}

FileStorage::~FileStorage() { close_appended(); }

std::optional<std::size_t> FileStorage::read(std::string_view name, std::size_t offset, std::span<std::byte> into) {
  if (!is_storage_name(name)) return std::nullopt;
  const int file = ::open(path_of(name).c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  std::size_t count = 0;
  while (count < into.size()) {
    const ssize_t got = ::pread(file, into.data() + count, into.size() - count, static_cast<off_t>(offset + count));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    count += static_cast<std::size_t>(got);
  }
  ::close(file);
  return count;
}

bool FileStorage::append(std::string_view name, std::span<const std::byte> bytes) {
  if (!is_storage_name(name)) return false;
  if (appended_name_ != name || appended_ < 0) {
    close_appended();
    appended_ = ::open(path_of(name).c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    if (appended_ < 0) return false;
    appended_name_ = name;
  }
  while (!bytes.empty()) {
    const ssize_t written = ::write(appended_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

bool FileStorage::remove(std::string_view name) {
  if (!is_storage_name(name)) return false;
  if (appended_name_ == name) close_appended();
  return ::unlink(path_of(name).c_str()) == 0 || errno == ENOENT;
}

std::string FileStorage::path_of(std::string_view name) const { return folder_ + "/" + std::string(name); }

void FileStorage::close_appended() {
  if (appended_ >= 0) ::close(appended_);
  appended_ = -1;
}

}  // namespace swiftlet::hal
