// The line to the autopilot ends behind each byte of a message period, in flight; and comes back.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include "companion/companion.hpp"
#include "map/map_builder.hpp"
#include "map/voxel_map.hpp"
#include "sim/lockstep_uart.hpp"
#include "world/worlds.hpp"

namespace swiftlet::tools {
namespace {

using companion::Phase;
using companion::Telemetry;
using std::chrono::milliseconds;

constexpr Capacity kCapacity{.segments = 64, .search_nodes = 4096};
constexpr std::size_t kUncut = std::numeric_limits<std::size_t>::max();

/// A line that ends, in each direction after so many more bytes: what comes later is gone, and nobody notices.
class CutLine final : public hal::Uart {
 public:
  explicit CutLine(PixhawkSim& sim) : line_(sim) {}

  std::size_t write(std::span<const std::byte> bytes) override {
    (void)line_.write(bytes.first(passing(bytes.size(), to_autopilot)));
    return bytes.size();
  }
  std::size_t read(std::span<std::byte> into) override {
    const std::size_t count = line_.read(into);
    received += count;
    return passing(count, to_companion);
  }
  [[nodiscard]] std::uint32_t overruns() const override { return 0; }
  void advance(milliseconds duration) { line_.advance(duration); }

  std::size_t to_companion = kUncut;
  std::size_t to_autopilot = kUncut;
  std::size_t received = 0;  // as if it were not cut

 private:
  static std::size_t passing(std::size_t count, std::size_t& left) {
    const std::size_t passes = std::min(count, left);
    if (left != kUncut) left -= passes;
    return passes;
  }

  LockstepUart line_;
};

/// 12.8 x 12.8 x 6.4 m without anything in it: where a vehicle drifts to does not matter here.
std::vector<std::byte> hall() {
  const std::string bt = to_bt([] {
    VoxelGrid grid({40, 40, 20}, 0.32);
    grid.fill({{0, 0, 0}, {0, 0, 0}}, true);
    return grid;
  }());
  MapBuildOptions options;
  options.radius = 0.3;
  return build_map(*parse_octree("hall", std::as_bytes(std::span(bt))), "hall", options,
                   [](std::string_view, double) {})
      ->blob;
}

class Flight {
 public:
  Flight() : sim_(sim_settings()), line(sim_) {}

  void step() {
    line.advance(milliseconds(10));
    companion.step(sim_.time());
  }
  /// How long it took until `condition` [s]; more than `seconds` when it did not come.
  template <typename Condition>
  double time_until(double seconds, const Condition& condition) {
    int steps = 0;
    do {
      step();
      ++steps;
    } while (!condition() && steps <= seconds * 100);
    return steps / 100.0;
  }
  [[nodiscard]] bool is(FlightState state) const { return companion.telemetry().state == state; }

  /// Between two places, in full motion.
  bool flies() {
    const Telemetry& t = companion.telemetry();
    if (t.goals_waiting == 0 && t.phase == Phase::kMission) {
      there_ = !there_;
      (void)companion.set_goal(there_ ? Vector3{10, 10, 3} : Vector3{3, 3, 3});
    }
    return is(FlightState::kFlying) && t.reference.sample.velocity.norm() > Real(0.9);
  }

 private:
  static companion::Settings settings() {
    companion::Settings settings;
    settings.start = {6, 6, 2};
    settings.margins.vehicle_radius = Real(0.1);
    settings.margins.map_error = Real(0.04);
    settings.takeoff.standing = kSecondUs;
    return settings;
  }
  static PixhawkSimSettings sim_settings() {
    PixhawkSimSettings sim;
    sim.simulation.start = settings().start;
    return sim;
  }

  std::vector<std::byte> blob_ = hall();
  BoxGraphView map_ = *BoxGraphView::open(blob_);
  std::unique_ptr<PlannerStorage<kCapacity>> planner_memory_ = std::make_unique<PlannerStorage<kCapacity>>();
  std::unique_ptr<companion::CompanionStorage<kCapacity>> memory_ =
      std::make_unique<companion::CompanionStorage<kCapacity>>();
  PixhawkSim sim_;
  companion::InlineWorker worker_{planner_memory_->spans()};
  bool there_ = false;

 public:
  CutLine line;
  companion::Companion companion{settings(), map_, memory_->memory(), {line, worker_}};
};

TEST(CompanionCut, BehindAnyByteOfAMessagePeriodIsAnsweredByABrakeAndByAYieldAndFlownOnAfter) {
  const auto flight = std::make_unique<Flight>();
  CutLine& line = flight->line;
  (void)flight->companion.engage(true);
  ASSERT_LT(flight->time_until(30, [&] { return flight->flies(); }), 30);
  const std::size_t before = line.received;
  flight->step();
  flight->step();  // two steps: the period of the position
  const std::size_t period = line.received - before;
  ASSERT_GT(period, 100U);
  for (std::size_t cut = 0; cut < period; ++cut) {
    ASSERT_LT(flight->time_until(30, [&] { return flight->flies(); }), 30) << "cut at " << cut;
    line.to_companion = cut;
    line.to_autopilot = cut;
    const double braked = flight->time_until(1, [&] { return flight->is(FlightState::kBraking); });
    EXPECT_LE(braked, 0.25) << "cut at " << cut;
    EXPECT_EQ(flight->companion.telemetry().form, SetpointForm::kPosition);
    const double yielded = flight->time_until(2, [&] { return flight->is(FlightState::kYielded); });
    EXPECT_LE(braked + yielded, 1.05) << "cut at " << cut;
    const std::uint32_t frames = flight->companion.telemetry().link.sent_frames;
    line.to_companion = line.to_autopilot = kUncut;
    (void)flight->time_until(0.5, [] { return false; });
    EXPECT_TRUE(flight->is(FlightState::kYielded)) << "cut at " << cut;
    EXPECT_LT(flight->companion.telemetry().link.sent_frames - frames, 20U);  // no set-points, which would be 50
    (void)flight->companion.engage(true);
  }
}

}  // namespace
}  // namespace swiftlet::tools
