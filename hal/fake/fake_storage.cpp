#include "swiftlet/hal/fake_storage.hpp"

#include <algorithm>

namespace swiftlet::hal {

std::optional<std::size_t> FakeStorage::read(std::string_view name, std::size_t offset, std::span<std::byte> into) {
  const File* const file = is_storage_name(name) ? find(name) : nullptr;
  if (file == nullptr) return std::nullopt;
  const std::size_t from = std::min(offset, file->size);
  const std::size_t count = std::min(into.size(), file->size - from);
  std::copy_n(file->bytes.data() + from, count, into.data());
  return count;
}

bool FakeStorage::append(std::string_view name, std::span<const std::byte> bytes) {
  if (!is_storage_name(name)) return false;
  File* file = find(name);
  if (file == nullptr) {
    file = find({});
    if (file == nullptr) return false;
    std::copy(name.begin(), name.end(), file->name.begin());
  }
  const std::size_t count = std::min({bytes.size(), kFileBytes - file->size, free_bytes_});
  std::copy_n(bytes.data(), count, file->bytes.data() + file->size);
  file->size += count;
  free_bytes_ -= count;
  return count == bytes.size();
}

bool FakeStorage::remove(std::string_view name) {
  if (!is_storage_name(name)) return false;
  if (File* const file = find(name); file != nullptr) {
    free_bytes_ += file->size;
    file->name = {};
    file->size = 0;
  }
  return true;
}

FakeStorage::File* FakeStorage::find(std::string_view name) {
  for (File& file : files_) {
    if (std::string_view(file.name.data()) == name) return &file;
  }
  return nullptr;
}

}  // namespace swiftlet::hal
