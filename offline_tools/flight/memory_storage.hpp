#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

#include "swiftlet/hal/storage.hpp"

namespace swiftlet::tools {

/// Memory as a storage of a single log, whatever it is called.
class MemoryStorage final : public hal::Storage {
 public:
  std::optional<std::size_t> read(std::string_view /*name*/, std::size_t offset, std::span<std::byte> into) override {
    if (bytes_.empty()) return std::nullopt;
    const std::size_t from = std::min(offset, bytes_.size());
    const std::size_t count = std::min(into.size(), bytes_.size() - from);
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(from), count, into.begin());
    return count;
  }
  bool append(std::string_view /*name*/, std::span<const std::byte> bytes) override {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return true;
  }
  bool remove(std::string_view /*name*/) override {
    bytes_.clear();
    return true;
  }
  [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

}  // namespace swiftlet::tools
