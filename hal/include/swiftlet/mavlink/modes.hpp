#pragma once
#include <cstdint>
#include <optional>

#include "swiftlet/mavlink/messages.hpp"

/// Flight modes: the few that a companion asks for or must tell apart, and the numbers of each autopilot for them.
namespace swiftlet::mavlink {

enum class AutopilotKind : std::uint8_t { kUnknown, kPx4, kArduPilot };

enum class Mode : std::uint8_t {
  kUnknown,   ///< Nothing heard yet.
  kOther,     ///< A mode without a name here: a person chose it.
  kOffboard,  ///< Follows our set-points: PX4 OFFBOARD, ArduPilot GUIDED.
  kHold,      ///< Stays where it is by itself: PX4 HOLD, ArduPilot BRAKE.
  kPosition,  ///< A person flies with position control: PX4 POSITION, ArduPilot LOITER and POSHOLD.
  kTakeoff,   ///< PX4 only.
  kLand,
  kReturn,
};

AutopilotKind kind_of(const Heartbeat& heartbeat);

Mode mode_of(AutopilotKind kind, std::uint32_t custom_mode);

/// The number by which HEARTBEAT and CURRENT_MODE name the mode; nothing where the autopilot has no such mode.
std::optional<std::uint32_t> custom_mode_of(AutopilotKind kind, Mode mode);

/// MAV_CMD_DO_SET_MODE for the mode, without a target.
std::optional<CommandLong> set_mode_command(AutopilotKind kind, Mode mode);

/// Short English name, for logs.
const char* name_of(Mode mode);

}  // namespace swiftlet::mavlink
