#pragma once
#include <string>
#include <string_view>

#include "companion/settings.hpp"

namespace swiftlet::tools {

/// The settings of a swiftlet-config/1 file (docs/flight.md tabulates the keys). Every key but `format` is optional.
/// Throws Failure (kBadFile) naming file and fault: an unknown key, a value of the wrong kind or out of range.
companion::Settings load_config(const std::string& path);

/// The same from a text; `where` names it in a fault.
companion::Settings parse_config(const std::string& where, std::string_view text);

/// All settings as such a text; parse_config gives the same settings back, bit for bit.
std::string config_text(const companion::Settings& settings);

}  // namespace swiftlet::tools
