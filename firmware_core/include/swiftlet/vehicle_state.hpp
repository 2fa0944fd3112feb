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

/// How a vehicle answers a commanded acceleration.
struct PredictorSettings {
  Real response_time = Real(0.1);  ///< [s] lag of the attitude loop, first order; 0: at once
  TimeUs longest = 300'000;        ///< [us] horizon of a prediction; beyond it the state stays
};

/// Moves a measured state forward over the delays of the link, with the accelerations that were commanded meanwhile
/// (the measurement does not know them yet). Keeps the last kCommands commands.
class StatePredictor {
 public:
  static constexpr std::size_t kCommands = 64;

  explicit StatePredictor(const PredictorSettings& settings) : settings_(settings) {}

  /// `commanded` [m/s^2] (frame W, without gravity) is in force from `time` on: when it was sent, plus the link's
  /// delay. `compensation` is the share of it that drag and disturbances take, so that the vehicle flies the rest.
  /// Times that do not ascend, and numbers that are not finite, are ignored.
  void record(TimeUs time, const Vector3& commanded, const Vector3& compensation);

  /// The state at `target`: position and velocity by the recorded accelerations through the response lag, attitude by
  /// its rates. A target before the measurement, or an unusable state, returns `measured` as it is.
  [[nodiscard]] VehicleState predict(const VehicleState& measured, TimeUs target) const;

  /// Forgets all commands: after a jump of the clock or when control was not ours.
  void reset() { count_ = 0; }

 private:
  struct Command {
    TimeUs time = 0;
    Vector3 commanded = Vector3::Zero();
    Vector3 compensation = Vector3::Zero();
  };
  [[nodiscard]] const Command& command(std::size_t age) const {
    return commands_[(next_ + kCommands - 1 - age) % kCommands];
  }

  PredictorSettings settings_;
  std::array<Command, kCommands> commands_;
  std::size_t next_ = 0;
  std::size_t count_ = 0;
};

}  // namespace swiftlet
