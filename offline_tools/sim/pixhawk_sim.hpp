#pragma once
#include <span>
#include <utility>
#include <vector>

#include "sim/fault.hpp"
#include "sim/mavlink_adapter.hpp"
#include "sim/simulation.hpp"
#include "sim/wire.hpp"

namespace swiftlet::tools {

struct PixhawkSimSettings {
  SimulationSettings simulation;
  std::vector<Fault> faults;
  Microseconds link_delay{0};  ///< of each direction
};

/// A vehicle with an autopilot at the far end of a link. The caller owns time and carries the bytes: the same settings,
/// bytes and steps give the same bytes.
class PixhawkSim {
 public:
  explicit PixhawkSim(const PixhawkSimSettings& settings);
  PixhawkSim(const PixhawkSim&) = delete;
  PixhawkSim& operator=(const PixhawkSim&) = delete;

  /// Bytes that the companion sends now; one call is one message where messages get lost.
  void receive(std::span<const std::byte> bytes);
  /// Advances by whole milliseconds; the bytes that reach the companion in that time.
  std::vector<std::byte> step(Microseconds duration = Simulation::kStep);

  [[nodiscard]] Microseconds time() const { return simulation_.time(); }
  [[nodiscard]] const Simulation& simulation() const { return simulation_; }
  /// For what a test or a flight scripts beyond the faults: the pilot, a parameter.
  [[nodiscard]] Simulation& simulation() { return simulation_; }
  [[nodiscard]] const mavlink::CodecCounters& counters() const { return adapter_.counters(); }
  /// Faults that began since the last call, in order.
  std::vector<Fault> take_begun() { return std::exchange(begun_, {}); }

 private:
  void apply_faults();
  void begin(const Fault& fault);
  void end(const Fault& fault);

  PixhawkSimSettings settings_;
  Simulation simulation_;
  MavlinkAdapter adapter_;
  Wire to_companion_;
  Wire to_autopilot_;
  std::vector<Fault> waiting_;
  std::vector<Fault> active_;
  std::vector<Fault> begun_;
};

}  // namespace swiftlet::tools
