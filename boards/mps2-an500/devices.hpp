#pragma once
#include "swiftlet/hal/clock.hpp"
#include "swiftlet/hal/uart.hpp"

/// What this board has beside the things that every board has.
namespace swiftlet::board {

/// CMSDK timer 0.
hal::Clock& clock();

/// UART 1 at 921,600 baud, for the autopilot. The first call enables its interrupts.
hal::Uart& autopilot_uart();

}  // namespace swiftlet::board
