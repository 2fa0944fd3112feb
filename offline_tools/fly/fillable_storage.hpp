#pragma once
#include "swiftlet/hal/storage.hpp"

namespace swiftlet::tools {

/// A storage that can be filled up at any moment.
class FillableStorage final : public hal::Storage {
 public:
  explicit FillableStorage(hal::Storage& storage) : storage_(storage) {}

  void fill() { full_ = true; }

  std::optional<std::size_t> read(std::string_view name, std::size_t offset, std::span<std::byte> into) override {
    return storage_.read(name, offset, into);
  }
  bool append(std::string_view name, std::span<const std::byte> bytes) override {
    return !full_ && storage_.append(name, bytes);
  }
  bool remove(std::string_view name) override { return storage_.remove(name); }

 private:
  hal::Storage& storage_;
  bool full_ = false;
};

}  // namespace swiftlet::tools
