#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "swiftlet/types.hpp"

namespace swiftlet::tools {

/// The number that makes up the whole text, blanks at its ends aside; may be infinite or not a number ("nan", "1e999").
std::optional<double> parse_number(std::string_view text);

/// The text without blanks at its ends.
std::string_view trimmed(std::string_view text);

/// The text cut at every comma, each piece without blanks at its ends.
std::vector<std::string_view> split_at_commas(std::string_view text);

/// "x, y, z" with three decimals, for people.
std::string to_text(const Vector3& point);
/// `value` with so many decimals.
std::string to_text(double value, int decimals);

}  // namespace swiftlet::tools
