#pragma once
#include <array>

#include "swiftlet/hal/storage.hpp"

namespace swiftlet::hal {

/// Memory as a storage, with a size that can be used up.
class FakeStorage final : public Storage {
 public:
  static constexpr std::size_t kFiles = 2;  // a bare board keeps them on a stack of 64 KiB
  static constexpr std::size_t kFileBytes = 16384;

  /// From now on `append` stores at most this many bytes more, over all files.
  void set_free_bytes(std::size_t bytes) { free_bytes_ = bytes; }

  std::optional<std::size_t> read(std::string_view name, std::size_t offset, std::span<std::byte> into) override;
  bool append(std::string_view name, std::span<const std::byte> bytes) override;
  bool remove(std::string_view name) override;

 private:
  struct File {
    std::array<char, 64> name{};
    std::array<std::byte, kFileBytes> bytes{};
    std::size_t size = 0;
  };

  File* find(std::string_view name);  ///< An empty name finds an unused file.

  std::array<File, kFiles> files_{};
  std::size_t free_bytes_ = kFiles * kFileBytes;
};

}  // namespace swiftlet::hal
