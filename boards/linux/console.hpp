#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "companion/word.hpp"

namespace swiftlet::board {

/// What the operator types that is no word of a flight.
enum class Query { kStatus, kHelp, kQuit };
struct NewMap {
  std::string path;
};
using ConsoleLine = std::variant<companion::Word, Query, NewMap>;

/// One line of the console; nothing when it is not understood. Numbers may be parted by blanks or commas.
std::optional<ConsoleLine> parse_line(std::string_view line);

/// What may be typed.
inline constexpr const char* kConsoleHelp =
    "goal X Y Z [YAW]          fly there after the goals before it [m, rad]\n"
    "goto X Y Z [YAW]          fly there now, instead\n"
    "engage, release           take off and fly, or take control anew; let the autopilot hold\n"
    "stop, land                brake and forget the goals; brake and land\n"
    "block ID X Y Z X Y Z      keep out of the box between two corners\n"
    "unblock ID\n"
    "limits V A                [m/s] [m/s^2]\n"
    "map FILE                  another map\n"
    "status, help, quit\n";

}  // namespace swiftlet::board
