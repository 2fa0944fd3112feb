#include "companion/text.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet::companion {

Line& Line::operator<<(std::string_view text) {
  const std::size_t count = std::min(text.size(), kCapacity - size_);
  std::copy_n(text.begin(), count, text_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += count;
  return *this;
}

Line& Line::operator<<(std::uint32_t number) {
  std::array<char, 10> digits{};
  std::size_t first = digits.size();
  do {
    digits[--first] = static_cast<char>('0' + number % 10);
    number /= 10;
  } while (number != 0);
  return *this << std::string_view(&digits[first], digits.size() - first);
}

Line& Line::operator<<(Real number) {
  constexpr Real kLargest = 1'000'000;
  if (!(std::fabs(number) < kLargest)) return *this << "out of range";  // NaN as well
  const auto hundredths = static_cast<std::uint32_t>(std::fabs(number) * 100 + Real(0.5));
  if (number < 0 && hundredths != 0) *this << "-";
  *this << hundredths / 100 << ".";
  if (hundredths % 100 < 10) *this << "0";
  return *this << hundredths % 100;
}

Line& Line::operator<<(const Vector3& v) { return *this << v.x() << " " << v.y() << " " << v.z(); }

}  // namespace swiftlet::companion
