#include "sim/pixhawk_sim.hpp"

#include <algorithm>

namespace swiftlet::tools {
namespace {

constexpr double kCorruptShare = 0.01;
constexpr double kLossShare = 0.3;
const Vector3 kPositionJump{1, 0, 0};  // [m]
constexpr Microseconds kClockJump = std::chrono::seconds(5);

double seconds(Microseconds time) { return std::chrono::duration<double>(time).count(); }

}  // namespace

PixhawkSim::PixhawkSim(const PixhawkSimSettings& settings)
    : settings_(settings),
      simulation_(settings.simulation),
      adapter_(simulation_),
      to_companion_(settings.link_delay, SplitMix64(settings.simulation.seed * 16 + 2).next()),
      to_autopilot_(settings.link_delay, SplitMix64(settings.simulation.seed * 16 + 3).next()),
      waiting_(settings.faults) {}

void PixhawkSim::receive(std::span<const std::byte> bytes) { to_autopilot_.send(bytes, time()); }

std::vector<std::byte> PixhawkSim::step(Microseconds duration) {
  std::vector<std::byte> arrived;
  for (Microseconds done{0}; done < duration; done += Simulation::kStep) {
    apply_faults();
    const std::vector<std::byte> bytes = to_autopilot_.receive(time());
    if (!simulation_.booting()) adapter_.receive(bytes);
    simulation_.step();
    if (!simulation_.booting()) {
      for (const MavlinkAdapter::Message& message : adapter_.step()) to_companion_.send(message, time());
    }
    const std::vector<std::byte> now = to_companion_.receive(time());
    arrived.insert(arrived.end(), now.begin(), now.end());
  }
  return arrived;
}

void PixhawkSim::apply_faults() {
  const double now = seconds(time());
  const auto over = [now](const Fault& fault) { return now >= fault.at + fault.duration; };
  for (const Fault& fault : active_) {
    if (over(fault)) end(fault);
  }
  std::erase_if(active_, over);
  for (const Fault& fault : waiting_) {
    if (now < fault.at) continue;
    begin(fault);
    active_.push_back(fault);
    begun_.push_back(fault);
  }
  std::erase_if(waiting_, [now](const Fault& fault) { return now >= fault.at; });

  WireFaults wire;
  OdometryFault odometry = OdometryFault::kNone;
  bool starves = false;
  for (const Fault& fault : active_) {
    if (fault.kind == FaultKind::kCorrupt) wire.corrupt = kCorruptShare;
    if (fault.kind == FaultKind::kLoss) wire.loss = kLossShare;
    if (fault.kind == FaultKind::kStall) wire.stalled = true;
    if (fault.kind == FaultKind::kCut) wire.cut = true;
    if (fault.kind == FaultKind::kStarve) starves = true;
    if (fault.kind == FaultKind::kOdometryStale) odometry = OdometryFault::kStale;
    if (fault.kind == FaultKind::kOdometryNan) odometry = OdometryFault::kNan;
  }
  to_companion_.set_faults(wire);
  to_autopilot_.set_faults(wire);
  adapter_.set_odometry_fault(odometry);
  adapter_.drop_setpoints(starves);
}

void PixhawkSim::begin(const Fault& fault) {
  switch (fault.kind) {
    case FaultKind::kPositionJump:
      return simulation_.estimator().jump(kPositionJump);
    case FaultKind::kClockJump:
      return adapter_.set_clock_offset(kClockJump);
    case FaultKind::kPilot:
      return simulation_.autopilot().take_over(FlightMode::kPosctl);
    case FaultKind::kRestart:
      simulation_.restart_autopilot(
          std::chrono::round<std::chrono::milliseconds>(std::chrono::duration<double>(std::min(fault.duration, 1e6))));
      adapter_.set_clock_offset(Microseconds{0});
      return adapter_.reset();
    default:
      return;
  }
}

void PixhawkSim::end(const Fault& fault) {
  if (fault.kind == FaultKind::kPilot) simulation_.autopilot().take_over(FlightMode::kOffboard);
}

}  // namespace swiftlet::tools
