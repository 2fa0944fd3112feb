#pragma once
#include <array>

#include "swiftlet/hal/region_storage.hpp"

namespace swiftlet::hal {

/// A storage in memory of its own, with a size that can be used up.
class FakeStorage final : public Storage {
 public:
  static constexpr std::size_t kBytes = 32768;  // a bare board keeps it on a stack of 64 KiB

  /// From now on `append` stores at most this many bytes more, over all files.
  void set_free_bytes(std::size_t bytes) { storage_.set_free_bytes(bytes); }

  std::optional<std::size_t> read(std::string_view name, std::size_t offset, std::span<std::byte> into) override {
    return storage_.read(name, offset, into);
  }
  bool append(std::string_view name, std::span<const std::byte> bytes) override { return storage_.append(name, bytes); }
  bool remove(std::string_view name) override { return storage_.remove(name); }

 private:
  alignas(4) std::array<std::byte, kBytes> region_{};
  RegionStorage storage_{region_};
};

}  // namespace swiftlet::hal
