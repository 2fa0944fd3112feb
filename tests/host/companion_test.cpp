// The companion in closed loop with the simulated autopilot, in lock-step. Every flight is logged and replayed.
#include "companion/companion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "flight/memory_storage.hpp"
#include "flight/replay.hpp"
#include "fly/fillable_storage.hpp"
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

std::vector<std::byte> blob_of(const tools::VoxelGrid& grid, double radius) {
  const std::string bt = tools::to_bt(grid);
  const auto voxels = tools::parse_octree("world.bt", std::as_bytes(std::span(bt)));
  tools::MapBuildOptions options;
  options.radius = radius;
  return tools::build_map(*voxels, "world.bt", options, [](std::string_view, double) {})->blob;
}

std::vector<std::byte> classroom_blob(double radius) { return blob_of(tools::make_classroom(1).grid, radius); }

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

/// A hall of 12.8 x 12.8 x 3.2 m with a pillar, for the position form's wide tube.
std::vector<std::byte> hall_blob(bool with_floor, double radius = 0.7) {
  tools::VoxelGrid grid({40, 40, 10}, 0.32);
  grid.fill({{15, 15, 0}, {16, 16, 9}}, true);
  if (with_floor) grid.fill({{0, 0, 0}, {39, 39, 0}}, true);
  return blob_of(grid, radius);
}

const BoxGraphView& hall() {
  static const std::vector<std::byte> blob = hall_blob(false);
  static const BoxGraphView view = *BoxGraphView::open(blob);
  return view;
}

/// What the companion reads and writes, with a tap for a ground station on the same line.
class TappedUart final : public hal::Uart {
 public:
  explicit TappedUart(PixhawkSim& sim) : line_(sim) {}
  std::size_t write(std::span<const std::byte> bytes) override {
    const auto taken = bytes.first(std::min(bytes.size(), room));
    written.insert(written.end(), taken.begin(), taken.end());
    if (lost_command != 0 && command_of(bytes) == lost_command) return taken.size();
    if (loses_questions && is_question(bytes)) return taken.size();
    return line_.write(taken);
  }
  std::size_t read(std::span<std::byte> into) override {
    if (injected.empty()) return line_.read(into);
    const std::size_t count = std::min(into.size(), injected.size());
    std::copy_n(injected.begin(), count, into.begin());
    injected.erase(injected.begin(), injected.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }
  [[nodiscard]] std::uint32_t overruns() const override { return 0; }
  void advance(std::chrono::microseconds duration) { line_.advance(duration); }

  std::vector<std::byte> written;
  std::vector<std::byte> injected;
  std::size_t room = 1000;         // of each write
  std::uint16_t lost_command = 0;  // that never arrives
  bool loses_questions = false;    // for the autopilot's parameters

 private:
  static std::uint16_t command_of(std::span<const std::byte> bytes) {
    mavlink::Codec reader({255, 190});
    const auto frame = reader.receive(bytes);
    const auto command = frame ? mavlink::decode<mavlink::CommandLong>(*frame) : std::nullopt;
    return command ? command->command : std::uint16_t{0};
  }

  static bool is_question(std::span<const std::byte> bytes) {
    mavlink::Codec reader({255, 190});
    const auto frame = reader.receive(bytes);
    return frame && frame->id == mavlink::ParameterRequest::kId;
  }

  LockstepUart line_;
};

/// Companion, simulated vehicle and the operator.
class Rig {
 public:
  explicit Rig(const Settings& settings = usual_settings(), const PixhawkSimSettings& sim_settings = usual_sim(),
               const BoxGraphView& map = classroom(), std::uint32_t plan_steps = 1)
      : settings_(settings),
        maps({map}),
        sim(sim_settings),
        uart(sim),
        worker(planner_memory_->spans(), plan_steps),
        log(begun_log(storage, map)),
        companion(settings, map, memory_->memory(), {uart, worker, log.get()}) {}
  ~Rig() {
    log->end();
    check_replay();
  }
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

 private:
  static std::unique_ptr<FlightLog> begun_log(hal::Storage& storage, const BoxGraphView& map) {
    auto log = std::make_unique<FlightLog>(storage);
    EXPECT_TRUE(log->begin("flight.ulg", 0, {"1", "test", "{}", map.header().crc32}));
    return log;
  }
  void check_replay() {
    const auto parsed = tools::parse_ulog("flight.ulg", storage.bytes());
    ASSERT_TRUE(parsed) << parsed.error().message;
    const auto report = tools::replay(*parsed, {maps, settings_, memory_->memory(), planner_memory_->spans()});
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_FALSE(report->difference) << report->difference->time << ": " << report->difference->what;
    EXPECT_EQ(report->steps, steps_);
    EXPECT_EQ(report->plans, companion.telemetry().plan.id);
  }

  Settings settings_;
  std::size_t steps_ = 0;
  std::unique_ptr<PlannerStorage<kCapacity>> planner_memory_ = std::make_unique<PlannerStorage<kCapacity>>();
  std::unique_ptr<CompanionStorage<kCapacity>> memory_ = std::make_unique<CompanionStorage<kCapacity>>();

 public:
  std::vector<BoxGraphView> maps;  // that the companion was given
  PixhawkSim sim;
  TappedUart uart;
  InlineWorker worker;
  tools::MemoryStorage storage;
  std::unique_ptr<FlightLog> log;
  Companion companion;
  double worst_error = 0;                     // [m] reference to truth, in the mission
  std::chrono::microseconds clock_offset{0};  // of the companion's clock

  void step() {
    uart.advance(milliseconds(10));
    companion.step(sim.time() + clock_offset);
    ++steps_;
    const Telemetry& t = companion.telemetry();
    if (t.phase != Phase::kMission) return;
    worst_error = std::max(worst_error, (t.reference.sample.position - sim.simulation().truth().position).norm());
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
  bool arm_on_the_ground() {
    EXPECT_TRUE(companion.engage(true));
    return run_until(10, [](const Telemetry& t) { return t.armed; }) && !companion.telemetry().aligned;
  }
  tools::Autopilot& autopilot() { return sim.simulation().autopilot(); }
  /// How many frames the companion has sent so far for which `wanted` is true.
  template <typename Wanted>
  [[nodiscard]] int count_sent(const Wanted& wanted) const {
    mavlink::Codec reader({255, 190});
    std::span<const std::byte> bytes(uart.written);
    int count = 0;
    while (const auto frame = reader.receive(bytes)) count += wanted(*frame) ? 1 : 0;
    return count;
  }
  /// How often it has asked for a mode or for arming.
  [[nodiscard]] int requests() const {
    return count_sent([](const mavlink::Frame& frame) {
      const auto command = mavlink::decode<mavlink::CommandLong>(frame);
      return command &&
             (command->command == mavlink::kCommandDoSetMode || command->command == mavlink::kCommandArmDisarm);
    });
  }
  [[nodiscard]] int heartbeats() const {
    return count_sent(
        [](const mavlink::Frame& frame) { return mavlink::decode<mavlink::Heartbeat>(frame).has_value(); });
  }
  [[nodiscard]] std::string notes() const {
    std::string all;
    const std::uint32_t count = companion.note_count();
    for (std::uint32_t n = count > Companion::kNotes ? count - Companion::kNotes : 0; n < count; ++n) {
      all += std::to_string(companion.note(n).time / 1000) + " " + std::string(companion.note(n).view()) + "\n";
    }
    return all;
  }
  PlannerSpans planner_spans() { return planner_memory_->spans(); }
};

/// Somebody else on the companion's line.
class GroundStation {
 public:
  explicit GroundStation(Rig& rig) : rig_(rig) {}

  void send_goal(const Vector3& p_W, std::optional<float> yaw = {}) {
    send_target(mavlink::kFrameLocalFlu, {p_W}, yaw);
  }
  /// In the autopilot's local frame, as ENU.
  void send_local_goal(const Vector3& p_L) { send_target(mavlink::kFrameLocalNed, mavlink::to_ned(p_L), {}); }
  void send_command(std::uint16_t command) {
    put(codec_.encode(mavlink::CommandLong{{1, mavlink::kPathPlannerComponent}, command, 0, {}}));
  }
  /// The companion's latest answer to a command.
  std::optional<mavlink::CommandResult> answer(std::uint16_t command) {
    mavlink::Codec reader({255, 190});
    std::span<const std::byte> bytes(rig_.uart.written);
    std::optional<mavlink::CommandResult> result;
    while (const auto frame = reader.receive(bytes)) {
      const auto ack = mavlink::decode<mavlink::CommandAck>(*frame);
      if (ack && ack->command == command) result = ack->result;
    }
    return result;
  }
  /// Whether the companion has ever sent such a text.
  bool heard(std::string_view words) {
    mavlink::Codec reader({255, 190});
    std::span<const std::byte> bytes(rig_.uart.written);
    std::string all;
    while (const auto frame = reader.receive(bytes)) {
      if (const auto text = mavlink::decode<mavlink::StatusText>(*frame)) all += mavlink::text_of(text->text);
    }
    return all.find(words) != std::string::npos;
  }

 private:
  void send_target(std::uint8_t frame, const mavlink::NedVector& position, std::optional<float> yaw) {
    mavlink::SetPositionTarget target;
    target.target = {1, mavlink::kPathPlannerComponent};
    target.frame = frame;
    target.type_mask = mavlink::kIgnoreVelocity | mavlink::kIgnoreAcceleration | mavlink::kIgnoreYawRate |
                       (yaw ? 0 : mavlink::kIgnoreYaw);
    target.position = position;
    target.yaw = yaw.value_or(0);
    put(codec_.encode(target));
  }
  void put(std::span<const std::byte> frame) {
    rig_.uart.injected.insert(rig_.uart.injected.end(), frame.begin(), frame.end());
  }

  Rig& rig_;
  mavlink::Codec codec_{{255, 190}};
};

constexpr Real kTube = 0.15;
const Vector3 kFar{3.5, 2.5, 0.8};
const Vector3 kSide{1.0, 2.6, 1.0};
const Vector3 kBack{0.6, 0.6, 0.8};
const Vector3 kInTheScreen{0.6, 2.6, 1.2};

bool is_done(const Telemetry& t) { return t.phase == Phase::kDone; }
bool is_flying(const Telemetry& t) { return t.state == FlightState::kFlying; }
bool is_holding(const Telemetry& t) { return t.state == FlightState::kHolding; }
bool has_yielded(const Telemetry& t) { return t.state == FlightState::kYielded; }

// ---- The flight as it should be

TEST(Companion, FliesGoalsInARowAndLands) {
  for (const SetpointForm form : {SetpointForm::kAttitude, SetpointForm::kRates}) {
    Settings settings = usual_settings();
    settings.form = form;
    settings.land_at_end = true;
    Rig rig(settings);
    ASSERT_TRUE(rig.take_off()) << rig.notes();
    for (const Vector3& goal : {kFar, kSide, kBack}) EXPECT_TRUE(rig.companion.add_goal(goal));
    EXPECT_TRUE(rig.run_until(90, is_done)) << rig.notes();
    EXPECT_EQ(rig.companion.telemetry().goals_reached, 3U) << rig.notes();
    EXPECT_EQ(rig.sim.simulation().autopilot().armed(), false);
    EXPECT_LT(rig.worst_error, 0.25) << rig.notes();
    EXPECT_EQ(rig.companion.telemetry().link.refused_setpoints, 0U);
    EXPECT_GE(rig.companion.telemetry().plan.id, 3U);
  }
}

TEST(Companion, FliesOnThePositionFormInAMapThatCoversItsTube) {
  Settings settings = usual_settings();
  settings.form = SetpointForm::kPosition;
  settings.start = {3.2, 3.2, 0};
  PixhawkSimSettings sim = usual_sim();
  sim.simulation.start = settings.start;
  Rig rig(settings, sim, hall());
  ASSERT_TRUE(rig.take_off()) << rig.notes();
  EXPECT_TRUE(rig.companion.add_goal({7, 3.2, 1.2}));
  EXPECT_TRUE(rig.companion.add_goal({7, 7, 1.2}));
  EXPECT_TRUE(rig.run_until(60, [](const Telemetry& t) { return t.goals_reached == 2; })) << rig.notes();
  EXPECT_LT(rig.worst_error, 0.5);
}

TEST(Companion, IsADeterministicFunctionOfWhatEnters) {
  std::vector<double> paths[2];
  for (std::vector<double>& path : paths) {
    Rig rig;
    ASSERT_TRUE(rig.take_off());
    EXPECT_TRUE(rig.companion.add_goal(kFar));
    rig.run(5);
    for (const double x : rig.companion.telemetry().command.body_rates) path.push_back(x);
    path.push_back(static_cast<double>(rig.companion.telemetry().link.sent_bytes));
  }
  EXPECT_EQ(paths[0], paths[1]);
}

TEST(Companion, FramesAreTiedAtArmingThoughTheOriginDriftsBefore) {
  Rig rig;
  rig.run(30);  // drift
  ASSERT_TRUE(rig.take_off()) << rig.notes();
  const Vector3 truth = rig.sim.simulation().truth().position;
  EXPECT_LT((rig.companion.telemetry().estimate.position - truth).norm(), 0.1);
}

TEST(Companion, AJumpOfTheEstimateWhileFramesAreTiedBeginsThatAnew) {
  PixhawkSimSettings sim = usual_sim();
  sim.faults = {*tools::parse_fault("position-jump@5")};
  Rig rig(usual_settings(), sim);
  EXPECT_TRUE(rig.companion.engage(true));
  ASSERT_TRUE(rig.run_until(4.9, [](const Telemetry& t) { return t.armed; })) << rig.notes();
  ASSERT_FALSE(rig.companion.telemetry().aligned);
  ASSERT_TRUE(rig.run_until(30, [](const Telemetry& t) { return t.phase == Phase::kMission; })) << rig.notes();
  const Vector3 truth = rig.sim.simulation().truth().position;
  EXPECT_LT((rig.companion.telemetry().estimate.position - truth).norm(), 0.1);
}

TEST(Companion, ASecondFlightStartsWhereTheFirstOneEnded) {
  Settings settings = usual_settings();
  settings.land_at_end = true;
  Rig rig(settings);
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.add_goal({2, 2.6, 1}));
  ASSERT_TRUE(rig.run_until(60, is_done)) << rig.notes();
  ASSERT_TRUE(rig.take_off()) << rig.notes();
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  ASSERT_TRUE(rig.run_until(60, is_done)) << rig.notes();
  EXPECT_EQ(rig.companion.telemetry().goals_reached, 1U);
  EXPECT_LT((rig.sim.simulation().truth().position - kFar).head<2>().norm(), 0.4);
}

TEST(Companion, AGoalsYawIsTakenUpThere) {
  Rig rig;
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.add_goal(kFar, 2.0));
  ASSERT_TRUE(rig.run_until(30, [](const Telemetry& t) { return t.goals_reached == 1; })) << rig.notes();
  EXPECT_NEAR(tools::yaw_of(rig.sim.simulation().truth().attitude), 2.0, 0.15);
  rig.run(2);
  EXPECT_NEAR(tools::yaw_of(rig.sim.simulation().truth().attitude), 2.0, 0.15);
}

// ---- Replanning

TEST(Companion, ANewGoalIsFlownToFromTheReferencesMotionWithinAStep) {
  Rig rig(usual_settings(), usual_sim(), classroom(), 0);
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  ASSERT_TRUE(rig.run_until(5, is_flying));
  rig.run(0.6);
  EXPECT_TRUE(rig.companion.set_goal(kBack));
  rig.step();
  EXPECT_EQ(rig.companion.telemetry().plan.id, 2U) << rig.notes();
  EXPECT_EQ(rig.companion.telemetry().plan.latency, 0);
  EXPECT_GT(rig.companion.telemetry().plan.from.velocity.norm(), 0.2);
  EXPECT_TRUE(rig.run_until(30, [](const Telemetry& t) { return t.goals_reached == 1; })) << rig.notes();
  EXPECT_LT((rig.companion.telemetry().estimate.position - kBack).norm(), kTube);
}

TEST(Companion, NewLimitsReplanWhatIsUnderWay) {
  Rig rig;
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  ASSERT_TRUE(rig.run_until(5, is_flying));
  rig.run(0.3);
  EXPECT_TRUE(rig.companion.set_limits(0.5, 2));
  EXPECT_FALSE(rig.companion.set_limits(-1, 2));
  EXPECT_TRUE(rig.run_until(30, [](const Telemetry& t) { return t.goals_reached == 1; })) << rig.notes();
  EXPECT_LE(rig.companion.telemetry().plan.certificate.max_speed.maxCoeff(), 0.5 + 1e-6);
}

TEST(Companion, ABlockedBoxOnTheWayIsFlownAroundWithoutAStop) {
  Settings settings = usual_settings();
  settings.start = {3.2, 3.2, 0};
  PixhawkSimSettings sim = usual_sim();
  sim.simulation.start = settings.start;
  Rig rig(settings, sim, hall());
  ASSERT_TRUE(rig.take_off()) << rig.notes();
  EXPECT_TRUE(rig.companion.add_goal({9, 3.2, 1.2}));
  ASSERT_TRUE(rig.run_until(5, is_flying));
  rig.run(1);
  const Box box{{6.2, 3, 0}, {6.6, 3.4, 3.2}};
  const auto distance = [&](const Vector3& p) { return (p - p.cwiseMax(box.lo).cwiseMin(box.hi)).norm(); };
  ASSERT_GT(distance(rig.sim.simulation().truth().position), 1.5);
  EXPECT_TRUE(rig.companion.block(7, box));
  double nearest = 100;
  ASSERT_TRUE(rig.run_until(30, [&](const Telemetry& t) {
    nearest = std::min(nearest, distance(rig.sim.simulation().truth().position));
    return t.goals_reached == 1;
  })) << rig.notes();
  EXPECT_EQ(rig.notes().find("braking"), std::string::npos) << rig.notes();
  EXPECT_EQ(rig.companion.telemetry().plan.id, 2U);
  EXPECT_GT(nearest, 0.7 - kTube);  // the map's radius and the tube
  EXPECT_LT(nearest, 2);            // and it was on the way
}

TEST(Companion, ABlockedBoxAtTheGoalIsStoppedBefore) {
  Rig rig;
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  ASSERT_TRUE(rig.run_until(5, is_flying));
  rig.run(0.5);
  const Vector3 ahead = kFar - Vector3{0.2, 0.2, 0};
  EXPECT_TRUE(rig.companion.block(7, {ahead - Vector3::Constant(0.1), ahead + Vector3::Constant(0.1)}));
  ASSERT_TRUE(rig.run_until(30, is_holding)) << rig.notes();
  rig.run(1);
  EXPECT_GT((rig.sim.simulation().truth().position - ahead).norm(), 0.35) << rig.notes();
  EXPECT_TRUE(rig.companion.unblock(7));
  EXPECT_TRUE(rig.companion.unblock(8));
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  EXPECT_TRUE(rig.run_until(30, [](const Telemetry& t) { return t.goals_reached == 1; })) << rig.notes();
}

TEST(Companion, ABlockedBoxAboveTheStartIsNoStartAndOneThatComesLaterEndsTheTakeOff) {
  const Vector3 above = kStart + Vector3{0, 0, 0.6};
  const Box box{above - Vector3::Constant(0.1), above + Vector3::Constant(0.1)};
  Rig early;
  EXPECT_TRUE(early.companion.block(1, box));
  EXPECT_FALSE(early.take_off());
  EXPECT_FALSE(early.autopilot().armed());
  EXPECT_NE(early.notes().find("nothing is free above the start"), std::string::npos) << early.notes();
  Rig late;
  ASSERT_TRUE(late.arm_on_the_ground());
  late.run(6);
  ASSERT_EQ(late.companion.telemetry().phase, Phase::kTakeoff) << late.notes();
  EXPECT_TRUE(late.companion.block(1, box));
  double highest = 0;
  EXPECT_TRUE(late.run_until(30, [&](const Telemetry& t) {
    highest = std::max(highest, late.sim.simulation().truth().position.z());
    return is_done(t);
  })) << late.notes();
  EXPECT_LT(highest, 0.2) << late.notes();
}

TEST(Companion, AClimbThatIsBlockedStopsBelowTheBoxAndLands) {
  Settings settings = usual_settings();
  settings.form = SetpointForm::kPosition;
  settings.start = {3.2, 3.2, 0};
  settings.takeoff.height = 2.2;
  PixhawkSimSettings sim = usual_sim();
  sim.simulation.start = settings.start;
  Rig rig(settings, sim, hall());
  EXPECT_TRUE(rig.companion.engage(true));
  const auto height = [&] { return rig.sim.simulation().truth().position.z(); };
  ASSERT_TRUE(rig.run_until(20, [&](const Telemetry&) { return height() > 0.3; })) << rig.notes();
  EXPECT_TRUE(rig.companion.block(1, {{3, 3, 1.9}, {3.4, 3.4, 2}}));  // and the map's radius of 0.7 m
  double highest = 0;
  EXPECT_TRUE(rig.run_until(30, [&](const Telemetry& t) {
    highest = std::max(highest, height());
    return is_done(t);
  })) << rig.notes();
  EXPECT_LT(highest, 1.2);
}

TEST(Companion, ALatePlanFromRestIsDiscardedAndTheNextOneGivenMoreTime) {
  Rig rig(usual_settings(), usual_sim(), classroom(), 8);  // 80 ms; the splice lies 50 ms ahead
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  rig.run(0.15);
  EXPECT_EQ(rig.companion.telemetry().deadline_misses, 1U);
  EXPECT_EQ(rig.companion.telemetry().plan.id, 0U);
  ASSERT_TRUE(rig.run_until(1, is_flying)) << rig.notes();
  EXPECT_EQ(rig.companion.telemetry().deadline_misses, 1U);
}

TEST(Companion, LatePlansInFlightEndInABrakeAndInTimeForAPlanFromRest) {
  Rig rig(usual_settings(), usual_sim(), classroom(), 8);
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  ASSERT_TRUE(rig.run_until(5, is_flying));
  rig.run(0.6);
  EXPECT_TRUE(rig.companion.set_goal(kBack));
  ASSERT_TRUE(rig.run_until(1, [](const Telemetry& t) { return t.reason == Reason::kDeadlineMisses; })) << rig.notes();
  EXPECT_TRUE(rig.run_until(30, [](const Telemetry& t) { return t.goals_reached == 1; })) << rig.notes();
  EXPECT_LT((rig.companion.telemetry().estimate.position - kBack).norm(), kTube);
}

TEST(Companion, AGoalWhosePlansAreAlwaysLateIsGivenUpWithAReason) {
  Rig rig(usual_settings(), usual_sim(), classroom(), 400);  // 4 s
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  EXPECT_TRUE(rig.run_until(40, [](const Telemetry& t) { return t.goals_waiting == 0; })) << rig.notes();
  EXPECT_NE(rig.notes().find("given up: too late"), std::string::npos) << rig.notes();
  EXPECT_EQ(rig.companion.telemetry().state, FlightState::kHolding);
}

// ---- Words that are refused, and others

TEST(Companion, AGoalThatIsNotFreeIsRefusedWithAReasonAndTheFlightHolds) {
  Rig rig;
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.add_goal(kInTheScreen));
  EXPECT_FALSE(rig.companion.add_goal({NAN, 0, 0}));
  EXPECT_FALSE(rig.companion.add_goal(kFar, 1e9));
  rig.run(0.5);
  EXPECT_NE(rig.notes().find("refused: goal_not_free"), std::string::npos);
  EXPECT_EQ(rig.companion.telemetry().goals_waiting, 0U);
  EXPECT_EQ(rig.companion.telemetry().state, FlightState::kHolding);
}

TEST(Companion, AGoalWithoutAWayIsGivenUpWithAReasonAndTheFlightHolds) {
  Rig rig;
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.block(1, {{1.8, -1, -1}, {1.9, 5, 5}}));  // a wall
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  rig.run(0.5);
  EXPECT_NE(rig.notes().find("given up: no_path"), std::string::npos) << rig.notes();
  EXPECT_EQ(rig.companion.telemetry().state, FlightState::kHolding);
}

TEST(Companion, MoreGoalsThanThereIsRoomForAreRefused) {
  Rig rig;
  rig.run(0.1);
  for (std::size_t i = 0; i < kMostGoals; ++i) EXPECT_TRUE(rig.companion.add_goal(kFar));
  EXPECT_FALSE(rig.companion.add_goal(kFar));  // too many words for a step
  rig.step();
  EXPECT_TRUE(rig.companion.add_goal(kBack));
  rig.step();
  EXPECT_EQ(rig.companion.telemetry().goals_waiting, kMostGoals);
  EXPECT_NE(rig.notes().find("too many goals"), std::string::npos);
}

TEST(Companion, AMapThatDoesNotCoverTheMarginsIsNotFlown) {
  Settings settings = usual_settings();
  settings.margins.vehicle_radius = 0.13;
  Rig rig(settings);
  EXPECT_FALSE(rig.take_off());
  EXPECT_EQ(rig.companion.telemetry().state, FlightState::kIdle);
  EXPECT_EQ(rig.companion.telemetry().reason, Reason::kMarginsTooSmall);
  EXPECT_NE(rig.notes().find("the margins need 0.31 m"), std::string::npos) << rig.notes();
  EXPECT_FALSE(rig.sim.simulation().autopilot().armed());
}

/// In the hall 0.119 m of the map's radius are left: 3.97 m.
Settings heading_settings() {
  Settings settings = usual_settings();
  settings.start = {3.2, 3.2, 0};
  settings.margins.vehicle_radius = 0.4;
  settings.margins.heading_accuracy = 0.03;
  return settings;
}

PixhawkSimSettings heading_sim() {
  PixhawkSimSettings sim = usual_sim();
  sim.simulation.start = {3.2, 3.2, 0};
  sim.simulation.estimator.attitude_sigma.z() = 0.01;
  return sim;
}

bool has_reached_one(const Telemetry& t) { return t.goals_reached == 1; }

TEST(Companion, AGoalBeyondWhatTheHeadingsMarginCoversIsRefusedAndANearOneIsFlownTo) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    PixhawkSimSettings sim = heading_sim();
    sim.simulation.seed = seed;
    Rig rig(heading_settings(), sim, hall());
    ASSERT_TRUE(rig.take_off()) << rig.notes();
    EXPECT_TRUE(rig.companion.add_goal({8.2, 3.2, 1.2}));
    rig.run(0.5);
    EXPECT_NE(
        rig.notes().find("goal 8.20 3.20 1.20 refused: 5.00 m from the start, the heading's margin allows 3.97 m"),
        std::string::npos)
        << rig.notes();
    EXPECT_EQ(rig.companion.telemetry().state, FlightState::kHolding);
    EXPECT_TRUE(rig.companion.add_goal({7.1, 3.2, 1.2}));
    EXPECT_TRUE(rig.run_until(30, has_reached_one)) << rig.notes();
    EXPECT_LT(rig.worst_error, kTube + 0.119);
  }
}

TEST(Companion, AWayThatLeadsBeyondTheHeadingsMarginIsGivenUp) {
  Rig rig(heading_settings(), heading_sim(), hall());
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.block(1, {{4.5, -1, -1}, {4.6, 6.5, 5}}));  // a wall; the way around it is 4.4 m off
  EXPECT_TRUE(rig.companion.add_goal({6.2, 3.2, 1.2}));
  rig.run(0.5);
  EXPECT_NE(rig.notes().find("given up: its way leads farther"), std::string::npos) << rig.notes();
  EXPECT_EQ(rig.companion.telemetry().plan.id, 0U);
  EXPECT_TRUE(rig.companion.unblock(1));
  EXPECT_TRUE(rig.companion.add_goal({6.2, 3.2, 1.2}));
  EXPECT_TRUE(rig.run_until(30, has_reached_one)) << rig.notes();
}

TEST(Companion, TheHeadingsErrorsOfFlightsInARowAddUp) {
  Settings settings = heading_settings();
  settings.land_at_end = true;
  Rig rig(settings, heading_sim(), hall());
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.add_goal({5.2, 3.2, 1.2}));  // half of the margin
  ASSERT_TRUE(rig.run_until(60, is_done)) << rig.notes();
  ASSERT_TRUE(rig.take_off()) << rig.notes();
  EXPECT_TRUE(rig.companion.add_goal({6.0, 3.2, 1.2}));  // three readings of the heading are off: 0.08 m more
  rig.run(0.5);
  EXPECT_NE(rig.notes().find("goal 6.00 3.20 1.20 refused"), std::string::npos) << rig.notes();
  EXPECT_TRUE(rig.companion.add_goal({5.6, 3.2, 1.2}));
  EXPECT_TRUE(rig.run_until(30, has_reached_one)) << rig.notes();
}

TEST(Companion, AFlightThatLeavesTheHeadingsMarginBehindIsTheLast) {
  const std::vector<std::byte> blob = hall_blob(false, 0.59);  // 9 mm are left
  const BoxGraphView tight = *BoxGraphView::open(blob);
  Rig rig(heading_settings(), heading_sim(), hall());
  rig.maps.push_back(tight);
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.add_goal({5.2, 3.2, 1.2}));
  ASSERT_TRUE(rig.run_until(30, has_reached_one)) << rig.notes();
  EXPECT_TRUE(rig.companion.replace_map(tight));
  EXPECT_TRUE(rig.companion.land());
  ASSERT_TRUE(rig.run_until(30, is_done)) << rig.notes();
  EXPECT_TRUE(rig.companion.engage(true));
  rig.run(5);
  EXPECT_FALSE(rig.companion.telemetry().armed);
  EXPECT_EQ(rig.companion.telemetry().reason, Reason::kMarginsTooSmall);
  EXPECT_FALSE(rig.companion.replace_map(tight));
  EXPECT_TRUE(rig.companion.replace_map(hall()));
  EXPECT_TRUE(rig.take_off()) << rig.notes();
}

TEST(Reach, CoversAWayThatIsProvenToStayWithinIt) {
  Segment segment;
  segment.duration = 2;
  segment.coefficients[0] = {1, 2, -1, 0, 0, 0};  // out to 2 m and back
  segment.coefficients[1] = {-3, 0, 0, 0, 0, 0};
  segment.coefficients[2] = {0, 100, 0, 0, 0, 0};
  const auto covers = [&segment](Real distance) { return Reach{{1, -3, 50}, distance}.covers(std::span(&segment, 1)); };
  EXPECT_TRUE(covers(1.3));  // the hull is a little wider
  EXPECT_FALSE(covers(0.99));
  EXPECT_TRUE(covers(kUnlimited));
}

TEST(Companion, NothingFreeAboveTheStartIsNoStart) {
  Settings settings = usual_settings();
  settings.start = {-5, 0, 0};
  Rig rig(settings);
  EXPECT_FALSE(rig.take_off());
  EXPECT_NE(rig.notes().find("nothing is free above the start"), std::string::npos) << rig.notes();
  EXPECT_FALSE(rig.sim.simulation().autopilot().armed());
}

TEST(Companion, StopBrakesAndForgetsTheGoals) {
  Rig rig;
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  EXPECT_TRUE(rig.companion.add_goal(kBack));
  ASSERT_TRUE(rig.run_until(5, is_flying));
  rig.run(1);
  EXPECT_TRUE(rig.companion.stop());
  ASSERT_TRUE(rig.run_until(3, is_holding)) << rig.notes();
  const Vector3 stopped = rig.companion.telemetry().reference.sample.position;
  rig.run(3);
  EXPECT_EQ((rig.companion.telemetry().reference.sample.position - stopped).norm(), 0);
  EXPECT_TRUE(rig.companion.add_goal(kBack));
  EXPECT_TRUE(rig.run_until(30, [](const Telemetry& t) { return t.goals_reached == 1; })) << rig.notes();
}

TEST(Companion, LandBrakesAndLandsByTheAutopilotsMode) {
  Rig rig;
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  ASSERT_TRUE(rig.run_until(5, is_flying));
  rig.run(1);
  EXPECT_TRUE(rig.companion.land());
  ASSERT_TRUE(rig.run_until(30, is_done)) << rig.notes();
  EXPECT_TRUE(rig.sim.simulation().quadrotor().on_ground());
  EXPECT_NE(rig.notes().find("yielded: landing requested"), std::string::npos) << rig.notes();
  rig.run(3);
  EXPECT_FALSE(rig.sim.simulation().autopilot().armed());
}

TEST(Companion, ReleaseLetsTheAutopilotHold) {
  Rig rig;
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.engage(false));
  ASSERT_TRUE(rig.run_until(5, has_yielded)) << rig.notes();
  EXPECT_EQ(rig.companion.telemetry().reason, Reason::kReleased);
  const auto sent = rig.companion.telemetry().link.sent_frames;
  rig.run(5);
  EXPECT_LT(rig.companion.telemetry().link.sent_frames - sent, 120U);  // heartbeats and time, no set-points
  EXPECT_EQ(rig.sim.simulation().autopilot().mode(), tools::FlightMode::kLoiter);
  EXPECT_GT(rig.sim.simulation().truth().position.z(), 0.5);
  EXPECT_TRUE(rig.companion.engage(true));
  EXPECT_TRUE(rig.run_until(5, is_holding)) << rig.notes();
}

// ---- Faults

TEST(Companion, ASilentLinkEndsInYielding) {
  PixhawkSimSettings sim = usual_sim();
  sim.faults = {*tools::parse_fault("cut@14")};
  Rig rig(usual_settings(), sim);
  ASSERT_TRUE(rig.take_off()) << rig.notes();
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  ASSERT_TRUE(rig.run_until(10, has_yielded)) << rig.notes();
  EXPECT_EQ(rig.companion.telemetry().reason, Reason::kLinkLost);
}

TEST(Companion, ThePilotWinsAndOnlyTheOperatorTakesControlBack) {
  Rig rig;
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  ASSERT_TRUE(rig.run_until(5, is_flying));
  rig.sim.simulation().autopilot().take_over(tools::FlightMode::kPosctl);
  ASSERT_TRUE(rig.run_until(1, has_yielded)) << rig.notes();
  EXPECT_EQ(rig.companion.telemetry().reason, Reason::kPilotTookOver);
  rig.run(5);
  EXPECT_EQ(rig.sim.simulation().autopilot().mode(), tools::FlightMode::kPosctl);
  EXPECT_TRUE(rig.companion.engage(true));
  EXPECT_TRUE(rig.run_until(30, [](const Telemetry& t) { return t.goals_reached == 1; })) << rig.notes();
}

TEST(Companion, APilotWhoTakesOverWhileItStandsArmedIsNotAskedForTheModeAgain) {
  for (const bool by_word : {true, false}) {
    Settings settings = usual_settings();
    settings.engage_at_start = !by_word;
    Rig rig(settings);
    if (by_word) {
      EXPECT_TRUE(rig.companion.engage(true));
    }
    ASSERT_TRUE(rig.run_until(10, [](const Telemetry& t) { return t.armed; })) << rig.notes();
    rig.run(2);
    const int before = rig.requests();
    rig.autopilot().take_over(tools::FlightMode::kPosctl);
    ASSERT_TRUE(rig.run_until(0.2, has_yielded)) << rig.notes();
    rig.run(15);
    EXPECT_EQ(rig.requests(), before);
    EXPECT_EQ(rig.autopilot().mode(), tools::FlightMode::kPosctl);
    EXPECT_LT(rig.sim.simulation().truth().position.z(), 0.05);
  }
}

TEST(Companion, AVehicleThatThePilotDisarmsWhileItStandsIsNotArmedAgainAndItsGoalsAreKept) {
  Rig rig;
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  ASSERT_TRUE(rig.arm_on_the_ground()) << rig.notes();
  rig.run(2);
  const int before = rig.requests();
  rig.autopilot().disarm(true);
  rig.run(15);
  EXPECT_EQ(rig.requests(), before);
  EXPECT_FALSE(rig.autopilot().armed());
  EXPECT_EQ(rig.companion.telemetry().reason, Reason::kDisarmed);
  ASSERT_TRUE(rig.take_off()) << rig.notes();
  EXPECT_TRUE(rig.run_until(30, [](const Telemetry& t) { return t.goals_reached == 1; })) << rig.notes();
}

TEST(Companion, AnAutopilotThatDisarmsByItselfBeforeTheTakeOffIsNotArmedAgain) {
  Rig rig;
  rig.autopilot().set_parameter(tools::ParameterIndex::kIdleDisarmTime, 3);
  ASSERT_TRUE(rig.arm_on_the_ground()) << rig.notes();
  ASSERT_TRUE(rig.run_until(5, [](const Telemetry& t) { return t.state == FlightState::kLanded; })) << rig.notes();
  const int before = rig.requests();
  rig.run(15);
  EXPECT_EQ(rig.requests(), before);
}

TEST(Companion, ARequestThatWasNotAnsweredIsNotRepeatedOnceThePilotHasTakenOver) {
  Rig rig;
  rig.uart.lost_command = mavlink::kCommandArmDisarm;
  EXPECT_TRUE(rig.companion.engage(true));
  ASSERT_TRUE(rig.run_until(10, [](const Telemetry& t) { return t.mode == mavlink::Mode::kOffboard; }));
  const int before = rig.requests();
  ASSERT_TRUE(rig.run_until(5, [&](const Telemetry&) { return rig.requests() > before; })) << rig.notes();
  rig.autopilot().take_over(tools::FlightMode::kPosctl);
  rig.uart.lost_command = 0;
  rig.run(5);
  EXPECT_EQ(rig.requests(), before + 1);
  EXPECT_FALSE(rig.autopilot().armed());
}

/// The pilot arms by radio and climbs to some height.
void climb_by_radio(Rig& rig) {
  rig.autopilot().take_over(tools::FlightMode::kPosctl);
  EXPECT_EQ(rig.autopilot().arm(true, std::chrono::duration<double>(rig.sim.time()).count()),
            tools::Verdict::kAccepted);
  rig.run(1.5);
  rig.autopilot().move_sticks({0, 0, 0.25});
  rig.run(8);
  rig.autopilot().move_sticks(Vector3::Zero());
  EXPECT_GT(rig.sim.simulation().truth().position.z(), 0.8);
}

TEST(Companion, FramesAreNotTiedInTheAirWhereAPilotTookItThatCouldNotBeArmed) {
  Rig rig;
  rig.uart.lost_command = mavlink::kCommandArmDisarm;
  EXPECT_TRUE(rig.companion.engage(true));
  rig.run(5);
  EXPECT_TRUE(rig.companion.engage(false));
  rig.run(1);
  climb_by_radio(rig);
  EXPECT_FALSE(rig.companion.telemetry().aligned);
  EXPECT_TRUE(rig.companion.engage(true));
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  ASSERT_TRUE(rig.run_until(5, is_holding)) << rig.notes();
  rig.run(2);
  EXPECT_EQ(rig.companion.telemetry().plan.id, 0U) << rig.notes();
}

TEST(Companion, AVehicleThatThePilotArmedIsNotTakenInTheAirByAnOlderWord) {
  Rig rig;
  rig.uart.lost_command = mavlink::kCommandDoSetMode;
  EXPECT_TRUE(rig.companion.engage(true));
  rig.run(2);
  climb_by_radio(rig);
  rig.uart.lost_command = 0;
  const int before = rig.requests();
  rig.run(5);
  EXPECT_EQ(rig.requests(), before) << rig.notes();
  EXPECT_TRUE(rig.companion.engage(true));
  EXPECT_TRUE(rig.run_until(5, is_holding)) << rig.notes();
}

TEST(Companion, AnAutopilotThatRestartsIsLetGoAndItsFrameForgotten) {
  PixhawkSimSettings sim = usual_sim();
  sim.faults = {*tools::parse_fault("restart@14+0.5")};
  Rig rig(usual_settings(), sim);
  ASSERT_TRUE(rig.take_off()) << rig.notes();
  ASSERT_TRUE(rig.run_until(10, [](const Telemetry& t) {
    return t.state == FlightState::kYielded || t.state == FlightState::kLanded;
  })) << rig.notes();
  EXPECT_FALSE(rig.companion.telemetry().aligned);
}

TEST(Companion, ACompanionThatStartsInTheAirHoldsWhereItIsAndFliesNowhere) {
  Rig rig;
  ASSERT_TRUE(rig.take_off());
  Settings settings = usual_settings();
  settings.engage_at_start = true;
  InlineWorker worker(rig.planner_spans());
  static CompanionStorage<kCapacity> memory;
  Companion second(settings, classroom(), memory.memory(), {rig.uart, worker});
  rig.uart.advance(milliseconds(1500));  // OFFBOARD is lost meanwhile
  const Vector3 before = rig.sim.simulation().truth().position;
  for (int i = 0; i < 500; ++i) {
    rig.uart.advance(milliseconds(10));
    second.step(rig.sim.time());
    if (i == 300) {
      EXPECT_TRUE(second.add_goal(kFar));
    }
  }
  EXPECT_EQ(second.telemetry().state, FlightState::kHolding);
  EXPECT_EQ(rig.sim.simulation().autopilot().mode(), tools::FlightMode::kOffboard);
  EXPECT_FALSE(second.telemetry().aligned);
  EXPECT_EQ(second.telemetry().plan.id, 0U);
  EXPECT_LT((rig.sim.simulation().truth().position - before).norm(), 0.6);
  EXPECT_TRUE(second.land());
  for (int i = 0; i < 1500; ++i) {
    rig.uart.advance(milliseconds(10));
    second.step(rig.sim.time());
  }
  EXPECT_EQ(second.telemetry().phase, Phase::kDone);
}

TEST(Companion, ACompanionThatStartsOnTheGroundOfAnArmedVehicleWaitsUntilItKnowsThat) {
  Rig rig;
  ASSERT_TRUE(rig.arm_on_the_ground()) << rig.notes();
  mavlink::Codec station({255, 190});
  const float landed_state = mavlink::ExtendedSystemState::kId;  // comes again once it is asked for
  (void)rig.uart.write(
      station.encode(mavlink::CommandLong{{1, 1}, mavlink::kCommandSetMessageInterval, 0, {landed_state, -1}}));
  rig.run(0.1);
  Settings settings = usual_settings();
  settings.engage_at_start = true;
  InlineWorker worker(rig.planner_spans());
  static CompanionStorage<kCapacity> memory;
  Companion second(settings, classroom(), memory.memory(), {rig.uart, worker});
  for (int i = 0; i < 1500 && second.telemetry().phase != Phase::kMission; ++i) {
    rig.uart.advance(milliseconds(10));
    second.step(rig.sim.time());
    const bool in_control = second.telemetry().phase != Phase::kGround;
    ASSERT_TRUE(second.telemetry().aligned || !in_control) << i;
  }
  EXPECT_EQ(second.telemetry().phase, Phase::kMission);
}

TEST(Companion, AClockThatJumpsBackDelaysNeitherTheHeartbeatNorALanding) {
  Rig rig;
  rig.clock_offset = std::chrono::seconds(100);
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  ASSERT_TRUE(rig.run_until(5, is_flying));
  rig.run(0.5);
  rig.clock_offset -= std::chrono::seconds(20);
  rig.step();
  EXPECT_EQ(rig.companion.telemetry().reason, Reason::kClockJump);
  const int before = rig.heartbeats();
  rig.run(3);
  EXPECT_GE(rig.heartbeats() - before, 2);
  EXPECT_TRUE(rig.companion.land());
  EXPECT_TRUE(rig.run_until(12, is_done)) << rig.notes();
}

TEST(Companion, AClockThatJumpsAheadEndsNeitherTheStandingNorTheTakeOff) {
  Rig rig;
  ASSERT_TRUE(rig.arm_on_the_ground());
  rig.run(1);
  rig.clock_offset += std::chrono::seconds(25);
  rig.run(2);
  EXPECT_FALSE(rig.companion.telemetry().aligned);
  ASSERT_TRUE(rig.run_until(10, [](const Telemetry& t) { return t.phase == Phase::kTakeoff; })) << rig.notes();
  rig.run(1);
  rig.clock_offset += std::chrono::seconds(25);
  EXPECT_TRUE(rig.run_until(20, [](const Telemetry& t) { return t.phase == Phase::kMission; })) << rig.notes();
}

TEST(Companion, AMapReplacedUnderWayStopsTheFlightAndItGoesOnInTheNewOne) {
  static const std::vector<std::byte> blob = classroom_blob(0.29);
  const BoxGraphView other = *BoxGraphView::open(blob);
  static const std::vector<std::byte> tight_blob = classroom_blob(0.2);
  Rig rig;
  rig.maps.insert(rig.maps.end(), {other, *BoxGraphView::open(tight_blob)});
  ASSERT_TRUE(rig.take_off());
  EXPECT_TRUE(rig.companion.add_goal(kFar));
  ASSERT_TRUE(rig.run_until(5, is_flying));
  rig.run(1);
  EXPECT_FALSE(rig.companion.replace_map(*BoxGraphView::open(tight_blob)));
  EXPECT_TRUE(rig.companion.replace_map(other));
  ASSERT_TRUE(rig.run_until(0.1, [](const Telemetry& t) { return t.state == FlightState::kBraking; })) << rig.notes();
  EXPECT_EQ(rig.companion.telemetry().reason, Reason::kMapReplaced);
  EXPECT_TRUE(rig.run_until(30, [](const Telemetry& t) { return t.goals_reached == 1; })) << rig.notes();
  EXPECT_EQ(rig.companion.telemetry().plan.map_crc, other.header().crc32);
}

TEST(Companion, ALineThatTakesLittleAndRefusedWordsAreReplayedToo) {
  Rig rig(usual_settings(), usual_sim(), classroom(), 3);
  for (int i = 0; i < 100; ++i) {
    rig.uart.room = static_cast<std::size_t>(i % 7) * 9;
    rig.step();
  }
  rig.uart.room = 1000;
  ASSERT_TRUE(rig.take_off());
  EXPECT_FALSE(rig.companion.add_goal({1, std::nan(""), 1}));
  for (std::size_t i = 0; i < Companion::kMostWords; ++i) EXPECT_TRUE(rig.companion.add_goal(kFar, Real(0.1)));
  EXPECT_FALSE(rig.companion.add_goal(kFar));
  rig.run(2);
  rig.uart.room = 20;  // neither the text of a map's refusal nor a set-point fits
  static const std::vector<std::byte> blob = classroom_blob(0.2);
  rig.maps.push_back(*BoxGraphView::open(blob));
  EXPECT_FALSE(rig.companion.replace_map(rig.maps.back()));
  rig.run(0.05);
  rig.uart.room = 1000;
  rig.run(2);
}

TEST(Companion, AFullLogIsNotedTheFlightGoesOnAndNoOtherOneStarts) {
  Settings settings = usual_settings();
  settings.land_at_end = true;
  Rig rig(settings);
  tools::MemoryStorage storage;
  tools::FillableStorage fillable(storage);
  FlightLog log(fillable);
  ASSERT_TRUE(log.begin("full.ulg", 0, {"1", "test", "{}", classroom().header().crc32}));
  InlineWorker worker(rig.planner_spans());
  static CompanionStorage<kCapacity> memory;
  Companion companion(settings, classroom(), memory.memory(), {rig.uart, worker, &log});
  const auto run_until = [&](double seconds, const auto& condition) {
    for (int i = 0; i < std::lround(seconds * 100) && !condition(companion.telemetry()); ++i) {
      rig.uart.advance(milliseconds(10));
      companion.step(rig.sim.time());
    }
    return condition(companion.telemetry());
  };
  EXPECT_TRUE(companion.engage(true));
  ASSERT_TRUE(run_until(30, [](const Telemetry& t) { return t.phase == Phase::kMission; }));
  fillable.fill();
  EXPECT_TRUE(companion.add_goal(kFar));
  EXPECT_TRUE(run_until(60, is_done));
  EXPECT_EQ(companion.telemetry().goals_reached, 1U);
  bool noted = false;
  for (std::uint32_t n = 0; n < companion.event_count(); ++n) {
    noted = noted || companion.event(n).reason == Reason::kStorageFull;
  }
  EXPECT_TRUE(noted);
  EXPECT_TRUE(companion.engage(true));
  EXPECT_FALSE(run_until(10, [](const Telemetry& t) { return t.armed; }));
  EXPECT_EQ(companion.telemetry().reason, Reason::kStorageFull);
}

// ---- The autopilot's parameters

/// A vehicle that hovers at a fifth of full thrust, and an autopilot that knows it.
PixhawkSimSettings strong_sim() {
  PixhawkSimSettings sim = usual_sim();
  tools::VehicleModel& model = sim.simulation.vehicle;
  model.thrust_max = model.mass * 9.80665 / 0.2;
  sim.simulation.hover_thrust = 0.2;
  return sim;
}

/// How far [m] the vehicle rises above its reference in the four seconds after the climb, when thrust is our own.
double overshoot(Rig& rig) {
  double most = 0;
  EXPECT_TRUE(rig.companion.engage(true));
  EXPECT_TRUE(rig.run_until(30, [](const Telemetry& t) { return t.form == SetpointForm::kAttitude && t.sent; }));
  for (int i = 0; i < 400; ++i) {
    rig.step();
    const double height = rig.sim.simulation().truth().position.z();
    most = std::max(most, height - rig.companion.telemetry().reference.sample.position.z());
  }
  return most;
}

TEST(CompanionParameters, AHoverThrustThatIsAskedForStartsBetter) {
  Settings configured = usual_settings();
  configured.asks_hover_thrust = false;
  Rig guessing(configured, strong_sim());
  Rig asking(usual_settings(), strong_sim());
  EXPECT_GT(overshoot(guessing), kTube);
  EXPECT_LT(overshoot(asking), 0.03);
  EXPECT_NEAR(asking.companion.telemetry().hover_thrust, 0.2, 0.02);
  EXPECT_NE(asking.notes().find("hover thrust 0.20 of the autopilot"), std::string::npos) << asking.notes();
  EXPECT_EQ(guessing.notes().find("of the autopilot"), std::string::npos) << guessing.notes();
}

TEST(CompanionParameters, AHoverThrustBeyondTheBoundsIsBounded) {
  PixhawkSimSettings sim = usual_sim();
  sim.simulation.hover_thrust = 0.95;
  Rig rig(usual_settings(), sim);
  rig.run(1);
  EXPECT_EQ(rig.companion.telemetry().hover_thrust, 0.8);
}

TEST(CompanionParameters, NobodyWaitsForAnAutopilotThatDoesNotAnswer) {
  TimeUs armed_at[2]{};
  for (const bool silent : {false, true}) {
    Rig rig;
    rig.uart.loses_questions = silent;
    ASSERT_TRUE(rig.arm_on_the_ground()) << rig.notes();
    armed_at[silent] = rig.companion.telemetry().time;
    EXPECT_EQ(rig.companion.telemetry().hover_thrust, 0.5);
    const int asked =
        rig.count_sent([](const mavlink::Frame& frame) { return frame.id == mavlink::ParameterRequest::kId; });
    EXPECT_LE(asked, silent ? 8 : 2);
    EXPECT_GE(asked, silent ? 4 : 2);
  }
  EXPECT_EQ(armed_at[0], armed_at[1]);
}

TEST(CompanionParameters, ATimeOfLossThatIsTooShortIsToldBeforeTheFlight) {
  for (const double seconds : {0.5, 0.9, 1.0}) {
    Rig rig;
    rig.autopilot().set_parameter(tools::ParameterIndex::kOffboardLossTime, seconds);
    rig.run(1);
    const bool told = rig.notes().find("COM_OF_LOSS_T is 0.50 s") != std::string::npos;
    EXPECT_EQ(told, seconds < 0.9) << rig.notes();
    EXPECT_TRUE(rig.arm_on_the_ground());
  }
}

TEST(CompanionParameters, AreAskedForAgainWhenTheAutopilotHasRestarted) {
  PixhawkSimSettings sim = usual_sim();
  sim.faults = {*tools::parse_fault("restart@2+0.5")};
  Rig rig(usual_settings(), sim);
  rig.run(1.9);
  const auto asked = [&] {
    return rig.count_sent([](const mavlink::Frame& frame) { return frame.id == mavlink::ParameterRequest::kId; });
  };
  EXPECT_EQ(asked(), 2);
  rig.run(5);
  EXPECT_EQ(asked(), 4);
}

// ---- The link's other side

TEST(Companion, AGroundStationsGoalIsFlownToAndARefusedOneIsAnswered) {
  Rig rig;
  ASSERT_TRUE(rig.take_off());
  GroundStation station(rig);
  station.send_goal(kFar);
  EXPECT_TRUE(rig.run_until(30, [](const Telemetry& t) { return t.goals_reached == 1; })) << rig.notes();
  station.send_goal(kInTheScreen);
  rig.run(0.2);
  EXPECT_TRUE(station.heard("refused: goal_not_free"));
  station.send_command(21);
  EXPECT_TRUE(rig.run_until(30, is_done)) << rig.notes();
}

constexpr std::uint16_t kLand = 21;           // MAV_CMD_NAV_LAND
constexpr std::uint16_t kMissionStart = 300;  // MAV_CMD_MISSION_START

TEST(Companion, ACommandThatCannotBeCarriedOutIsRejected) {
  using mavlink::CommandResult;
  PixhawkSimSettings sim = usual_sim();
  sim.faults = {*tools::parse_fault("odometry-nan@0.2+0.5")};
  Rig rig(usual_settings(), sim);
  GroundStation station(rig);
  const auto answer_to = [&](std::uint16_t command) {
    station.send_command(command);
    rig.run(0.1);
    return station.answer(command);
  };
  rig.run(0.6);
  EXPECT_EQ(answer_to(kMissionStart), CommandResult::kTemporarilyRejected);  // no estimate
  rig.run(1);
  EXPECT_EQ(rig.companion.telemetry().state, FlightState::kIdle);
  EXPECT_EQ(answer_to(kLand), CommandResult::kTemporarilyRejected);
  EXPECT_TRUE(rig.companion.block(1, {kStart - Vector3::Constant(0.1), kStart + Vector3::Constant(0.1)}));
  rig.run(3.5);  // a command that comes again sooner would be a repetition
  EXPECT_EQ(answer_to(kMissionStart), CommandResult::kTemporarilyRejected);
  EXPECT_TRUE(rig.companion.unblock(1));
  rig.run(3.5);
  EXPECT_EQ(rig.companion.telemetry().state, FlightState::kIdle);
  EXPECT_EQ(answer_to(kMissionStart), CommandResult::kAccepted);
  ASSERT_TRUE(rig.run_until(30, [](const Telemetry& t) { return t.phase == Phase::kMission; })) << rig.notes();
  EXPECT_EQ(answer_to(kLand), CommandResult::kAccepted);
  EXPECT_TRUE(rig.run_until(30, is_done)) << rig.notes();
}

TEST(Companion, AStartInAMapThatDoesNotCoverTheMarginsIsRejected) {
  Settings settings = usual_settings();
  settings.margins.vehicle_radius = 0.13;
  Rig rig(settings);
  GroundStation station(rig);
  rig.run(1);
  station.send_command(kMissionStart);
  rig.run(0.1);
  EXPECT_EQ(station.answer(kMissionStart), mavlink::CommandResult::kTemporarilyRejected);
}

/// The goal over the link is reached: the `count`th.
bool reaches(Rig& rig, std::uint32_t count) {
  return rig.run_until(30, [count](const Telemetry& t) { return t.goals_reached == count; });
}

constexpr double kSilence = 3.1;  // [s] after which a goal over the link is no repetition

TEST(Companion, ALinkGoalOfTheSamePlaceWithAnotherYawIsNews) {
  Rig rig;
  ASSERT_TRUE(rig.take_off());
  GroundStation station(rig);
  station.send_goal(kSide, 0);
  ASSERT_TRUE(reaches(rig, 1)) << rig.notes();
  station.send_goal(kSide, 1.57);
  ASSERT_TRUE(reaches(rig, 2)) << rig.notes();
  EXPECT_NEAR(tools::yaw_of(rig.sim.simulation().truth().attitude), 1.57, 0.15);
}

TEST(Companion, ALinkGoalIsFlownToAgainAfterAStop) {
  Rig rig;
  ASSERT_TRUE(rig.take_off());
  GroundStation station(rig);
  station.send_goal(kFar);
  ASSERT_TRUE(rig.run_until(5, is_flying));
  EXPECT_TRUE(rig.companion.stop());
  rig.run(kSilence);
  station.send_goal(kFar);
  EXPECT_TRUE(reaches(rig, 1)) << rig.notes();
}

TEST(Companion, ALinkGoalIsFlownToAgainAfterAnotherOne) {
  Rig rig;
  ASSERT_TRUE(rig.take_off());
  GroundStation station(rig);
  station.send_goal(kSide);
  ASSERT_TRUE(reaches(rig, 1)) << rig.notes();
  EXPECT_TRUE(rig.companion.set_goal(kBack));
  ASSERT_TRUE(reaches(rig, 2)) << rig.notes();
  station.send_goal(kSide);
  EXPECT_TRUE(reaches(rig, 3)) << rig.notes();
}

TEST(Companion, ALinkGoalThatWasRefusedIsTakenOnceItIsFree) {
  Rig rig;
  ASSERT_TRUE(rig.take_off());
  GroundStation station(rig);
  EXPECT_TRUE(rig.companion.block(7, {kSide - Vector3::Constant(0.1), kSide + Vector3::Constant(0.1)}));
  rig.run(0.1);
  station.send_goal(kSide);
  rig.run(0.1);
  ASSERT_TRUE(station.heard("refused: goal_not_free"));
  EXPECT_TRUE(rig.companion.unblock(7));
  for (double t = 0; t < kSilence; t += 0.2) {
    rig.run(0.2);
    station.send_goal(kSide);  // streamed
  }
  EXPECT_TRUE(reaches(rig, 1)) << rig.notes();
}

TEST(Companion, AStreamedLinkGoalIsFlownToOnceAndDoesNotUndoAStop) {
  Rig rig;
  ASSERT_TRUE(rig.take_off());
  GroundStation station(rig);
  const auto stream = [&](double seconds, const auto& condition) {
    for (double t = 0; t < seconds; t += 0.5) {
      station.send_goal(kFar);
      if (rig.run_until(0.5, condition)) return true;
    }
    return false;
  };
  ASSERT_TRUE(stream(30, [](const Telemetry& t) { return t.goals_reached == 1; })) << rig.notes();
  EXPECT_EQ(rig.companion.telemetry().plan.id, 1U) << rig.notes();
  EXPECT_FALSE(stream(5, [](const Telemetry& t) { return t.plan.id > 1; })) << rig.notes();
  rig.run(kSilence);
  EXPECT_TRUE(rig.companion.set_goal(kBack));
  ASSERT_TRUE(reaches(rig, 2)) << rig.notes();
  ASSERT_TRUE(stream(5, is_flying)) << rig.notes();
  EXPECT_TRUE(rig.companion.stop());
  ASSERT_TRUE(stream(3, is_holding)) << rig.notes();
  EXPECT_FALSE(stream(5, is_flying)) << rig.notes();
}

TEST(Companion, AGoalInTheLocalFrameIsRefusedUnlessTheFramesAreTied) {
  Rig rig;
  GroundStation station(rig);
  const auto send_goal_above = [&](double height) {
    station.send_local_goal(rig.sim.simulation().estimate().position + Vector3{0, 0, height});
    rig.run(0.1);
  };
  rig.run(1);
  send_goal_above(0.8);
  EXPECT_TRUE(station.heard("refused: the frames are not tied")) << rig.notes();
  EXPECT_EQ(rig.companion.telemetry().goals_waiting, 0U);
  ASSERT_TRUE(rig.take_off());
  send_goal_above(0.2);
  EXPECT_TRUE(rig.run_until(10, [](const Telemetry& t) { return t.goals_reached == 1; })) << rig.notes();
  EXPECT_TRUE(rig.companion.land());
  ASSERT_TRUE(rig.run_until(30, is_done)) << rig.notes();
  send_goal_above(0.8);  // the last flight's frame is not the next one's
  EXPECT_EQ(rig.companion.telemetry().goals_waiting, 0U);
}

// ---- ArduPilot, as its documentation has it: no flight of it was observed

/// A copter that takes set-points in GUIDED, climbs by MAV_CMD_NAV_TAKEOFF alone, which set-points end, tells its mode
/// by HEARTBEAT and streams what it is asked for. It follows perfectly well: what counts is what is said.
class ArduCopter final : public hal::Uart {
 public:
  enum Mode : std::uint32_t { kStabilize = 0, kGuided = 4, kLoiter = 5, kLand = 9 };

  std::size_t write(std::span<const std::byte> bytes) override {
    const std::size_t count = bytes.size();
    while (const auto frame = codec_.receive(bytes)) take(*frame);
    return count;
  }
  std::size_t read(std::span<std::byte> into) override {
    const std::size_t count = std::min(into.size(), outbox_.size());
    std::copy_n(outbox_.begin(), count, into.begin());
    outbox_.erase(outbox_.begin(), outbox_.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }
  [[nodiscard]] std::uint32_t overruns() const override { return 0; }

  void advance() {
    time += milliseconds(10);
    move(0.01);
    if (is_due(1000))
      send(mavlink::Heartbeat{mode, mavlink::kTypeQuadrotor, mavlink::kAutopilotArduPilot, base_mode()});
    if (is_due(20) && streams_) {
      send(mavlink::AttitudeQuaternion{time_ms(), mavlink::to_ned(mavlink::Quaternion::Identity()), {}});
      send(mavlink::LocalPositionNed{time_ms(), mavlink::to_ned(position), mavlink::to_ned(velocity_ + measured)});
    }
    if (is_due(200))
      send(mavlink::ExtendedSystemState{flies() ? mavlink::LandedState::kInAir : mavlink::LandedState::kOnGround});
  }
  [[nodiscard]] bool flies() const { return position.z() > kGround + 0.01; }

  Vector3 moved = Vector3::Zero();     // [m/s] that the estimate's position wanders by
  Vector3 measured = Vector3::Zero();  // [m/s] that its velocity is off by
  std::chrono::microseconds time{0};
  std::uint32_t mode = kStabilize;
  bool armed = false;
  Vector3 position{-4, 7, kGround};  // in its local frame
  int refusals_of_take_off = 0;
  std::vector<std::string> log;  // what was asked for, in order; without repetitions of refused ones
  int set_points_on_climb = 0;
  int set_points = 0;

 private:
  static constexpr double kGround = 0.3;        // the frame's origin is not where it stands
  static constexpr double kNearlyThere = 0.16;  // a little more than takeoff.tolerance

  [[nodiscard]] std::uint32_t time_ms() const { return static_cast<std::uint32_t>(time.count() / 1000); }
  [[nodiscard]] bool is_due(std::uint32_t period_ms) const { return time_ms() % period_ms == 0; }
  [[nodiscard]] std::uint8_t base_mode() const {
    return mavlink::kModeFlagCustom | (armed ? mavlink::kModeFlagArmed : 0);
  }

  void take(const mavlink::Frame& frame) {
    if (const auto command = mavlink::decode<mavlink::CommandLong>(frame)) {
      send(mavlink::CommandAck{command->command, obey(*command), frame.from});
    } else if (const auto target = mavlink::decode<mavlink::SetPositionTarget>(frame)) {
      follow(*target);
    } else if (const auto question = mavlink::decode<mavlink::TimeSyncMessage>(frame); question && question->tc1 == 0) {
      send(mavlink::TimeSyncMessage{time.count() * 1000, question->ts1});
    }
  }

  mavlink::CommandResult obey(const mavlink::CommandLong& command) {
    const auto is_asked_for = [&](std::uint32_t id) { return command.param[0] == static_cast<float>(id); };
    if (command.command == mavlink::kCommandSetMessageInterval) {
      streams_ = streams_ || is_asked_for(mavlink::LocalPositionNed::kId);
      return is_asked_for(mavlink::CurrentMode::kId) ? mavlink::CommandResult::kFailed
                                                     : mavlink::CommandResult::kAccepted;
    }
    if (command.command == mavlink::kCommandDoSetMode) {
      mode = static_cast<std::uint32_t>(command.param[1]);
      log.push_back("mode " + std::to_string(mode));
      return mavlink::CommandResult::kAccepted;
    }
    if (command.command == mavlink::kCommandArmDisarm) {
      armed = command.param[0] == 1;
      log.emplace_back(armed ? "arm" : "disarm");
      return mavlink::CommandResult::kAccepted;
    }
    return command.command == 22 ? take_off(command.param[6]) : mavlink::CommandResult::kUnsupported;
  }

  mavlink::CommandResult take_off(float height) {
    if (mode != kGuided || !armed || flies() || refusals_of_take_off-- > 0) return mavlink::CommandResult::kFailed;
    climbs_to_ = kGround + static_cast<double>(height);
    log.push_back("take off to " + std::to_string(std::lround(height * 100)));
    return mavlink::CommandResult::kAccepted;
  }

  void follow(const mavlink::SetPositionTarget& target) {
    ++set_points;
    if (mode != kGuided || !flies()) return;
    if (position.z() < climbs_to_ - kNearlyThere) ++set_points_on_climb;
    climbs_to_ = 0;
    target_ = target;
  }

  void move(double dt) {
    velocity_.setZero();
    if (mode == kLand) velocity_.z() = flies() ? -0.5 : 0;
    if (mode == kLand && !flies()) armed = false;
    if (mode == kGuided && climbs_to_ > 0) velocity_.z() = std::clamp(climbs_to_ - position.z(), 0.0, 0.5);
    if (mode == kGuided && climbs_to_ == 0 && target_) {
      velocity_ = mavlink::to_enu(target_->velocity) + 2 * (mavlink::to_enu(target_->position) - position);
    }
    position += (velocity_ + moved) * dt;
  }

  template <typename Message>
  void send(const Message& message) {
    const std::span<const std::byte> frame = codec_.encode(message);
    outbox_.insert(outbox_.end(), frame.begin(), frame.end());
  }

  mavlink::Codec codec_{{1, mavlink::kAutopilotComponent}};
  std::vector<std::byte> outbox_;
  bool streams_ = false;
  Vector3 velocity_ = Vector3::Zero();
  double climbs_to_ = 0;
  std::optional<mavlink::SetPositionTarget> target_;
};

/// A companion on the position form in the hall, with the copter at the other end.
class ArduRig {
 public:
  explicit ArduRig(const BoxGraphView& map = hall()) {
    Settings settings = usual_settings();
    settings.form = SetpointForm::kPosition;
    settings.start = {3.2, 3.2, 0};
    settings.takeoff.standing = kSecondUs;
    settings.land_at_end = true;
    companion_.emplace(settings, map, memory_->memory(), Devices{copter, worker_});
    EXPECT_TRUE(companion_->engage(true));
  }
  template <typename Condition>
  bool run_until(double seconds, const Condition& condition) {
    for (int i = 0; i < std::lround(seconds * 100); ++i) {
      copter.advance();
      companion_->step(copter.time);
      if (condition(companion_->telemetry())) return true;
    }
    return false;
  }
  Companion& companion() { return *companion_; }

  ArduCopter copter;

 private:
  std::unique_ptr<PlannerStorage<kCapacity>> planner_memory_ = std::make_unique<PlannerStorage<kCapacity>>();
  std::unique_ptr<CompanionStorage<kCapacity>> memory_ = std::make_unique<CompanionStorage<kCapacity>>();
  InlineWorker worker_{planner_memory_->spans(), 1};
  std::optional<Companion> companion_;
};

bool is_on_mission(const Telemetry& t) { return t.phase == Phase::kMission; }

TEST(CompanionWithArduPilot, FliesInGuidedAfterAClimbThatNoSetPointDisturbs) {
  ArduRig rig;
  ASSERT_TRUE(rig.run_until(20, is_on_mission));
  EXPECT_EQ(rig.companion().telemetry().autopilot, mavlink::AutopilotKind::kArduPilot);
  EXPECT_TRUE(rig.companion().add_goal({7, 3.2, 1.2}));
  EXPECT_TRUE(rig.companion().add_goal({7, 7, 1.2}));
  EXPECT_TRUE(rig.run_until(60, is_done));
  EXPECT_EQ(rig.companion().telemetry().goals_reached, 2U);
  EXPECT_EQ(rig.copter.log, (std::vector<std::string>{"mode 4", "arm", "take off to 80", "mode 9"}));
  EXPECT_EQ(rig.copter.set_points_on_climb, 0);
  EXPECT_GT(rig.copter.set_points, 1000);
  EXPECT_FALSE(rig.copter.armed);
}

TEST(CompanionWithArduPilot, FramesAreTiedToAVehicleThatStandsStill) {
  const auto is_aligned = [](const Telemetry& t) { return t.aligned; };
  ArduRig carried;
  carried.copter.moved = {0.5, 0, 0};
  EXPECT_FALSE(carried.run_until(20, is_aligned));
  carried.copter.moved.setZero();
  EXPECT_TRUE(carried.run_until(5, is_aligned));
  ArduRig moving;
  moving.copter.measured = {0, 0, 0.6};
  EXPECT_FALSE(moving.run_until(20, is_aligned));
  moving.copter.measured.setZero();
  EXPECT_TRUE(moving.run_until(5, is_aligned));
}

TEST(CompanionWithArduPilot, TheClimbEndsInFreeSpaceThoughLessWasAskedFor) {
  const std::vector<std::byte> blob = hall_blob(true);  // free from four voxels of 0.32 m on
  ArduRig rig(*BoxGraphView::open(blob));
  ASSERT_TRUE(rig.run_until(30, is_on_mission));
  ASSERT_EQ(rig.copter.log.size(), 3U);
  EXPECT_EQ(rig.copter.log.back(), "take off to 128");
  EXPECT_EQ(rig.copter.set_points_on_climb, 0);
}

TEST(CompanionWithArduPilot, ATakeOffThatIsRefusedIsAskedForAgainUntilPatienceEnds) {
  ArduRig patient;
  patient.copter.refusals_of_take_off = 3;
  EXPECT_TRUE(patient.run_until(20, is_on_mission));
  ArduRig refused;
  refused.copter.refusals_of_take_off = 1000;
  EXPECT_FALSE(refused.run_until(40, is_on_mission));
  EXPECT_EQ(refused.copter.log, (std::vector<std::string>{"mode 4", "arm", "mode 9"}));
  EXPECT_FALSE(refused.copter.armed);
}

TEST(CompanionWithArduPilot, ThePilotsModeEndsSetPointsAndRequests) {
  ArduRig rig;
  ASSERT_TRUE(rig.run_until(20, is_on_mission));
  EXPECT_TRUE(rig.companion().add_goal({7, 3.2, 1.2}));
  ASSERT_TRUE(rig.run_until(10, is_flying));
  rig.copter.mode = ArduCopter::kLoiter;
  ASSERT_TRUE(rig.run_until(1.5, has_yielded));  // HEARTBEAT comes once a second
  const int set_points = rig.copter.set_points;
  EXPECT_FALSE(rig.run_until(5, [](const Telemetry& t) { return t.state != FlightState::kYielded; }));
  EXPECT_EQ(rig.copter.set_points, set_points);
  EXPECT_EQ(rig.copter.log.size(), 3U);
}

}  // namespace
}  // namespace swiftlet::companion
