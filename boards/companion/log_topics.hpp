#pragma once
#include <array>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include "companion/ulog_writer.hpp"

/// The topics of a flight log: each struct's bytes, without padding at its end, are what its format string says, which
/// is checked here. The names
/// and units of PX4's own topics are PX4's (NED, forward-right-down), so that its tools plot them; each holds the part
/// of PX4's fields that a companion knows. Times are of the companion's clock [us].
namespace swiftlet::companion::topic {

/// The estimate, when it was new; in the map's frame turned to NED.
struct VehicleLocalPosition {
  static constexpr std::uint16_t kId = 0;
  static constexpr std::string_view kFormat =
      "vehicle_local_position:uint64_t timestamp;uint64_t timestamp_sample;float x;float y;float z;float vx;float vy;"
      "float vz;float heading;bool xy_valid;bool z_valid;bool v_xy_valid;bool v_z_valid;";
  std::uint64_t timestamp = 0;
  std::uint64_t timestamp_sample = 0;
  std::array<float, 3> position{};  ///< [m]
  std::array<float, 3> velocity{};  ///< [m/s]
  float heading = 0;                ///< [rad] from north, clockwise
  std::array<bool, 4> valid{};
};

struct VehicleAttitude {
  static constexpr std::uint16_t kId = 1;
  static constexpr std::string_view kFormat =
      "vehicle_attitude:uint64_t timestamp;uint64_t timestamp_sample;float[4] q;";
  std::uint64_t timestamp = 0;
  std::uint64_t timestamp_sample = 0;
  std::array<float, 4> q{};  ///< w x y z
};

struct VehicleAngularVelocity {
  static constexpr std::uint16_t kId = 2;
  static constexpr std::string_view kFormat =
      "vehicle_angular_velocity:uint64_t timestamp;uint64_t timestamp_sample;float[3] xyz;";
  std::uint64_t timestamp = 0;
  std::uint64_t timestamp_sample = 0;
  std::array<float, 3> xyz{};  ///< [rad/s]
};

/// The reference: what is to be tracked, whatever form it is sent in.
struct TrajectorySetpoint {
  static constexpr std::uint16_t kId = 3;
  static constexpr std::string_view kFormat =
      "trajectory_setpoint:uint64_t timestamp;float[3] position;float[3] velocity;float[3] acceleration;float[3] jerk;"
      "float yaw;float yawspeed;";
  std::uint64_t timestamp = 0;
  std::array<float, 3> position{};
  std::array<float, 3> velocity{};
  std::array<float, 3> acceleration{};
  std::array<float, 3> jerk{};
  float yaw = 0;
  float yawspeed = 0;
};

/// As sent, in the form of attitude and thrust.
struct VehicleAttitudeSetpoint {
  static constexpr std::uint16_t kId = 4;
  static constexpr std::string_view kFormat =
      "vehicle_attitude_setpoint:uint64_t timestamp;float yaw_sp_move_rate;float[4] q_d;float[3] thrust_body;";
  std::uint64_t timestamp = 0;
  float yaw_sp_move_rate = 0;
  std::array<float, 4> q_d{};
  std::array<float, 3> thrust_body{};  ///< 0 to 1, upwards negative
};

/// As sent, in the form of body rates and thrust.
struct VehicleRatesSetpoint {
  static constexpr std::uint16_t kId = 5;
  static constexpr std::string_view kFormat =
      "vehicle_rates_setpoint:uint64_t timestamp;float roll;float pitch;float yaw;float[3] thrust_body;";
  std::uint64_t timestamp = 0;
  std::array<float, 3> rates{};  ///< [rad/s]
  std::array<float, 3> thrust_body{};
};

/// Ten times a second, and whenever state, reason or phase change. Enumerations are those of FlightState, Reason,
/// Phase, SetpointForm, Setpoints and mavlink::Mode.
struct Status {
  static constexpr std::uint16_t kId = 6;
  static constexpr std::string_view kFormat =
      "swiftlet_status:uint64_t timestamp;uint64_t received_bytes;uint64_t sent_bytes;int32_t estimate_age;"
      "int32_t link_delay;int32_t plan_latency;uint32_t plan;float tracking_error;float thrust;float hover_thrust;"
      "uint32_t goals_reached;uint32_t goals_waiting;uint32_t plans_discarded;uint32_t deadline_misses;"
      "uint32_t lost_frames;uint32_t bad_checksums;uint32_t unsent_frames;uint8_t state;uint8_t reason;uint8_t phase;"
      "uint8_t form;uint8_t setpoints;uint8_t mode;bool armed;bool aligned;";
  std::uint64_t timestamp = 0;
  std::uint64_t received_bytes = 0;
  std::uint64_t sent_bytes = 0;
  std::int32_t estimate_age = 0;  ///< [us]; -1 without an estimate
  std::int32_t link_delay = 0;    ///< [us]
  std::int32_t plan_latency = 0;  ///< [us] from trigger to commitment
  std::uint32_t plan = 0;
  float tracking_error = 0;  ///< [m]
  float thrust = 0;          ///< 0 to 1
  float hover_thrust = 0;
  std::uint32_t goals_reached = 0;
  std::uint32_t goals_waiting = 0;
  std::uint32_t plans_discarded = 0;
  std::uint32_t deadline_misses = 0;
  std::uint32_t lost_frames = 0;
  std::uint32_t bad_checksums = 0;
  std::uint32_t unsent_frames = 0;
  std::uint8_t state = 0;
  std::uint8_t reason = 0;
  std::uint8_t phase = 0;
  std::uint8_t form = 0;
  std::uint8_t setpoints = 0;
  std::uint8_t mode = 0;
  bool armed = false;
  bool aligned = false;
};

/// A plan, when it was committed. Frame W.
struct Plan {
  static constexpr std::uint16_t kId = 7;
  static constexpr std::string_view kFormat =
      "swiftlet_plan:uint64_t timestamp;uint64_t start;uint32_t id;uint32_t segments;float duration;int32_t latency;"
      "float[3] from;float[3] goal;float box_margin;uint32_t map_crc32;uint32_t status;";
  std::uint64_t timestamp = 0;
  std::uint64_t start = 0;  ///< [us] from when on it is flown
  std::uint32_t id = 0;
  std::uint32_t segments = 0;
  float duration = 0;           ///< [s]
  std::int32_t latency = 0;     ///< [us] from trigger to commitment
  std::array<float, 3> from{};  ///< [m]
  std::array<float, 3> goal{};  ///< [m]
  float box_margin = 0;         ///< [m] of its certificate
  std::uint32_t map_crc32 = 0;  ///< of the map that it was made in
  std::uint32_t status = 0;     ///< of swiftlet::Status: 0 optimal, else a fallback
};

/// One segment of the plan before it, with the box that it lies in. Frame W.
struct PlanSegment {
  static constexpr std::uint16_t kId = 8;
  static constexpr std::string_view kFormat =
      "swiftlet_plan_segment:uint64_t timestamp;uint32_t plan;uint32_t index;float duration;float[3] low;float[3] high;"
      "";
  std::uint64_t timestamp = 0;
  std::uint32_t plan = 0;
  std::uint32_t index = 0;
  float duration = 0;          ///< [s]
  std::array<float, 3> low{};  ///< [m]
  std::array<float, 3> high{};
};

/// A piece of the stream of everything that entered the companion: flight_log.hpp.
struct Input {
  static constexpr std::uint16_t kId = 9;
  static constexpr std::string_view kFormat = "swiftlet_input:uint64_t timestamp;uint8_t[120] bytes;";
  std::uint64_t timestamp = 0;
  std::array<std::byte, 120> bytes{};
};

inline constexpr std::uint16_t kCount = 10;

/// The name in front of the colon of a topic's format.
template <typename Topic>
inline constexpr std::string_view kName = Topic::kFormat.substr(0, Topic::kFormat.find(':'));

template <typename Topic>
constexpr bool is_as_its_format_says() {
  constexpr std::size_t kBytes = ulog_format_size(Topic::kFormat);
  return std::is_trivially_copyable_v<Topic> && kBytes > 0 && kBytes <= sizeof(Topic) &&
         sizeof(Topic) - kBytes < alignof(Topic) && Topic::kId < kCount;
}
static_assert(is_as_its_format_says<VehicleLocalPosition>());
static_assert(is_as_its_format_says<VehicleAttitude>());
static_assert(is_as_its_format_says<VehicleAngularVelocity>());
static_assert(is_as_its_format_says<TrajectorySetpoint>());
static_assert(is_as_its_format_says<VehicleAttitudeSetpoint>());
static_assert(is_as_its_format_says<VehicleRatesSetpoint>());
static_assert(is_as_its_format_says<Status>());
static_assert(is_as_its_format_says<Plan>());
static_assert(is_as_its_format_says<PlanSegment>());
static_assert(is_as_its_format_says<Input>());

}  // namespace swiftlet::companion::topic
