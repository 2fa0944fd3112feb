#pragma once
#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/flight_control.hpp"

namespace swiftlet::tools {

enum class FlightMode : std::uint8_t { kManual, kPosctl, kOffboard, kLand, kLoiter };
const char* describe(FlightMode mode);  ///< "OFFBOARD", "AUTO.LAND"

/// MAV_RESULT.
enum class Verdict : std::uint8_t { kAccepted = 0, kTemporarilyRejected = 1, kDenied = 2, kUnsupported = 3 };

/// MAV_STATE, as far as PX4 uses it.
enum class VehicleStatus : std::uint8_t { kNotReady = 0, kReady = 3, kArmed = 4, kFailsafe = 5 };

/// A text for people; PX4 sends it to ground stations alone.
struct Announcement {
  std::uint8_t severity;  ///< MAV_SEVERITY: 2 critical, 4 warning, 6 information
  std::string text;
};

/// A parameter under its PX4 name.
struct Parameter {
  std::string_view name;
  double value;
  bool integer;
};

enum class ParameterIndex : std::uint8_t {
  kOffboardLossTime,    ///< COM_OF_LOSS_T [s]
  kOffboardLossAction,  ///< COM_OBL_RC_ACT: 0 position mode, 4 land, 5 hold
  kLandDisarmTime,      ///< COM_DISARM_LAND [s]
  kIdleDisarmTime,      ///< COM_DISARM_PRFLT [s]
  kSpoolUpTime,         ///< COM_SPOOLUP_TIME [s]
  kTakeoffRampTime,     ///< MPC_TKO_RAMP_T [s]
  kHoverThrust,         ///< MPC_THR_HOVER
  kXyP,                 ///< MPC_XY_P
  kXyVelocityP,         ///< MPC_XY_VEL_P_ACC
  kXyVelocityI,         ///< MPC_XY_VEL_I_ACC
  kSystemId,            ///< MAV_SYS_ID
  kCount,
};

/// What PX4 v1.16 was seen to do, as far as a companion can tell: modes, arming, OFFBOARD and its loss, take-off and
/// landing. Knows no wire and no clock; `now` [s] counts from its boot and never goes back.
class Autopilot {
 public:
  Autopilot(const VehicleModel& model, double hover_thrust);

  // From the companion.
  void set_target(const PositionSetpoint& target, double now);
  void set_target(const AttitudeSetpoint& target, double now);
  /// The verdict of the commander, which is the second acknowledgement on the wire.
  Verdict set_mode(FlightMode mode, double now);
  /// `forced` is the magic number 21196: no checks, in the air as well.
  Verdict arm(bool forced, double now);
  Verdict disarm(bool forced);

  // From the pilot, whose transmitter is on from the first call on.
  void take_over(FlightMode mode);
  void move_sticks(const Vector3& velocity) { stick_velocity_ = velocity; }  ///< [m/s] frame L

  /// One millisecond: what the motors shall do. `contact`: the legs feel the ground.
  MotorCommands step(const Estimate& estimate, bool contact, double now);

  [[nodiscard]] bool armed() const { return armed_; }
  [[nodiscard]] FlightMode mode() const { return mode_; }
  [[nodiscard]] FlightMode intended_mode() const { return intended_; }  ///< what the last command or stick asked for
  [[nodiscard]] bool in_failsafe() const { return failsafe_; }
  [[nodiscard]] bool in_air() const { return in_air_; }  ///< the landed state; true about a second before lift-off
  /// The health bit of SYS_STATUS: could it be armed in the mode that it is in?
  [[nodiscard]] bool prearm_ok() const { return prearm_ok_; }
  [[nodiscard]] VehicleStatus system_status() const;
  [[nodiscard]] const std::optional<PositionSetpoint>& position_target() const { return position_target_; }

  [[nodiscard]] std::span<const Parameter> parameters() const { return parameters_; }
  [[nodiscard]] double parameter(ParameterIndex index) const {
    return parameters_[static_cast<std::size_t>(index)].value;
  }
  void set_parameter(ParameterIndex index, double value);

  /// The texts since the last call.
  std::vector<Announcement> take_texts() { return std::exchange(texts_, {}); }

 private:
  enum class Takeoff : std::uint8_t { kDisarmed, kSpoolUp, kReady, kRamp, kFlight };

  void note_target(double now);
  [[nodiscard]] bool has_stream(double now, double since) const;
  [[nodiscard]] bool can_run(FlightMode mode, double now) const;
  void update_mode(double now);
  void enter(FlightMode mode);
  void enter_failsafe();
  void update_takeoff(const Estimate& estimate, double now);
  void update_landing(bool contact, double now);
  void disarm_when_idle(double now);
  void set_disarmed(const char* why);
  [[nodiscard]] bool wants_up(const Estimate& estimate) const;
  [[nodiscard]] bool is_landing() const;
  [[nodiscard]] double climb_limit(double now) const;
  [[nodiscard]] double landing_speed(const Estimate& estimate) const;
  PositionSetpoint hold_target(const Estimate& estimate);
  void update_targets(const Estimate& estimate, double now);
  void say(std::uint8_t severity, std::string text) { texts_.push_back({severity, std::move(text)}); }

  FlightControl control_;
  std::array<Parameter, static_cast<std::size_t>(ParameterIndex::kCount)> parameters_;
  std::vector<Announcement> texts_;

  bool armed_ = false;
  double armed_at_ = 0;
  FlightMode mode_ = FlightMode::kLoiter;
  FlightMode intended_ = FlightMode::kLoiter;
  FlightMode before_landing_ = FlightMode::kLoiter;
  bool failsafe_ = false;
  bool prearm_ok_ = false;
  double prearm_at_ = -1;
  bool pilot_ = false;

  struct TimedTarget {
    double at;
    PositionSetpoint target;
  };
  std::deque<TimedTarget> delayed_targets_;  ///< on their way to the position loop, oldest first
  std::optional<PositionSetpoint> position_target_;
  std::optional<AttitudeSetpoint> attitude_target_;
  double last_target_at_ = -1e9;
  double stream_since_ = 0;

  Takeoff takeoff_ = Takeoff::kDisarmed;
  double ramp_since_ = 0;
  bool in_air_ = false;
  bool descends_ = false;  ///< asked to by a position or velocity
  bool settles_ = false;   ///< on its legs and meant to be
  double settled_at_ = 0;
  double landed_at_ = -1;

  std::optional<PositionSetpoint> hold_;  ///< where a mode of its own keeps the vehicle
  double hold_ground_ = 0;                ///< [m] height at arming
  Vector3 stick_velocity_ = Vector3::Zero();
  AttitudeSetpoint attitude_;  ///< what the attitude loop follows
  Vector3 rate_ = Vector3::Zero();
  std::uint32_t ticks_ = 0;
};

}  // namespace swiftlet::tools
