#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "swiftlet/types.hpp"

namespace swiftlet::companion {

/// A line of text put together without stdio, which would bring a heap. What does not fit is cut.
class Line {
 public:
  static constexpr std::size_t kCapacity = 120;

  Line() = default;
  Line(std::string_view text) { *this << text; }  // NOLINT(google-explicit-constructor)
  Line(const char* text) { *this << text; }       // NOLINT(google-explicit-constructor)

  Line& operator<<(std::string_view text);
  Line& operator<<(const char* text) { return *this << std::string_view(text); }
  Line& operator<<(std::uint32_t number);
  /// With two decimals.
  Line& operator<<(Real number);
  /// "x y z", two decimals each.
  Line& operator<<(const Vector3& v);

  [[nodiscard]] std::string_view view() const { return {text_.data(), size_}; }

 private:
  std::array<char, kCapacity> text_{};
  std::size_t size_ = 0;
};

}  // namespace swiftlet::companion
