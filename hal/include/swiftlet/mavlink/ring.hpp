#pragma once
#include <array>
#include <cstddef>
#include <optional>

namespace swiftlet::mavlink {

/// A queue of at most `kCapacity` elements.
template <typename T, std::size_t kCapacity>
class Ring {
 public:
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool try_push_back(const T& value) {
    if (size_ == kCapacity) return false;
    values_[(first_ + size_++) % kCapacity] = value;
    return true;
  }
  std::optional<T> pop_front() {
    if (size_ == 0) return std::nullopt;
    const T value = values_[first_];
    first_ = (first_ + 1) % kCapacity;
    --size_;
    return value;
  }
  /// The ring must not be empty.
  [[nodiscard]] T& front() { return values_[first_]; }

 private:
  std::array<T, kCapacity> values_{};
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace swiftlet::mavlink
