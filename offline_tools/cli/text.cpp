#include "cli/text.hpp"

#include <array>
#include <charconv>
#include <cstdio>
#include <cstdlib>

namespace swiftlet::tools {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::optional<double> parse_number(std::string_view text) {
  text = trimmed(text);
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (end != text.data() + text.size() || error == std::errc::invalid_argument) return std::nullopt;
  // Too large or too small for a double: strtod says which, as infinity or as (nearly) zero.
  if (error == std::errc::result_out_of_range) return std::strtod(std::string(text).c_str(), nullptr);
  return number;
}

std::vector<std::string_view> split_at_commas(std::string_view text) {
  std::vector<std::string_view> pieces;
  for (std::size_t begin = 0;;) {
    const std::size_t comma = text.find(',', begin);
    pieces.push_back(trimmed(text.substr(begin, comma - begin)));
    if (comma == std::string_view::npos) return pieces;
    begin = comma + 1;
  }
}

std::string to_text(double value, int decimals) {
  std::array<char, 384> text{};  // the largest double has 309 digits
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return text.data();
}

std::string to_text(const Vector3& point) {
  return to_text(point[0], 3) + ", " + to_text(point[1], 3) + ", " + to_text(point[2], 3);
}

}  // namespace swiftlet::tools
