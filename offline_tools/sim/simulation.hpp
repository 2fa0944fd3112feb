#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "sim/autopilot.hpp"
#include "sim/clearance_meter.hpp"
#include "sim/wind.hpp"

namespace swiftlet::tools {

using Microseconds = std::chrono::microseconds;

struct SimulationSettings {
  VehicleModel vehicle;
  double hover_thrust = 0.5;  ///< MPC_THR_HOVER; need not be the vehicle's true one
  WindSettings wind;
  EstimatorSettings estimator;
  Vector3 start = Vector3::Zero();  ///< [m] frame W; the ground is level at this height
  double start_yaw = 0;             ///< [rad] from east
  std::vector<Box> obstacles;       ///< frame W
  std::uint64_t seed = 1;
};

/// Vehicle, air, estimator and autopilot, a millisecond at a time. The same settings and calls give the same flight.
class Simulation {
 public:
  explicit Simulation(const SimulationSettings& settings);

  static constexpr Microseconds kStep{1000};
  void step();

  [[nodiscard]] Microseconds time() const { return time_; }  ///< since the start
  /// Since the autopilot booted.
  [[nodiscard]] Microseconds boot_time() const { return time_ - booted_at_; }
  [[nodiscard]] double now() const { return std::chrono::duration<double>(boot_time()).count(); }

  [[nodiscard]] const RigidState& truth() const { return quadrotor_.state(); }
  [[nodiscard]] const Quadrotor& quadrotor() const { return quadrotor_; }
  [[nodiscard]] const Estimate& estimate() const { return estimator_.estimate(); }
  [[nodiscard]] Estimator& estimator() { return estimator_; }
  [[nodiscard]] Autopilot& autopilot() { return autopilot_; }
  [[nodiscard]] const Autopilot& autopilot() const { return autopilot_; }

  /// The autopilot reboots, which takes `duration`: until then the motors are off; parameters survive.
  void restart_autopilot(Microseconds duration);
  [[nodiscard]] bool booting() const { return time_ < booted_at_; }

  /// The ground's height where the vehicle is now [m]; no change while it stands.
  void set_ground(double height) { quadrotor_.set_ground(height); }

  /// The least distance of the vehicle's centre to an obstacle is measured between these calls.
  void measure_clearance(bool on) { measures_clearance_ = on; }
  [[nodiscard]] double clearance() const { return clearance_.least(); }  ///< [m]

 private:
  SimulationSettings settings_;
  Quadrotor quadrotor_;
  Wind wind_;
  Estimator estimator_;
  Autopilot autopilot_;
  ClearanceMeter clearance_;
  bool measures_clearance_ = true;
  Microseconds time_{0};
  Microseconds booted_at_{0};
};

}  // namespace swiftlet::tools
