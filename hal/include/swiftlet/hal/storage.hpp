#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

namespace swiftlet::hal {

/// Named byte sequences that outlive the program: configuration, keys, logs. Names are of letters, digits, '.', '-' and
/// '_', do not start with '.', and have at most 63 characters.
class Storage {
 public:
  /// Copies bytes from `offset` on to the front of `into`; how many, 0 past the end, nothing when there is no `name`.
  virtual std::optional<std::size_t> read(std::string_view name, std::size_t offset, std::span<std::byte> into) = 0;

  /// Adds to the end of `name`, which comes into being when absent. False when the storage is full or broken: then
  /// some of `bytes` may have been stored.
  virtual bool append(std::string_view name, std::span<const std::byte> bytes) = 0;

  /// Forgets `name`; true when it is gone.
  virtual bool remove(std::string_view name) = 0;

 protected:
  ~Storage() = default;  // protected and non-virtual: a public virtual one links operator delete
};

/// Whether `name` keeps to the rules above.
inline bool is_storage_name(std::string_view name) {
  if (name.empty() || name.size() > 63 || name.front() == '.') return false;
  for (const char c : name) {
    const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (!is_letter && !(c >= '0' && c <= '9') && c != '.' && c != '-' && c != '_') return false;
  }
  return true;
}

}  // namespace swiftlet::hal
