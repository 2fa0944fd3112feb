#include "cli/arguments.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string_view>

#include "cli/text.hpp"

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

}  // namespace swiftlet::tools
