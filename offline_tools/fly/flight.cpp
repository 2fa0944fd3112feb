#include "fly/flight.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <memory>
#include <mutex>
#include <numbers>
#include <thread>

#include "flight/renamed_map.hpp"
#include "fly/flight_observer.hpp"
#include "sim/lockstep_uart.hpp"
#include "swiftlet/hal/fake_clock.hpp"
#include "swiftlet/hal/monotonic_clock.hpp"
#include "swiftlet/hal/posix_uart.hpp"

namespace swiftlet::tools {
namespace {

constexpr Microseconds kPeriod{10'000};  // of the companion's steps
constexpr std::uint32_t kBaud = 921'600;

double seconds(Microseconds time) { return std::chrono::duration<double>(time).count(); }

/// Where the autopilot's local frame lies in the map is nothing that the companion may know: anywhere, turned anyhow.
void hide_frame(SimulationSettings& simulation) {
  Noise noise(SplitMix64(simulation.seed * 16 + 5).next());
  constexpr double kFar = 20;  // [m]
  const auto share = [&] { return 2 * noise.uniform() - 1; };
  simulation.estimator.origin = simulation.start + kFar * Vector3{share(), share(), share() / 10};
  simulation.estimator.heading = std::numbers::pi * share();
}

PixhawkSimSettings complete(const FlightRequest& request, const Floor& floor, const std::vector<Box>& obstacles) {
  PixhawkSimSettings sim = request.sim;
  sim.simulation.start = floor.pad();
  sim.simulation.start_yaw = request.yaw;
  sim.simulation.obstacles = obstacles;
  hide_frame(sim.simulation);
  for (const FlightFault& fault : request.faults) {
    if (const Fault* far = std::get_if<Fault>(&fault)) sim.faults.push_back(*far);
  }
  return sim;
}

companion::Settings complete(const FlightRequest& request, const Floor& floor) {
  companion::Settings settings = request.companion;
  settings.start = floor.pad();
  settings.start_yaw = request.yaw;
  settings.takeoff.height = request.start.z() - floor.pad().z();
  settings.engage_at_start = true;
  settings.land_at_end = true;
  return settings;
}

/// The companion with its operator and everything that can go wrong on its side of the line.
class Captain {
 public:
  Captain(const FlightRequest& request, const FlightWorld& world, const Floor& floor, hal::Uart& uart,
          hal::Clock& clock)
      : request_(request),
        world_(world),
        watch_(uart, clock),
        companion_(complete(request, floor), world.map, world.memory, {watch_, world.planner, world.log}),
        observer_(request, world.planner) {
    for (const FlightFault& fault : request.faults) {
      if (const CompanionFault* near = std::get_if<CompanionFault>(&fault)) waiting_.push_back(*near);
    }
  }

  /// One turn at time `now` of the simulation, with the vehicle's true state then and its least clearance so far [m].
  void step(Microseconds now, const RigidState& truth, double clearance) {
    const double t = seconds(now);
    begin_faults(t);
    while (goals_given_ < request_.goals.size() && companion_.add_goal(request_.goals[goals_given_])) ++goals_given_;
    watch_.begin_step(now + clock_offset_);
    if (t >= asleep_until_) companion_.step(now + clock_offset_);
    observer_.see(t, companion_, truth, watch_);
    observer_.see_clearance(clearance);
  }

  void note_fault(const Fault& fault, double t) { observer_.note_fault(fault, t); }
  [[nodiscard]] bool measures() const { return observer_.measures(); }
  [[nodiscard]] bool finished() const { return observer_.finished(); }
  FlightReport report() { return observer_.report(companion_, watch_); }

 private:
  void begin_faults(double t) {
    for (const CompanionFault& fault : waiting_) {
      if (t >= fault.at) begin(fault, t);
    }
    std::erase_if(waiting_, [t](const CompanionFault& fault) { return t >= fault.at; });
  }

  void begin(const CompanionFault& fault, double t) {
    observer_.note_fault(fault, t);
    switch (fault.kind) {
      case CompanionFaultKind::kSleep:
        asleep_until_ = t + fault.duration;
        return;
      case CompanionFaultKind::kClockStep:
        clock_offset_ += kClockStep;
        return;
      case CompanionFaultKind::kMapReplaced:
        other_map_ = std::make_unique<RenamedMap>(world_.map);
        (void)companion_.replace_map(other_map_->view());
        return;
      case CompanionFaultKind::kStorageFull:
        if (world_.storage != nullptr) world_.storage->fill();
        return;
    }
  }

  const FlightRequest& request_;
  const FlightWorld& world_;
  SetpointWatch watch_;
  companion::Companion companion_;
  FlightObserver observer_;
  std::vector<CompanionFault> waiting_;
  std::unique_ptr<RenamedMap> other_map_;
  std::size_t goals_given_ = 0;
  double asleep_until_ = 0;
  Microseconds clock_offset_{0};
};

FlightReport fly_in_lockstep(const FlightRequest& request, const FlightWorld& world, Floor& floor) {
  PixhawkSim sim(complete(request, floor, world.obstacles));
  sim.simulation().measure_clearance(false);
  LockstepUart uart(sim);
  hal::FakeClock clock;
  const auto captain = std::make_unique<Captain>(request, world, floor, uart, clock);
  while (!captain->finished()) {
    const RigidState& truth = sim.simulation().truth();
    sim.simulation().set_ground(floor.below(truth.position));
    clock.advance(kPeriod);
    uart.advance(kPeriod);
    for (const Fault& fault : sim.take_begun()) captain->note_fault(fault, fault.at);
    captain->step(sim.time(), truth, sim.simulation().clearance());
    sim.simulation().measure_clearance(captain->measures());
    if (captain->measures()) floor.remove_pad();
  }
  return captain->report();
}

/// The simulation on its own thread, a millisecond at a time with the wall's clock, at the controlling end of a
/// pseudo-terminal.
class RealTimeSim {
 public:
  using Clock = std::chrono::steady_clock;

  RealTimeSim(const PixhawkSimSettings& settings, Floor& floor, hal::PseudoTerminal& pty, Clock::time_point start)
      : sim_(settings), floor_(floor), pty_(pty), start_(start) {
    sim_.simulation().measure_clearance(false);
    thread_ = std::thread([this] { run(); });
  }
  ~RealTimeSim() {
    stopped_ = true;
    thread_.join();
  }
  RealTimeSim(const RealTimeSim&) = delete;
  RealTimeSim& operator=(const RealTimeSim&) = delete;

  /// The true state at `now`; what has happened since the last step by constant velocity.
  RigidState truth(Microseconds now) {
    const std::lock_guard lock(mutex_);
    RigidState state = sim_.simulation().truth();
    state.position += state.velocity * seconds(now - sim_.time());
    return state;
  }
  std::vector<Fault> take_begun() {
    const std::lock_guard lock(mutex_);
    return sim_.take_begun();
  }
  void measure_clearance(bool on) {
    const std::lock_guard lock(mutex_);
    sim_.simulation().measure_clearance(on);
    if (on) floor_.remove_pad();
  }
  double clearance() {
    const std::lock_guard lock(mutex_);
    return sim_.simulation().clearance();
  }
  double lag_max() {
    const std::lock_guard lock(mutex_);
    return lag_max_;
  }

 private:
  void run() {
    std::array<std::byte, 4096> buffer{};
    for (Microseconds next = Simulation::kStep; !stopped_; next += Simulation::kStep) {
      std::this_thread::sleep_until(start_ + next);
      const std::lock_guard lock(mutex_);
      for (std::size_t count = pty_.read(buffer); count > 0; count = pty_.read(buffer)) {
        sim_.receive(std::span(buffer).first(count));
      }
      sim_.simulation().set_ground(floor_.below(sim_.simulation().truth().position));
      (void)pty_.write(sim_.step());  // what the line cannot take is lost, as on a real one
      lag_max_ = std::max(lag_max_, std::chrono::duration<double>(Clock::now() - start_ - next).count());
    }
  }

  PixhawkSim sim_;
  Floor& floor_;
  hal::PseudoTerminal& pty_;
  Clock::time_point start_;
  std::mutex mutex_;
  std::atomic<bool> stopped_ = false;
  double lag_max_ = 0;
  std::thread thread_;
};

Expected<FlightReport> fly_in_real_time(const FlightRequest& request, const FlightWorld& world, Floor& floor) {
  hal::PseudoTerminal pty;
  hal::SerialPort port;
  if (!pty.open() || !port.open(pty.peer_path().c_str(), kBaud)) {
    return bad_file(std::string("no pseudo-terminal can be had: ") + std::strerror(errno));
  }
  hal::MonotonicClock clock;
  const auto captain = std::make_unique<Captain>(request, world, floor, port, clock);
  const RealTimeSim::Clock::time_point start = RealTimeSim::Clock::now();
  const auto sim = std::make_unique<RealTimeSim>(complete(request, floor, world.obstacles), floor, pty, start);
  for (Microseconds next = kPeriod; !captain->finished(); next += kPeriod) {
    std::this_thread::sleep_until(start + next);
    const auto now = std::chrono::duration_cast<Microseconds>(RealTimeSim::Clock::now() - start);
    for (const Fault& fault : sim->take_begun()) captain->note_fault(fault, fault.at);
    captain->step(now, sim->truth(now), sim->clearance());
    sim->measure_clearance(captain->measures());
  }
  FlightReport report = captain->report();
  report.lag_max = sim->lag_max();
  return report;
}

}  // namespace

companion::Settings settings_of(const FlightRequest& request, const BoxGraphView& map,
                                const std::vector<Box>& obstacles) {
  return complete(request, Floor(map, obstacles, request.start));
}

Expected<FlightReport> fly(const FlightRequest& request, const FlightWorld& world) {
  Floor floor(world.map, world.obstacles, request.start);
  return request.in_process ? fly_in_lockstep(request, world, floor) : fly_in_real_time(request, world, floor);
}

}  // namespace swiftlet::tools
