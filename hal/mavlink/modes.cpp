#include "swiftlet/mavlink/modes.hpp"

#include <array>
#include <span>

namespace swiftlet::mavlink {
namespace {

struct NamedMode {
  Mode mode;
  std::uint32_t custom_mode;
};

/// PX4's px4_custom_mode: main mode in bits 16 to 23, sub-mode above.
constexpr std::uint32_t px4(std::uint32_t main, std::uint32_t sub) { return main << 16U | sub << 24U; }

constexpr std::array kPx4Modes{NamedMode{Mode::kOffboard, px4(6, 0)}, NamedMode{Mode::kHold, px4(4, 3)},
                               NamedMode{Mode::kPosition, px4(3, 0)}, NamedMode{Mode::kTakeoff, px4(4, 2)},
                               NamedMode{Mode::kLand, px4(4, 6)},     NamedMode{Mode::kReturn, px4(4, 5)}};

/// ArduCopter's mode numbers; of two for one mode the first is the one that we ask for.
constexpr std::array kArduPilotModes{NamedMode{Mode::kOffboard, 4}, NamedMode{Mode::kHold, 17},
                                     NamedMode{Mode::kPosition, 5}, NamedMode{Mode::kPosition, 16},
                                     NamedMode{Mode::kLand, 9},     NamedMode{Mode::kReturn, 6}};

std::span<const NamedMode> modes_of(AutopilotKind kind) {
  if (kind == AutopilotKind::kPx4) return kPx4Modes;
  if (kind == AutopilotKind::kArduPilot) return kArduPilotModes;
  return {};
}

}  // namespace

AutopilotKind kind_of(const Heartbeat& heartbeat) {
  if (heartbeat.autopilot == kAutopilotPx4) return AutopilotKind::kPx4;
  if (heartbeat.autopilot == kAutopilotArduPilot) return AutopilotKind::kArduPilot;
  return AutopilotKind::kUnknown;
}

Mode mode_of(AutopilotKind kind, std::uint32_t custom_mode) {
  for (const NamedMode& named : modes_of(kind)) {
    if (named.custom_mode == custom_mode) return named.mode;
  }
  return Mode::kOther;
}

std::optional<std::uint32_t> custom_mode_of(AutopilotKind kind, Mode mode) {
  for (const NamedMode& named : modes_of(kind)) {
    if (named.mode == mode) return named.custom_mode;
  }
  return std::nullopt;
}

std::optional<CommandLong> set_mode_command(AutopilotKind kind, Mode mode) {
  const std::optional<std::uint32_t> custom_mode = custom_mode_of(kind, mode);
  if (!custom_mode.has_value()) return std::nullopt;
  CommandLong command;
  command.command = kCommandDoSetMode;
  command.param[0] = kModeFlagCustom;
  if (kind == AutopilotKind::kPx4) {
    command.param[1] = static_cast<float>(*custom_mode >> 16U & 0xFFU);
    command.param[2] = static_cast<float>(*custom_mode >> 24U);
  } else {
    command.param[1] = static_cast<float>(*custom_mode);
  }
  return command;
}

const char* name_of(Mode mode) {
  switch (mode) {
    case Mode::kUnknown:
      return "unknown";
    case Mode::kOther:
      return "other";
    case Mode::kOffboard:
      return "offboard";
    case Mode::kHold:
      return "hold";
    case Mode::kPosition:
      return "position";
    case Mode::kTakeoff:
      return "takeoff";
    case Mode::kLand:
      return "land";
    case Mode::kReturn:
      return "return";
  }
  return "unknown";
}

}  // namespace swiftlet::mavlink
