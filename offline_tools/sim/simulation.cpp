#include "sim/simulation.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kSeconds = std::chrono::duration<double>(Simulation::kStep).count();

/// Independent numbers for each source of disturbance: turning one off leaves the others as they were.
std::uint64_t seed_of(std::uint64_t seed, std::uint64_t source) { return SplitMix64(seed * 16 + source).next(); }

}  // namespace

Simulation::Simulation(const SimulationSettings& settings)
    : settings_(settings),
      quadrotor_(settings.vehicle, settings.start, settings.start_yaw),
      wind_(settings.wind, seed_of(settings.seed, 0)),
      estimator_(settings.estimator, seed_of(settings.seed, 1)),
      autopilot_(settings.vehicle, settings.hover_thrust),
      clearance_(settings.obstacles) {
  estimator_.step(kSeconds, quadrotor_.state(), false);
}

void Simulation::step() {
  const MotorCommands motors =
      booting() ? MotorCommands{} : autopilot_.step(estimator_.estimate(), quadrotor_.on_ground(), now());
  wind_.step(kSeconds);
  quadrotor_.step(kSeconds, motors, wind_.velocity());
  time_ += kStep;
  estimator_.step(kSeconds, quadrotor_.state(), autopilot_.armed());
  if (measures_clearance_) clearance_.visit(quadrotor_.state().position);
}

void Simulation::restart_autopilot(Microseconds duration) {
  Autopilot fresh(settings_.vehicle, settings_.hover_thrust);
  for (std::size_t i = 0; i < fresh.parameters().size(); ++i) {
    fresh.set_parameter(static_cast<ParameterIndex>(i), autopilot_.parameters()[i].value);
  }
  autopilot_ = fresh;
  booted_at_ = time_ + duration;
}

}  // namespace swiftlet::tools
