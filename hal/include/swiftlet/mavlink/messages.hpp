#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "swiftlet/mavlink/frames.hpp"

/// The messages that the link sends or takes, as MAVLink defines them (dialect common): units and frames of the
/// protocol, in types that cannot be taken for ours. Fields that nobody here uses are left out and sent as zero, or
/// where the protocol knows "unknown", as that.
namespace swiftlet::mavlink {

struct Address {
  std::uint8_t system = 0;
  std::uint8_t component = 0;
  friend bool operator==(const Address&, const Address&) = default;
};

inline constexpr std::uint8_t kAutopilotComponent = 1;
inline constexpr std::uint8_t kPathPlannerComponent = 195;

/// MAV_RESULT.
enum class CommandResult : std::uint8_t {
  kAccepted = 0,
  kTemporarilyRejected = 1,
  kDenied = 2,
  kUnsupported = 3,
  kFailed = 4,
  kInProgress = 5,
};

/// MAV_STATE.
enum class SystemState : std::uint8_t {
  kUninitialised = 0,
  kBoot = 1,
  kCalibrating = 2,
  kStandby = 3,
  kActive = 4,
  kCritical = 5,
  kEmergency = 6,
  kPoweroff = 7,
  kTermination = 8,
};

/// MAV_SEVERITY.
enum class Severity : std::uint8_t { kEmergency, kAlert, kCritical, kError, kWarning, kNotice, kInfo, kDebug };

/// MAV_LANDED_STATE.
enum class LandedState : std::uint8_t { kUnknown, kOnGround, kInAir, kTakingOff, kLanding };

/// MAV_CMD, those that the link knows.
inline constexpr std::uint16_t kCommandDoSetMode = 176;
inline constexpr std::uint16_t kCommandArmDisarm = 400;
inline constexpr std::uint16_t kCommandSetMessageInterval = 511;
inline constexpr std::uint16_t kCommandRequestMessage = 512;

/// MAV_TYPE, MAV_AUTOPILOT, MAV_MODE_FLAG, MAV_SYS_STATUS_SENSOR, MAV_FRAME.
inline constexpr std::uint8_t kTypeQuadrotor = 2;
inline constexpr std::uint8_t kTypeGroundStation = 6;
inline constexpr std::uint8_t kTypeOnboardController = 18;
inline constexpr std::uint8_t kAutopilotArduPilot = 3;
inline constexpr std::uint8_t kAutopilotInvalid = 8;
inline constexpr std::uint8_t kAutopilotPx4 = 12;
inline constexpr std::uint8_t kModeFlagCustom = 0x01;
inline constexpr std::uint8_t kModeFlagArmed = 0x80;
inline constexpr std::uint32_t kSensorPrearmCheck = 0x10000000;
inline constexpr std::uint8_t kFrameLocalNed = 1;
inline constexpr std::uint8_t kFrameBodyNed = 8;
inline constexpr std::uint8_t kFrameBodyFrd = 12;
inline constexpr std::uint8_t kFrameLocalFlu = 21;

/// POSITION_TARGET_TYPEMASK: a set bit says "ignore".
inline constexpr std::uint16_t kIgnorePosition = 0x007;
inline constexpr std::uint16_t kIgnoreVelocity = 0x038;
inline constexpr std::uint16_t kIgnoreAcceleration = 0x1C0;
inline constexpr std::uint16_t kAccelerationIsForce = 0x200;
inline constexpr std::uint16_t kIgnoreYaw = 0x400;
inline constexpr std::uint16_t kIgnoreYawRate = 0x800;

/// ATTITUDE_TARGET_TYPEMASK.
inline constexpr std::uint8_t kIgnoreBodyRates = 0x07;
inline constexpr std::uint8_t kIgnoreThrust = 0x40;
inline constexpr std::uint8_t kIgnoreAttitude = 0x80;

inline constexpr std::uint8_t kParameterReal32 = 9;  ///< MAV_PARAM_TYPE_REAL32

/// A parameter's name, zero-padded; without a zero when it has 16 characters.
using ParameterName = std::array<char, 16>;

/// The characters up to the first zero or the end.
template <std::size_t kSize>
std::string_view text_of(const std::array<char, kSize>& text) {
  std::size_t size = 0;
  while (size < kSize && text[size] != '\0') ++size;
  return {text.data(), size};
}

struct Heartbeat {
  static constexpr std::uint32_t kId = 0;
  std::uint32_t custom_mode = 0;
  std::uint8_t type = 0;
  std::uint8_t autopilot = 0;
  std::uint8_t base_mode = 0;
  SystemState system_status = SystemState::kUninitialised;
};

struct SystemStatus {
  static constexpr std::uint32_t kId = 1;
  std::uint32_t sensors_present = 0;
  std::uint32_t sensors_enabled = 0;
  std::uint32_t sensors_health = 0;
  std::uint16_t voltage_mv = 0xFFFF;
  std::int8_t battery_percent = -1;
};

struct ParameterRequest {
  static constexpr std::uint32_t kId = 20;
  Address target{};
  ParameterName name{};
  std::int16_t index = -1;  ///< -1: by name.
};

struct ParameterListRequest {
  static constexpr std::uint32_t kId = 21;
  Address target{};
};

struct ParameterValue {
  static constexpr std::uint32_t kId = 22;
  ParameterName name{};
  float value = 0;
  std::uint8_t type = kParameterReal32;
  std::uint16_t count = 0;
  std::uint16_t index = 0;
};

struct ParameterSet {
  static constexpr std::uint32_t kId = 23;
  Address target{};
  ParameterName name{};
  float value = 0;
  std::uint8_t type = kParameterReal32;
};

struct AttitudeQuaternion {
  static constexpr std::uint32_t kId = 31;
  std::uint32_t time_boot_ms = 0;
  NedQuaternion attitude{};
  FrdVector body_rates{};  ///< [rad/s]
};

struct LocalPositionNed {
  static constexpr std::uint32_t kId = 32;
  std::uint32_t time_boot_ms = 0;
  NedVector position{};  ///< [m]
  NedVector velocity{};  ///< [m/s]
};

struct CommandInt {
  static constexpr std::uint32_t kId = 75;
  Address target{};
  std::uint16_t command = 0;
  std::uint8_t frame = 0;
  std::array<float, 4> param{};
  std::int32_t x = 0;
  std::int32_t y = 0;
  float z = 0;
};

struct CommandLong {
  static constexpr std::uint32_t kId = 76;
  Address target{};
  std::uint16_t command = 0;
  std::uint8_t confirmation = 0;  ///< Counts transmissions of the same command.
  std::array<float, 7> param{};
};

struct CommandAck {
  static constexpr std::uint32_t kId = 77;
  std::uint16_t command = 0;
  CommandResult result = CommandResult::kAccepted;
  Address target{};
};

struct SetAttitudeTarget {
  static constexpr std::uint32_t kId = 82;
  std::uint32_t time_boot_ms = 0;
  Address target{};
  std::uint8_t type_mask = 0;
  NedQuaternion attitude{};
  FrdVector body_rates{};  ///< [rad/s]
  float thrust = 0;        ///< Of the full collective thrust, 0 to 1.
};

/// SET_POSITION_TARGET_LOCAL_NED.
struct SetPositionTarget {
  static constexpr std::uint32_t kId = 84;
  std::uint32_t time_boot_ms = 0;
  Address target{};
  std::uint8_t frame = kFrameLocalNed;
  std::uint16_t type_mask = 0;
  NedVector position{};      ///< [m], in the message's frame, which need not be NED: see `frame`.
  NedVector velocity{};      ///< [m/s]
  NedVector acceleration{};  ///< [m/s^2]
  float yaw = 0;             ///< [rad]
  float yaw_rate = 0;        ///< [rad/s]
};

/// POSITION_TARGET_LOCAL_NED: what the autopilot is following.
struct PositionTarget {
  static constexpr std::uint32_t kId = 85;
  std::uint32_t time_boot_ms = 0;
  std::uint8_t frame = kFrameLocalNed;
  std::uint16_t type_mask = 0;
  NedVector position{};
  NedVector velocity{};
  NedVector acceleration{};
  float yaw = 0;
  float yaw_rate = 0;
};

struct TimeSyncMessage {
  static constexpr std::uint32_t kId = 111;
  std::int64_t tc1 = 0;  ///< [ns] 0 in a request; in an answer the time of who answers.
  std::int64_t ts1 = 0;  ///< [ns] Time of who asks, echoed.
};

struct ExtendedSystemState {
  static constexpr std::uint32_t kId = 245;
  LandedState landed_state = LandedState::kUnknown;
};

struct StatusText {
  static constexpr std::uint32_t kId = 253;
  Severity severity = Severity::kInfo;
  std::array<char, 50> text{};  ///< Without a zero when all 50 characters are used.
  std::uint16_t id = 0;         ///< 0: a text in one piece.
  std::uint8_t chunk = 0;
};

struct Odometry {
  static constexpr std::uint32_t kId = 331;
  std::uint64_t time_us = 0;
  std::uint8_t frame = kFrameLocalNed;
  std::uint8_t child_frame = kFrameBodyFrd;
  NedVector position{};  ///< [m]
  NedQuaternion attitude{};
  Vector3 velocity_child = Vector3::Zero();  ///< [m/s] in `child_frame`.
  FrdVector body_rates{};                    ///< [rad/s]
  std::uint8_t reset_counter = 0;            ///< Counts jumps of the estimate.
};

struct CurrentMode {
  static constexpr std::uint32_t kId = 436;
  std::uint32_t custom_mode = 0;
  std::uint32_t intended_custom_mode = 0;
  std::uint8_t standard_mode = 0;
};

}  // namespace swiftlet::mavlink
