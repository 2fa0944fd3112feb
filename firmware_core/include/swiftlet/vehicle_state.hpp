#pragma once
#include <array>
#include <cstddef>

#include "swiftlet/flatness.hpp"
#include "swiftlet/flight_time.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// What the autopilot's estimator says, at the instant for which it is true (not that of its arrival).
struct VehicleState {
  TimeUs time = 0;
  Vector3 position = Vector3::Zero();    ///< [m] p_WB
  Vector3 velocity = Vector3::Zero();    ///< [m/s] frame W
  Quaternion attitude{1, 0, 0, 0};       ///< q_WB
  Vector3 body_rates = Vector3::Zero();  ///< [rad/s] omega_WB_B, in the body frame
};

/// Finite, of sane size (kLargestInput), and the quaternion of length 1 to ten percent.
bool is_usable(const VehicleState& state);

/// How a vehicle answers a commanded acceleration, and how quickly a disturbance is learnt.
struct PredictorSettings {
  Real response_time = Real(0.2);     ///< [s] lag of the attitude loop, first order; 0: at once
  Real thrust_time = Real(0.05);      ///< [s] lag of the motors, first order
  Real disturbance_time = Real(0.1);  ///< [s] of the filter that learns the disturbance; > 0
  Real disturbance_max = 4;           ///< [m/s^2] per axis
  TimeUs longest = 300'000;           ///< [us] horizon of a prediction; beyond it the state stays
};

/// Knows what was commanded, and from that two things: the disturbance, which is what the measured velocity changes by
/// beyond thrust and gravity (wind, drag, a tilt or a hover thrust that is believed wrong), and the state at a later
/// instant, moved on by the commands that the measurement does not know yet. Keeps the last kCommands commands.
class StatePredictor {
 public:
  static constexpr std::size_t kCommands = 64;

  explicit StatePredictor(const PredictorSettings& settings) : settings_(settings) {}

  /// `commanded` [m/s^2] (frame W, without gravity) and the specific thrust [m/s^2] are in force from `time` on: when
  /// they were sent, plus the link's delay. Times that do not ascend, and numbers that are not finite, are ignored.
  void record(TimeUs time, const Vector3& commanded, Real thrust);

  /// Learns the disturbance from the newest measurement, in flight only: on the ground its reaction would be one. A
  /// state that is unusable or no newer than the last is ignored; after a gap learning starts afresh with this one.
  void learn(const VehicleState& measured);

  /// [m/s^2] frame W, within disturbance_max; what is to be commanded in addition is its negative.
  [[nodiscard]] const Vector3& disturbance() const { return disturbance_; }

  /// The state at `target`: position and velocity by the recorded accelerations through the response lag and the
  /// disturbance, attitude by its rates. A target before the measurement, or an unusable state, returns `measured`.
  [[nodiscard]] VehicleState predict(const VehicleState& measured, TimeUs target) const;

  /// Forgets all commands and the disturbance: after a jump of the clock or when control was not ours.
  void reset();

 private:
  struct Command {
    TimeUs time = 0;
    Vector3 commanded = Vector3::Zero();
    Real thrust = 0;
  };
  [[nodiscard]] const Command& command(std::size_t age) const {
    return commands_[(next_ + kCommands - 1 - age) % kCommands];
  }
  [[nodiscard]] std::size_t age_in_force(TimeUs time) const;
  Real mean_thrust(TimeUs from, TimeUs to);

  PredictorSettings settings_;
  std::array<Command, kCommands> commands_;
  std::size_t next_ = 0;
  std::size_t count_ = 0;

  bool learns_ = false;  // last_ holds, and thrust_ is that of its instant
  VehicleState last_;
  Real thrust_ = kGravity;  // [m/s^2] after the motors' lag
  Vector3 disturbance_ = Vector3::Zero();
};

}  // namespace swiftlet
