// The companion in closed loop with the simulated autopilot, in lock-step.
#include "companion/companion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "map/map_builder.hpp"
#include "map/voxel_map.hpp"
#include "sim/lockstep_uart.hpp"
#include "world/worlds.hpp"

namespace swiftlet::companion {
namespace {

using std::chrono::milliseconds;
using tools::LockstepUart;
using tools::PixhawkSim;
using tools::PixhawkSimSettings;

constexpr Capacity kCapacity{.segments = 128, .search_nodes = 16'384};
const Vector3 kStart{0.48, 0.48, 0};

std::vector<std::byte> classroom_blob(double radius) {
  const std::string bt = tools::to_bt(tools::make_classroom(1).grid);
  const auto voxels = tools::parse_octree("classroom.bt", std::as_bytes(std::span(bt)));
  tools::MapBuildOptions options;
  options.radius = radius;
  return tools::build_map(*voxels, "classroom.bt", options, [](std::string_view, double) {})->blob;
}

const BoxGraphView& classroom() {
  static const std::vector<std::byte> blob = classroom_blob(0.3);
  static const BoxGraphView view = *BoxGraphView::open(blob);
  return view;
}

Settings usual_settings() {
  Settings settings;
  settings.start = kStart;
  settings.start_yaw = 0.4;
  settings.margins.vehicle_radius = 0.1;
  settings.margins.map_error = 0.03;
  settings.takeoff.height = 0.8;
  return settings;
}

PixhawkSimSettings usual_sim() {
  PixhawkSimSettings sim;
  sim.simulation.start = kStart;
  sim.simulation.start_yaw = 0.4;
  sim.simulation.estimator.origin = {10, 20, 1};
  sim.simulation.estimator.heading = 2;
  sim.link_delay = milliseconds(5);
  return sim;
}

/// Companion, simulated vehicle and the operator.
class Rig {
 public:
  explicit Rig(const Settings& settings = usual_settings(), const PixhawkSimSettings& sim_settings = usual_sim(),
               const BoxGraphView& map = classroom(), std::uint32_t plan_steps = 1)
      : sim(sim_settings),
        uart(sim),
        worker(planner_memory_->spans(), plan_steps),
        companion(settings, map, memory_->memory(), {uart, worker}) {}

 private:
  std::unique_ptr<PlannerStorage<kCapacity>> planner_memory_ = std::make_unique<PlannerStorage<kCapacity>>();
  std::unique_ptr<CompanionStorage<kCapacity>> memory_ = std::make_unique<CompanionStorage<kCapacity>>();

 public:
  PixhawkSim sim;
  LockstepUart uart;
  InlineWorker worker;
  Companion companion;
  double worst_error = 0;  // [m] reference to truth, in the mission
  double square_sum = 0;
  int samples = 0;

  void step() {
    uart.advance(milliseconds(10));
    companion.step(sim.time());
    const Telemetry& t = companion.telemetry();
    if (t.phase != Phase::kMission) return;
    const double error = (t.reference.sample.position - sim.simulation().truth().position).norm();
    worst_error = std::max(worst_error, error);
    square_sum += error * error;
    ++samples;
  }
  void run(double seconds) {
    for (int i = 0; i < std::lround(seconds * 100); ++i) step();
  }
  /// Until `condition`, at most `seconds`; whether it came.
  template <typename Condition>
  bool run_until(double seconds, const Condition& condition) {
    for (int i = 0; i < std::lround(seconds * 100); ++i) {
      step();
      if (condition(companion.telemetry())) return true;
    }
    return false;
  }
  bool take_off() {
    EXPECT_TRUE(companion.engage(true));
    return run_until(30, [](const Telemetry& t) { return t.phase == Phase::kMission; });
  }
  [[nodiscard]] std::string notes() const {
    std::string all;
    const std::uint32_t count = companion.note_count();
    for (std::uint32_t n = count > Companion::kNotes ? count - Companion::kNotes : 0; n < count; ++n) {
      all += std::to_string(companion.note(n).time / 1000) + " " + std::string(companion.note(n).view()) + "\n";
    }
    return all;
  }
  [[nodiscard]] double rms() const { return std::sqrt(square_sum / std::max(samples, 1)); }
};

TEST(Companion, FliesGoalsInARowAndLands) {
  for (const SetpointForm form : {SetpointForm::kAttitude, SetpointForm::kRates, SetpointForm::kPosition}) {
    Settings settings = usual_settings();
    settings.form = form;
    settings.margins.tubes.position = 0.17;
    settings.land_at_end = true;
    Rig rig(settings);
    ASSERT_TRUE(rig.take_off()) << rig.notes();
    EXPECT_TRUE(rig.companion.add_goal({3.5, 2.5, 0.8}));
    EXPECT_TRUE(rig.companion.add_goal({0.6, 2.6, 1.2}));
    EXPECT_TRUE(rig.companion.add_goal({0.6, 0.6, 0.8}));
    EXPECT_TRUE(rig.run_until(90, [](const Telemetry& t) { return t.phase == Phase::kDone; })) << rig.notes();
    EXPECT_EQ(rig.companion.telemetry().goals_reached, 3U) << rig.notes();
    std::printf("%d: rms %.3f max %.3f\n%s", static_cast<int>(form), rig.rms(), rig.worst_error, rig.notes().c_str());
  }
}

}  // namespace
}  // namespace swiftlet::companion
