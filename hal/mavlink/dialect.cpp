#include "dialect.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "swiftlet/mavlink.h"  // generated
#include "swiftlet/mavlink/codec.hpp"

namespace swiftlet::mavlink {
namespace {

static_assert(std::endian::native == std::endian::little, "MAVLink's structs are copied as they lie in memory");
static_assert(kMaxPayload == MAVLINK_MAX_PAYLOAD_LEN && kMaxFrame == MAVLINK_MAX_PACKET_LEN);
static_assert(kPathPlannerComponent == MAV_COMP_ID_PATHPLANNER && kAutopilotComponent == MAV_COMP_ID_AUTOPILOT1);
static_assert(kCommandDoSetMode == MAV_CMD_DO_SET_MODE && kCommandArmDisarm == MAV_CMD_COMPONENT_ARM_DISARM);
static_assert(kCommandSetMessageInterval == MAV_CMD_SET_MESSAGE_INTERVAL);
static_assert(kCommandRequestMessage == MAV_CMD_REQUEST_MESSAGE);
static_assert(kTypeQuadrotor == MAV_TYPE_QUADROTOR && kTypeGroundStation == MAV_TYPE_GCS);
static_assert(kTypeOnboardController == MAV_TYPE_ONBOARD_CONTROLLER && kAutopilotInvalid == MAV_AUTOPILOT_INVALID);
static_assert(kAutopilotPx4 == MAV_AUTOPILOT_PX4 && kAutopilotArduPilot == MAV_AUTOPILOT_ARDUPILOTMEGA);
static_assert(kModeFlagCustom == MAV_MODE_FLAG_CUSTOM_MODE_ENABLED && kModeFlagArmed == MAV_MODE_FLAG_SAFETY_ARMED);
static_assert(kSensorPrearmCheck == MAV_SYS_STATUS_PREARM_CHECK && kParameterReal32 == MAV_PARAM_TYPE_REAL32);
static_assert(kFrameLocalNed == MAV_FRAME_LOCAL_NED && kFrameBodyNed == MAV_FRAME_BODY_NED);
static_assert(kFrameBodyFrd == MAV_FRAME_BODY_FRD && kFrameLocalFlu == MAV_FRAME_LOCAL_FLU);
static_assert(static_cast<int>(CommandResult::kInProgress) == MAV_RESULT_IN_PROGRESS);
static_assert(static_cast<int>(SystemState::kTermination) == MAV_STATE_FLIGHT_TERMINATION);
static_assert(static_cast<int>(Severity::kDebug) == MAV_SEVERITY_DEBUG);
static_assert(static_cast<int>(LandedState::kLanding) == MAV_LANDED_STATE_LANDING);
static_assert(kIgnoreYawRate == POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE && kIgnoreYaw * 2 == kIgnoreYawRate);
static_assert(kAccelerationIsForce == POSITION_TARGET_TYPEMASK_FORCE_SET);
static_assert(kIgnoreAttitude == ATTITUDE_TARGET_TYPEMASK_ATTITUDE_IGNORE);
static_assert(kIgnoreThrust == ATTITUDE_TARGET_TYPEMASK_THROTTLE_IGNORE);

/// The structs of the generated headers, apart from ours of nearly the same names.
template <typename Message>
struct Wire;
#define SWIFTLET_WIRE(Message, name, NAME)                             \
  template <>                                                          \
  struct Wire<Message> {                                               \
    using Struct = mavlink_##name##_t;                                 \
    static constexpr std::size_t kBytes = MAVLINK_MSG_ID_##NAME##_LEN; \
    static_assert(Message::kId == MAVLINK_MSG_ID_##NAME);              \
  }
SWIFTLET_WIRE(Heartbeat, heartbeat, HEARTBEAT);
SWIFTLET_WIRE(SystemStatus, sys_status, SYS_STATUS);
SWIFTLET_WIRE(ParameterRequest, param_request_read, PARAM_REQUEST_READ);
SWIFTLET_WIRE(ParameterListRequest, param_request_list, PARAM_REQUEST_LIST);
SWIFTLET_WIRE(ParameterValue, param_value, PARAM_VALUE);
SWIFTLET_WIRE(ParameterSet, param_set, PARAM_SET);
SWIFTLET_WIRE(AttitudeQuaternion, attitude_quaternion, ATTITUDE_QUATERNION);
SWIFTLET_WIRE(LocalPositionNed, local_position_ned, LOCAL_POSITION_NED);
SWIFTLET_WIRE(CommandInt, command_int, COMMAND_INT);
SWIFTLET_WIRE(CommandLong, command_long, COMMAND_LONG);
SWIFTLET_WIRE(CommandAck, command_ack, COMMAND_ACK);
SWIFTLET_WIRE(SetAttitudeTarget, set_attitude_target, SET_ATTITUDE_TARGET);
SWIFTLET_WIRE(SetPositionTarget, set_position_target_local_ned, SET_POSITION_TARGET_LOCAL_NED);
SWIFTLET_WIRE(PositionTarget, position_target_local_ned, POSITION_TARGET_LOCAL_NED);
SWIFTLET_WIRE(TimeSyncMessage, timesync, TIMESYNC);
SWIFTLET_WIRE(ExtendedSystemState, extended_sys_state, EXTENDED_SYS_STATE);
SWIFTLET_WIRE(StatusText, statustext, STATUSTEXT);
SWIFTLET_WIRE(Odometry, odometry, ODOMETRY);
SWIFTLET_WIRE(CurrentMode, current_mode, CURRENT_MODE);
#undef SWIFTLET_WIRE

Vector3 vector(float x, float y, float z) { return {Real(x), Real(y), Real(z)}; }

void put(const Vector3& v, float& x, float& y, float& z) {
  x = static_cast<float>(v.x());
  y = static_cast<float>(v.y());
  z = static_cast<float>(v.z());
}

Quaternion quaternion(const float* wxyz) { return {Real(wxyz[0]), Real(wxyz[1]), Real(wxyz[2]), Real(wxyz[3])}; }

void put(const Quaternion& q, float* wxyz) {
  wxyz[0] = static_cast<float>(q.w());
  wxyz[1] = static_cast<float>(q.x());
  wxyz[2] = static_cast<float>(q.y());
  wxyz[3] = static_cast<float>(q.z());
}

/// Fields of the same form in several messages.
template <typename Struct>
Address target_of(const Struct& wire) {
  return {wire.target_system, wire.target_component};
}
template <typename Struct>
void put(Address target, Struct& wire) {
  wire.target_system = target.system;
  wire.target_component = target.component;
}
template <typename Message, typename Struct>
void fill_target(const Message& message, Struct& wire) {
  wire.time_boot_ms = message.time_boot_ms;
  wire.coordinate_frame = message.frame;
  wire.type_mask = message.type_mask;
  put(message.position.value, wire.x, wire.y, wire.z);
  put(message.velocity.value, wire.vx, wire.vy, wire.vz);
  put(message.acceleration.value, wire.afx, wire.afy, wire.afz);
  wire.yaw = message.yaw;
  wire.yaw_rate = message.yaw_rate;
}
template <typename Struct, typename Message>
void read_target(const Struct& wire, Message& message) {
  message.time_boot_ms = wire.time_boot_ms;
  message.frame = wire.coordinate_frame;
  message.type_mask = wire.type_mask;
  message.position.value = vector(wire.x, wire.y, wire.z);
  message.velocity.value = vector(wire.vx, wire.vy, wire.vz);
  message.acceleration.value = vector(wire.afx, wire.afy, wire.afz);
  message.yaw = wire.yaw;
  message.yaw_rate = wire.yaw_rate;
}

// One pair for each message: ours to theirs, theirs to ours.

void convert(const Heartbeat& message, mavlink_heartbeat_t& wire) {
  wire.custom_mode = message.custom_mode;
  wire.type = message.type;
  wire.autopilot = message.autopilot;
  wire.base_mode = message.base_mode;
  wire.system_status = static_cast<std::uint8_t>(message.system_status);
  wire.mavlink_version = 3;
}
void convert(const mavlink_heartbeat_t& wire, Heartbeat& message) {
  message = {wire.custom_mode, wire.type, wire.autopilot, wire.base_mode, static_cast<SystemState>(wire.system_status)};
}

void convert(const SystemStatus& message, mavlink_sys_status_t& wire) {
  wire.onboard_control_sensors_present = message.sensors_present;
  wire.onboard_control_sensors_enabled = message.sensors_enabled;
  wire.onboard_control_sensors_health = message.sensors_health;
  wire.voltage_battery = message.voltage_mv;
  wire.current_battery = -1;
  wire.battery_remaining = message.battery_percent;
}
void convert(const mavlink_sys_status_t& wire, SystemStatus& message) {
  message.sensors_present = wire.onboard_control_sensors_present;
  message.sensors_enabled = wire.onboard_control_sensors_enabled;
  message.sensors_health = wire.onboard_control_sensors_health;
  message.voltage_mv = wire.voltage_battery;
  message.battery_percent = wire.battery_remaining;
}

void convert(const ParameterRequest& message, mavlink_param_request_read_t& wire) {
  put(message.target, wire);
  std::memcpy(wire.param_id, message.name.data(), sizeof wire.param_id);
  wire.param_index = message.index;
}
void convert(const mavlink_param_request_read_t& wire, ParameterRequest& message) {
  message.target = target_of(wire);
  std::memcpy(message.name.data(), wire.param_id, sizeof wire.param_id);
  message.index = wire.param_index;
}

void convert(const ParameterListRequest& message, mavlink_param_request_list_t& wire) { put(message.target, wire); }
void convert(const mavlink_param_request_list_t& wire, ParameterListRequest& message) {
  message.target = target_of(wire);
}

void convert(const ParameterValue& message, mavlink_param_value_t& wire) {
  std::memcpy(wire.param_id, message.name.data(), sizeof wire.param_id);
  wire.param_value = message.value;
  wire.param_type = message.type;
  wire.param_count = message.count;
  wire.param_index = message.index;
}
void convert(const mavlink_param_value_t& wire, ParameterValue& message) {
  std::memcpy(message.name.data(), wire.param_id, sizeof wire.param_id);
  message.value = wire.param_value;
  message.type = wire.param_type;
  message.count = wire.param_count;
  message.index = wire.param_index;
}

void convert(const ParameterSet& message, mavlink_param_set_t& wire) {
  put(message.target, wire);
  std::memcpy(wire.param_id, message.name.data(), sizeof wire.param_id);
  wire.param_value = message.value;
  wire.param_type = message.type;
}
void convert(const mavlink_param_set_t& wire, ParameterSet& message) {
  message.target = target_of(wire);
  std::memcpy(message.name.data(), wire.param_id, sizeof wire.param_id);
  message.value = wire.param_value;
  message.type = wire.param_type;
}

void convert(const AttitudeQuaternion& message, mavlink_attitude_quaternion_t& wire) {
  const Quaternion& q = message.attitude.value;
  wire.time_boot_ms = message.time_boot_ms;
  wire.q1 = static_cast<float>(q.w());
  put(q.vec(), wire.q2, wire.q3, wire.q4);
  put(message.body_rates.value, wire.rollspeed, wire.pitchspeed, wire.yawspeed);
}
void convert(const mavlink_attitude_quaternion_t& wire, AttitudeQuaternion& message) {
  message.time_boot_ms = wire.time_boot_ms;
  message.attitude.value = Quaternion(Real(wire.q1), Real(wire.q2), Real(wire.q3), Real(wire.q4));
  message.body_rates.value = vector(wire.rollspeed, wire.pitchspeed, wire.yawspeed);
}

void convert(const LocalPositionNed& message, mavlink_local_position_ned_t& wire) {
  wire.time_boot_ms = message.time_boot_ms;
  put(message.position.value, wire.x, wire.y, wire.z);
  put(message.velocity.value, wire.vx, wire.vy, wire.vz);
}
void convert(const mavlink_local_position_ned_t& wire, LocalPositionNed& message) {
  message.time_boot_ms = wire.time_boot_ms;
  message.position.value = vector(wire.x, wire.y, wire.z);
  message.velocity.value = vector(wire.vx, wire.vy, wire.vz);
}

void convert(const CommandInt& message, mavlink_command_int_t& wire) {
  put(message.target, wire);
  wire.command = message.command;
  wire.frame = message.frame;
  wire.param1 = message.param[0];
  wire.param2 = message.param[1];
  wire.param3 = message.param[2];
  wire.param4 = message.param[3];
  wire.x = message.x;
  wire.y = message.y;
  wire.z = message.z;
}
void convert(const mavlink_command_int_t& wire, CommandInt& message) {
  message.target = target_of(wire);
  message.command = wire.command;
  message.frame = wire.frame;
  message.param = {wire.param1, wire.param2, wire.param3, wire.param4};
  message.x = wire.x;
  message.y = wire.y;
  message.z = wire.z;
}

void convert(const CommandLong& message, mavlink_command_long_t& wire) {
  put(message.target, wire);
  wire.command = message.command;
  wire.confirmation = message.confirmation;
  wire.param1 = message.param[0];
  wire.param2 = message.param[1];
  wire.param3 = message.param[2];
  wire.param4 = message.param[3];
  wire.param5 = message.param[4];
  wire.param6 = message.param[5];
  wire.param7 = message.param[6];
}
void convert(const mavlink_command_long_t& wire, CommandLong& message) {
  message.target = target_of(wire);
  message.command = wire.command;
  message.confirmation = wire.confirmation;
  message.param = {wire.param1, wire.param2, wire.param3, wire.param4, wire.param5, wire.param6, wire.param7};
}

void convert(const CommandAck& message, mavlink_command_ack_t& wire) {
  put(message.target, wire);
  wire.command = message.command;
  wire.result = static_cast<std::uint8_t>(message.result);
}
void convert(const mavlink_command_ack_t& wire, CommandAck& message) {
  message = {wire.command, static_cast<CommandResult>(wire.result), target_of(wire)};
}

void convert(const SetAttitudeTarget& message, mavlink_set_attitude_target_t& wire) {
  put(message.target, wire);
  wire.time_boot_ms = message.time_boot_ms;
  wire.type_mask = message.type_mask;
  put(message.attitude.value, wire.q);
  put(message.body_rates.value, wire.body_roll_rate, wire.body_pitch_rate, wire.body_yaw_rate);
  wire.thrust = message.thrust;
}
void convert(const mavlink_set_attitude_target_t& wire, SetAttitudeTarget& message) {
  message.target = target_of(wire);
  message.time_boot_ms = wire.time_boot_ms;
  message.type_mask = wire.type_mask;
  message.attitude.value = quaternion(wire.q);
  message.body_rates.value = vector(wire.body_roll_rate, wire.body_pitch_rate, wire.body_yaw_rate);
  message.thrust = wire.thrust;
}

void convert(const SetPositionTarget& message, mavlink_set_position_target_local_ned_t& wire) {
  put(message.target, wire);
  fill_target(message, wire);
}
void convert(const mavlink_set_position_target_local_ned_t& wire, SetPositionTarget& message) {
  message.target = target_of(wire);
  read_target(wire, message);
}

void convert(const PositionTarget& message, mavlink_position_target_local_ned_t& wire) { fill_target(message, wire); }
void convert(const mavlink_position_target_local_ned_t& wire, PositionTarget& message) { read_target(wire, message); }

void convert(const TimeSyncMessage& message, mavlink_timesync_t& wire) {
  wire.tc1 = message.tc1;
  wire.ts1 = message.ts1;
}
void convert(const mavlink_timesync_t& wire, TimeSyncMessage& message) { message = {wire.tc1, wire.ts1}; }

void convert(const ExtendedSystemState& message, mavlink_extended_sys_state_t& wire) {
  wire.landed_state = static_cast<std::uint8_t>(message.landed_state);
}
void convert(const mavlink_extended_sys_state_t& wire, ExtendedSystemState& message) {
  message.landed_state = static_cast<LandedState>(wire.landed_state);
}

void convert(const StatusText& message, mavlink_statustext_t& wire) {
  wire.severity = static_cast<std::uint8_t>(message.severity);
  std::memcpy(wire.text, message.text.data(), sizeof wire.text);
  wire.id = message.id;
  wire.chunk_seq = message.chunk;
}
void convert(const mavlink_statustext_t& wire, StatusText& message) {
  message.severity = static_cast<Severity>(wire.severity);
  std::memcpy(message.text.data(), wire.text, sizeof wire.text);
  message.id = wire.id;
  message.chunk = wire.chunk_seq;
}

void convert(const Odometry& message, mavlink_odometry_t& wire) {
  wire.time_usec = message.time_us;
  wire.frame_id = message.frame;
  wire.child_frame_id = message.child_frame;
  put(message.position.value, wire.x, wire.y, wire.z);
  put(message.attitude.value, wire.q);
  put(message.velocity_child, wire.vx, wire.vy, wire.vz);
  put(message.body_rates.value, wire.rollspeed, wire.pitchspeed, wire.yawspeed);
  wire.pose_covariance[0] = std::numeric_limits<float>::quiet_NaN();  // unknown
  wire.velocity_covariance[0] = std::numeric_limits<float>::quiet_NaN();
  wire.reset_counter = message.reset_counter;
  wire.estimator_type = MAV_ESTIMATOR_TYPE_AUTOPILOT;
}
void convert(const mavlink_odometry_t& wire, Odometry& message) {
  message.time_us = wire.time_usec;
  message.frame = wire.frame_id;
  message.child_frame = wire.child_frame_id;
  message.position.value = vector(wire.x, wire.y, wire.z);
  message.attitude.value = quaternion(wire.q);
  message.velocity_child = vector(wire.vx, wire.vy, wire.vz);
  message.body_rates.value = vector(wire.rollspeed, wire.pitchspeed, wire.yawspeed);
  message.reset_counter = wire.reset_counter;
}

void convert(const CurrentMode& message, mavlink_current_mode_t& wire) {
  wire.custom_mode = message.custom_mode;
  wire.intended_custom_mode = message.intended_custom_mode;
  wire.standard_mode = message.standard_mode;
}
void convert(const mavlink_current_mode_t& wire, CurrentMode& message) {
  message = {wire.custom_mode, wire.intended_custom_mode, wire.standard_mode};
}

}  // namespace

std::optional<std::uint8_t> layout_byte(std::uint32_t id) {
  const mavlink_msg_entry_t* const entry = mavlink_get_msg_entry(id);
  if (entry == nullptr) return std::nullopt;
  return entry->crc_extra;
}

std::uint16_t frame_checksum(std::span<const std::byte> bytes, std::uint8_t layout) {
  std::uint16_t checksum =
      crc_calculate(reinterpret_cast<const std::uint8_t*>(bytes.data()), static_cast<std::uint16_t>(bytes.size()));
  crc_accumulate(layout, &checksum);
  return checksum;
}

std::array<std::byte, 6> signature_of(std::span<const std::byte> key, std::span<const std::byte> bytes) {
  mavlink_sha256_ctx context;
  mavlink_sha256_init(&context);
  mavlink_sha256_update(&context, key.data(), static_cast<std::uint32_t>(key.size()));
  mavlink_sha256_update(&context, bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  std::array<std::uint8_t, 6> hash{};
  mavlink_sha256_final_48(&context, hash.data());
  return std::bit_cast<std::array<std::byte, 6>>(hash);
}

template <typename Message>
std::size_t pack(const Message& message, std::span<std::byte> payload) {
  typename Wire<Message>::Struct wire{};
  convert(message, wire);
  std::memcpy(payload.data(), &wire, Wire<Message>::kBytes);
  std::size_t size = Wire<Message>::kBytes;
  while (size > 1 && payload[size - 1] == std::byte{0}) --size;  // a payload has at least one byte
  return size;
}

template <typename Message>
std::optional<Message> decode(const Frame& frame) {
  if (frame.id != Message::kId) return std::nullopt;
  typename Wire<Message>::Struct wire{};
  std::memcpy(&wire, frame.payload.data(), std::min(frame.payload.size(), Wire<Message>::kBytes));
  Message message;
  convert(wire, message);
  return message;
}

#define SWIFTLET_MESSAGE(Message)                                                           \
  template std::size_t pack<Message>(const Message& message, std::span<std::byte> payload); \
  template std::optional<Message> decode<Message>(const Frame& frame)
SWIFTLET_MESSAGE(Heartbeat);
SWIFTLET_MESSAGE(SystemStatus);
SWIFTLET_MESSAGE(ParameterRequest);
SWIFTLET_MESSAGE(ParameterListRequest);
SWIFTLET_MESSAGE(ParameterValue);
SWIFTLET_MESSAGE(ParameterSet);
SWIFTLET_MESSAGE(AttitudeQuaternion);
SWIFTLET_MESSAGE(LocalPositionNed);
SWIFTLET_MESSAGE(CommandInt);
SWIFTLET_MESSAGE(CommandLong);
SWIFTLET_MESSAGE(CommandAck);
SWIFTLET_MESSAGE(SetAttitudeTarget);
SWIFTLET_MESSAGE(SetPositionTarget);
SWIFTLET_MESSAGE(PositionTarget);
SWIFTLET_MESSAGE(TimeSyncMessage);
SWIFTLET_MESSAGE(ExtendedSystemState);
SWIFTLET_MESSAGE(StatusText);
SWIFTLET_MESSAGE(Odometry);
SWIFTLET_MESSAGE(CurrentMode);
#undef SWIFTLET_MESSAGE

}  // namespace swiftlet::mavlink
