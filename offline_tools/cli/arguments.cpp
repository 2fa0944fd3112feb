#include "cli/arguments.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace swiftlet::tools {
namespace {

double finite_number(const std::string& name, std::string_view text, const NumberRange& range) {
  const std::optional<double> number = parse_number(text);
  if (!number || !std::isfinite(*number)) {
    throw CLI::ValidationError(name, "'" + std::string(text) + "' is not a finite number");
  }
  if (*number < range.lo || *number > range.hi) {
    std::array<char, 96> limits{};
    std::snprintf(limits.data(), limits.size(), "' is out of range: %g to %g", range.lo, range.hi);
    throw CLI::ValidationError(name, "'" + std::string(text) + limits.data());
  }
  return *number;
}

}  // namespace

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

CLI::Option* add_number(CLI::App& app, const std::string& name, double& target, const NumberRange& range,
                        const std::string& description) {
  const auto parse = [&target, name, range](const std::string& text) { target = finite_number(name, text, range); };
  return app.add_option_function<std::string>(name, parse, description)->type_name("N");
}

CLI::Option* add_count(CLI::App& app, const std::string& name, std::uint64_t& target, std::uint64_t lo,
                       std::uint64_t hi, const std::string& description) {
  const auto parse = [&target, name, lo, hi](const std::string& text) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), target);
    if (error != std::errc() || end != text.data() + text.size() || target < lo || target > hi) {
      throw CLI::ValidationError(
          name, "'" + text + "' is not a whole number from " + std::to_string(lo) + " to " + std::to_string(hi));
    }
  };
  return app.add_option_function<std::string>(name, parse, description)->type_name("N");
}

CLI::Option* add_vector(CLI::App& app, const std::string& name, Vector3& target, const std::string& description) {
  const auto parse = [&target, name](const std::string& text) {
    const std::vector<std::string_view> pieces = split_at_commas(text);
    if (pieces.size() != 3) throw CLI::ValidationError(name, "'" + text + "' is not three numbers X,Y,Z");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      target[static_cast<Eigen::Index>(axis)] = finite_number(name, pieces[axis], {});
    }
  };
  return app.add_option_function<std::string>(name, parse, description)->type_name("X,Y,Z");
}

CLI::Option* add_choice(CLI::App& app, const std::string& name, std::string& target,
                        const std::vector<std::string>& choices, const std::string& description) {
  return app.add_option(name, target, description)->check(CLI::IsMember(choices))->capture_default_str();
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
