#pragma once
#include <string_view>

#include "companion/companion.hpp"
#include "swiftlet/hal/storage.hpp"
#include "swiftlet/hal/uart.hpp"

/// The flight application on a board without files, in that board's memory.
namespace swiftlet::board {

/// There is no file of settings here: they are compiled in.
companion::Settings flight_settings();

/// A companion in the map of the map region (board.hpp); nullptr, with a line on the console, when there is none. Plans
/// are made within a step, which takes as much longer, and taken over in the next one. Its log goes into `logs`, under
/// the first name of flight_0001.ulg and so on that is free. To be called once.
companion::Companion* begin_flight(hal::Uart& autopilot, hal::Storage& logs, const char* map_path = "");

/// Writes what still waits of the log, after the last step, and tells its name.
std::string_view end_log();

}  // namespace swiftlet::board
