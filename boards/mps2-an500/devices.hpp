#pragma once
#include "swiftlet/hal/clock.hpp"
#include "swiftlet/hal/storage.hpp"
#include "swiftlet/hal/uart.hpp"

/// What this board has beside the things that every board has.
namespace swiftlet::board {

/// CMSDK timer 0.
hal::Clock& clock();

/// UART 1 at 921,600 baud, for the autopilot. The first call enables its interrupts.
hal::Uart& autopilot_uart();

/// 4 MiB of memory, which keep their files through a reset but not without power.
hal::Storage& log_storage();

}  // namespace swiftlet::board
