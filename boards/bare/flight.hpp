#pragma once
#include "companion/companion.hpp"
#include "swiftlet/hal/uart.hpp"

/// The flight application on a board without files, in that board's memory.
namespace swiftlet::board {

/// There is no file of settings here: they are compiled in.
companion::Settings flight_settings();

/// A companion in the map of the map region (board.hpp); nullptr, with a line on the console, when there is none. Plans
/// are made within a step, which takes as much longer, and taken over in the next one. To be called once.
companion::Companion* begin_flight(hal::Uart& autopilot, const char* map_path = "");

/// Writes the notes since the last call on the console.
void print_notes(const companion::Companion& companion);

}  // namespace swiftlet::board
