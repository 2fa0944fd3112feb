#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include "swiftlet/hal/fake_clock.hpp"
#include "swiftlet/hal/fake_line.hpp"
#include "swiftlet/mavlink/link.hpp"
#include "swiftlet_test.hpp"

namespace {

using namespace std::chrono_literals;
using namespace swiftlet::mavlink;  // NOLINT(google-build-using-namespace): every name below is from there
using swiftlet::Real;
using swiftlet::Vector3;

constexpr double kTolerance = 1e-5;  // float on the wire
constexpr Real kPi = std::numbers::pi_v<Real>;
constexpr Address kAutopilot{1, 1};
constexpr Address kGroundStation{255, 190};
constexpr std::uint32_t kPx4Offboard = 6U << 16U;
constexpr std::uint32_t kPx4Position = 3U << 16U;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

swiftlet::hal::FakeClock the_clock;

std::array<std::byte, 32> test_key() {
  std::array<std::byte, 32> key{};
  key.fill(std::byte{0x5A});
  return key;
}

/// A link and whoever sits at the other end of its line; the line is never faulty unless a test makes it so.
struct Bench {
  swiftlet::hal::FakeLine line{the_clock, 1};
  Link link;
  Codec autopilot{kAutopilot};
  Codec station{kGroundStation};
  Codec reader{kAutopilot};

  explicit Bench(const LinkConfig& config) : link(line.end_a(), config) {}

  void step() { link.step(the_clock.now()); }

  template <typename Message>
  void say(Codec& speaker, const Message& message) {
    line.end_b().write(speaker.encode(message));
    step();
  }
  template <typename Message>
  void say(const Message& message) {
    say(autopilot, message);
  }

  void say_heartbeat(std::uint32_t custom_mode, bool armed = false) {
    Heartbeat heartbeat;
    heartbeat.custom_mode = custom_mode;
    heartbeat.type = kTypeQuadrotor;
    heartbeat.autopilot = kAutopilotPx4;
    heartbeat.base_mode = static_cast<std::uint8_t>(kModeFlagCustom | (armed ? kModeFlagArmed : 0));
    heartbeat.system_status = SystemState::kStandby;
    say(heartbeat);
  }

  void acknowledge(std::uint16_t command, CommandResult result) {
    say(CommandAck{.command = command, .result = result, .target = {1, kPathPlannerComponent}});
  }

  /// Calls `use` with every frame that the link has sent since the last call.
  template <typename Use>
  void hear(Use&& use) {
    std::array<std::byte, 512> buffer{};
    while (const std::size_t count = line.end_b().read(buffer)) {
      std::span<const std::byte> bytes(buffer.data(), count);
      while (const auto frame = reader.receive(bytes)) use(*frame);
    }
  }

  /// The last message of a kind that the link has sent since; all others are passed over.
  template <typename Message>
  std::optional<Message> hear_last(int* count = nullptr) {
    std::optional<Message> last;
    if (count != nullptr) *count = 0;
    hear([&](const Frame& frame) {
      const auto message = decode<Message>(frame);
      if (!message.has_value()) return;
      last = message;
      if (count != nullptr) ++*count;
    });
    return last;
  }

  void run(std::chrono::milliseconds duration, std::chrono::milliseconds period = 10ms) {
    for (auto passed = 0ms; passed < duration; passed += period) {
      the_clock.advance(period);
      step();
    }
  }
};

LinkConfig without_rates() {
  LinkConfig config;
  config.rates = {};
  return config;
}

/// The bench of the running test: a static one, since a bare board has little stack and no heap.
Bench& fresh_bench(const LinkConfig& config) {
  static std::optional<Bench> bench;
  return bench.emplace(config);
}

Signing test_signing(std::uint64_t time) {
  Signing signing;
  signing.key = test_key();
  signing.time = time;
  return signing;
}

TEST(Link, SendsAHeartbeatOfThePathPlannerOnceASecond) {
  Bench& bench = fresh_bench(without_rates());
  bench.link.set_state(SystemState::kActive);
  bench.run(3000ms);
  int count = 0;
  bench.hear([&count](const Frame& frame) {
    const auto heartbeat = decode<Heartbeat>(frame);
    if (!heartbeat.has_value()) return;
    ++count;
    EXPECT_TRUE(frame.from == (Address{1, 195}));
    EXPECT_EQ(heartbeat->type, kTypeOnboardController);
    EXPECT_EQ(heartbeat->autopilot, kAutopilotInvalid);
    EXPECT_EQ(heartbeat->system_status, SystemState::kActive);
  });
  EXPECT_EQ(count, 3);
}

TEST(Link, ReadsTheAutopilotsState) {
  Bench& bench = fresh_bench(without_rates());
  EXPECT_FALSE(bench.link.autopilot().heard);
  bench.say_heartbeat(kPx4Offboard, true);
  bench.say(CurrentMode{.custom_mode = kPx4Position, .intended_custom_mode = kPx4Offboard});
  bench.say(SystemStatus{.sensors_health = kSensorPrearmCheck, .voltage_mv = 15200});
  bench.say(ExtendedSystemState{LandedState::kInAir});
  const AutopilotState& state = bench.link.autopilot();
  EXPECT_TRUE(state.heard && state.armed && state.prearm_ok);
  EXPECT_EQ(state.kind, AutopilotKind::kPx4);
  EXPECT_EQ(state.mode, Mode::kPosition);
  EXPECT_EQ(state.intended_mode, Mode::kOffboard);
  EXPECT_EQ(state.landed_state, LandedState::kInAir);
  EXPECT_EQ(state.battery_mv, 15200);
}

TEST(Link, CountsTheForeignTheUnusedAndTheLost) {
  Bench& bench = fresh_bench(without_rates());
  bench.say_heartbeat(0);
  bench.say(bench.station, Heartbeat{});                      // of a ground station
  bench.say(CommandLong{.target = {1, 0}, .command = 1000});  // PX4's gimbal manager
  bench.say(PositionTarget{});                                // of the autopilot, not ours to use
  EXPECT_EQ(bench.link.counters().foreign, 1);
  EXPECT_EQ(bench.link.counters().unused, 2);
  EXPECT_FALSE(bench.link.take_command().has_value());
  static_cast<void>(bench.autopilot.encode(Heartbeat{}));  // two that never arrive
  static_cast<void>(bench.autopilot.encode(Heartbeat{}));
  EXPECT_EQ(bench.link.counters().lost_frames, 0);
  bench.say_heartbeat(0);
  EXPECT_EQ(bench.link.counters().lost_frames, 2);
}

TEST(Link, AnAnnouncedJumpOfTheClockDelaysNothing) {
  Bench& bench = fresh_bench(without_rates());
  the_clock.advance(100s);
  bench.run(1500ms);
  EXPECT_TRUE(bench.link.request_arm(true));
  bench.run(100ms);
  bench.hear([](const Frame&) {});
  bench.link.shift_clock(-20s);
  int heartbeats = 0;
  int requests = 0;
  for (int i = 0; i < 100; ++i) {
    the_clock.advance(10ms);
    bench.link.step(the_clock.now() - 20s);
    bench.hear([&](const Frame& frame) {
      heartbeats += decode<Heartbeat>(frame).has_value() ? 1 : 0;
      requests += decode<CommandLong>(frame).has_value() ? 1 : 0;
    });
  }
  EXPECT_EQ(heartbeats, 1);
  EXPECT_EQ(requests, 3);
}

// ---- Requests

TEST(LinkRequests, AChangeOfModeIsDoneWhenItIsSeenNotWhenItIsAcknowledged) {
  Bench& bench = fresh_bench(without_rates());
  EXPECT_FALSE(bench.link.request_mode(Mode::kOffboard));  // of whom?
  bench.say_heartbeat(kPx4Position);
  EXPECT_TRUE(bench.link.request_mode(Mode::kOffboard));
  bench.step();
  const auto command = bench.hear_last<CommandLong>();
  ASSERT_TRUE(command.has_value());
  EXPECT_TRUE(command->target == kAutopilot);
  EXPECT_EQ(command->command, kCommandDoSetMode);
  EXPECT_EQ(command->param[0], 1.0F);
  EXPECT_EQ(command->param[1], 6.0F);
  EXPECT_EQ(command->param[2], 0.0F);
  bench.acknowledge(kCommandDoSetMode, CommandResult::kAccepted);
  EXPECT_FALSE(bench.link.take_outcome().has_value());
  bench.say(CurrentMode{.custom_mode = kPx4Offboard});
  const auto outcome = bench.link.take_outcome();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->kind, Outcome::Kind::kDone);
  EXPECT_EQ(outcome->command, kCommandDoSetMode);
}

TEST(LinkRequests, TheSecondAcknowledgementOfPx4IsTheOneThatCounts) {
  Bench& bench = fresh_bench(without_rates());
  bench.say_heartbeat(kPx4Position);
  bench.link.request_mode(Mode::kOffboard);
  bench.step();
  bench.acknowledge(kCommandDoSetMode, CommandResult::kAccepted);
  bench.acknowledge(kCommandDoSetMode, CommandResult::kTemporarilyRejected);
  const auto outcome = bench.link.take_outcome();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->kind, Outcome::Kind::kRejected);
  EXPECT_EQ(outcome->result, CommandResult::kTemporarilyRejected);
}

TEST(LinkRequests, AModeThatNeverShowsIsNoAnswer) {
  Bench& bench = fresh_bench(without_rates());
  bench.say_heartbeat(kPx4Position);
  bench.link.request_mode(Mode::kOffboard);
  bench.step();
  bench.acknowledge(kCommandDoSetMode, CommandResult::kAccepted);
  for (int i = 0; i < 2; ++i) {
    bench.run(1000ms);
    bench.say_heartbeat(kPx4Position);
  }
  EXPECT_FALSE(bench.link.take_outcome().has_value());
  bench.run(600ms);
  const auto outcome = bench.link.take_outcome();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->kind, Outcome::Kind::kNoAnswer);
}

TEST(LinkRequests, AreRepeatedThreeTimesWithTheCountOfRepetitions) {
  Bench& bench = fresh_bench(without_rates());
  EXPECT_TRUE(bench.link.request_arm(true));
  int transmissions = 0;
  for (int i = 0; i < 300; ++i) {
    bench.run(10ms);
    bench.hear([&transmissions](const Frame& frame) {
      const auto command = decode<CommandLong>(frame);
      if (!command.has_value()) return;
      EXPECT_EQ(command->command, kCommandArmDisarm);
      EXPECT_EQ(command->param[0], 1.0F);
      EXPECT_EQ(command->confirmation, transmissions++);
    });
  }
  EXPECT_EQ(transmissions, 4);
  const auto outcome = bench.link.take_outcome();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->kind, Outcome::Kind::kNoAnswer);
}

TEST(LinkRequests, ThatAreCancelledAreNotRepeatedButRatesAre) {
  Bench& bench = fresh_bench({});
  bench.say_heartbeat(kPx4Position);
  bench.run(20ms);
  EXPECT_TRUE(bench.link.request_arm(true));
  EXPECT_TRUE(bench.link.request_mode(Mode::kOffboard));
  bench.link.cancel_requests();
  int rates = 0;
  bench.run(1000ms);
  bench.hear([&rates](const Frame& frame) {
    const auto command = decode<CommandLong>(frame);
    if (!command.has_value()) return;
    EXPECT_EQ(command->command, kCommandSetMessageInterval);
    ++rates;
  });
  EXPECT_GE(rates, 4);
  EXPECT_FALSE(bench.link.take_outcome().has_value());
}

TEST(LinkRequests, AreCarriedOutOneAfterTheOther) {
  Bench& bench = fresh_bench(without_rates());
  EXPECT_TRUE(bench.link.request_arm(false));
  EXPECT_TRUE(bench.link.request(22, {0, 0, 0, kNan, kNan, kNan, 1.5F}));
  bench.run(20ms);
  auto command = bench.hear_last<CommandLong>();
  ASSERT_TRUE(command.has_value());
  EXPECT_EQ(command->command, kCommandArmDisarm);
  bench.acknowledge(22, CommandResult::kAccepted);  // not yet asked for
  EXPECT_EQ(bench.link.counters().stray_acknowledgements, 1);
  bench.acknowledge(kCommandArmDisarm, CommandResult::kDenied);
  auto outcome = bench.link.take_outcome();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->kind, Outcome::Kind::kRejected);
  EXPECT_EQ(outcome->result, CommandResult::kDenied);
  bench.step();
  command = bench.hear_last<CommandLong>();
  ASSERT_TRUE(command.has_value());
  EXPECT_EQ(command->command, 22);
  EXPECT_TRUE(std::isnan(command->param[3]));
  bench.acknowledge(22, CommandResult::kInProgress);
  bench.run(2000ms);
  EXPECT_FALSE(bench.hear_last<CommandLong>().has_value());  // it is being done: no repetition
  bench.acknowledge(22, CommandResult::kAccepted);
  outcome = bench.link.take_outcome();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->kind, Outcome::Kind::kDone);
}

TEST(LinkRequests, AcknowledgementsForOthersAreNotOurs) {
  Bench& bench = fresh_bench(without_rates());
  bench.link.request_arm(true);
  bench.step();
  bench.say(CommandAck{.command = kCommandArmDisarm, .result = CommandResult::kAccepted, .target = kGroundStation});
  EXPECT_FALSE(bench.link.take_outcome().has_value());
  bench.say(bench.station, CommandAck{.command = kCommandArmDisarm, .target = {1, 195}});
  EXPECT_FALSE(bench.link.take_outcome().has_value());
  bench.say(CommandAck{.command = kCommandArmDisarm});  // an old sender names no target
  EXPECT_TRUE(bench.link.take_outcome().has_value());
}

TEST(LinkRequests, ModesHaveTheNumbersOfEachAutopilot) {
  const auto px4_hold = set_mode_command(AutopilotKind::kPx4, Mode::kHold);
  ASSERT_TRUE(px4_hold.has_value());
  EXPECT_EQ(px4_hold->param[1], 4.0F);
  EXPECT_EQ(px4_hold->param[2], 3.0F);
  const auto guided = set_mode_command(AutopilotKind::kArduPilot, Mode::kOffboard);
  ASSERT_TRUE(guided.has_value());
  EXPECT_EQ(guided->param[1], 4.0F);
  EXPECT_EQ(guided->param[2], 0.0F);
  EXPECT_FALSE(set_mode_command(AutopilotKind::kArduPilot, Mode::kTakeoff).has_value());
  EXPECT_FALSE(set_mode_command(AutopilotKind::kUnknown, Mode::kOffboard).has_value());
  EXPECT_EQ(mode_of(AutopilotKind::kPx4, 4U << 16U | 6U << 24U), Mode::kLand);
  EXPECT_EQ(mode_of(AutopilotKind::kPx4, 1U << 16U), Mode::kOther);
  EXPECT_EQ(mode_of(AutopilotKind::kArduPilot, 9), Mode::kLand);
  EXPECT_EQ(mode_of(AutopilotKind::kArduPilot, 16), Mode::kPosition);
}

/// Plays an autopilot that accepts every message rate; how many it was asked for.
int count_rates(Bench& bench) {
  int rates = 0;
  for (int i = 0; i < 60; ++i) {
    bench.run(10ms);
    bool asked = false;
    bench.hear([&](const Frame& frame) {
      const auto command = decode<CommandLong>(frame);
      asked = asked || (command.has_value() && command->command == kCommandSetMessageInterval);
    });
    if (!asked) continue;
    ++rates;
    bench.acknowledge(kCommandSetMessageInterval, CommandResult::kAccepted);
  }
  return rates;
}

TEST(LinkRates, AreAskedForWhenTheAutopilotComesAndWhenItComesBack) {
  Bench& bench = fresh_bench(LinkConfig{});
  const auto all = static_cast<int>(default_rates().size());
  EXPECT_EQ(count_rates(bench), 0);  // nobody there
  bench.say_heartbeat(0);
  EXPECT_EQ(count_rates(bench), all);
  bench.say_heartbeat(0);
  EXPECT_EQ(count_rates(bench), 0);
  bench.run(3500ms, 100ms);
  bench.say_heartbeat(0);  // after a silence
  EXPECT_EQ(count_rates(bench), all);
  bench.say(LocalPositionNed{.time_boot_ms = 60'000});
  bench.say(LocalPositionNed{.time_boot_ms = 400});  // it has restarted
  EXPECT_EQ(bench.link.autopilot().restarts, 1);
  EXPECT_EQ(count_rates(bench), all);
  EXPECT_FALSE(bench.link.take_outcome().has_value());
  EXPECT_EQ(bench.link.counters().refused_rates, 0);
}

// ---- The estimate, and set-points

TEST(LinkState, TurnsTheEstimateIntoTheMapsFrame) {
  Bench& bench = fresh_bench(without_rates());
  EXPECT_FALSE(bench.link.align({0, 0, 0}, 0));
  // 1 m north, 2 m east, 0.5 m up of the origin, facing north.
  bench.say(LocalPositionNed{.time_boot_ms = 1, .position = {{1, 2, Real(-0.5)}}, .velocity = {{3, 0, -1}}});
  bench.say(AttitudeQuaternion{.time_boot_ms = 1, .body_rates = {{Real(0.1), Real(0.2), Real(0.3)}}});
  VehicleState state = bench.link.vehicle();
  EXPECT_TRUE(state.has_position && state.has_attitude);
  EXPECT_NEAR(state.position.x(), 2, kTolerance);
  EXPECT_NEAR(state.position.z(), 0.5, kTolerance);
  EXPECT_NEAR(state.velocity.y(), 3, kTolerance);
  EXPECT_NEAR(yaw_of(state.attitude), kPi / 2, kTolerance);
  EXPECT_NEAR(state.body_rates.y(), -0.2, kTolerance);
  EXPECT_EQ(state.position_received_at, the_clock.now());
  // On the map it stands at (10, 20, 0) and faces the map's x.
  EXPECT_FALSE(bench.link.aligned());
  EXPECT_TRUE(bench.link.align({10, 20, 0}, 0));
  state = bench.link.vehicle();
  EXPECT_NEAR(state.position.x(), 10, kTolerance);
  EXPECT_NEAR(state.position.y(), 20, kTolerance);
  EXPECT_NEAR(state.velocity.x(), 3, kTolerance);  // it flies forward
  EXPECT_NEAR(yaw_of(state.attitude), 0, kTolerance);
  bench.say(LocalPositionNed{.time_boot_ms = 2, .position = {{2, 2, Real(-0.5)}}});
  EXPECT_NEAR(bench.link.vehicle().position.x(), 11, kTolerance);
}

TEST(LinkState, TakesOdometryWithItsVelocityInTheBodyOrInTheLocalFrame) {
  Bench& bench = fresh_bench(without_rates());
  Odometry odometry;
  odometry.position.value = {1, 2, -3};
  // Facing east: 90 degrees of yaw from north.
  odometry.attitude.value = Quaternion(std::sqrt(Real(0.5)), 0, 0, std::sqrt(Real(0.5)));
  odometry.velocity_child = {1, 0, 0};
  odometry.reset_counter = 3;
  bench.say(odometry);
  VehicleState state = bench.link.vehicle();
  EXPECT_NEAR(state.position.x(), 2, kTolerance);
  EXPECT_NEAR(state.velocity.x(), 1, kTolerance);  // forward is east
  EXPECT_NEAR(yaw_of(state.attitude), 0, kTolerance);
  EXPECT_EQ(state.reset_counter, 3);
  odometry.child_frame = kFrameLocalNed;
  bench.say(odometry);
  EXPECT_NEAR(bench.link.vehicle().velocity.y(), 1, kTolerance);  // north
  odometry.child_frame = 0;
  bench.say(odometry);
  EXPECT_EQ(bench.link.counters().refused_values, 1);
}

TEST(LinkState, KeepsTheOldEstimateWhenTheNewOneIsNoNumber) {
  Bench& bench = fresh_bench(without_rates());
  bench.say(LocalPositionNed{.time_boot_ms = 1, .position = {{1, 2, -3}}});
  bench.say(AttitudeQuaternion{.time_boot_ms = 1});
  const auto then = the_clock.now();
  the_clock.advance(100ms);
  bench.say(LocalPositionNed{.time_boot_ms = 101, .position = {{1, Real(kNan), -3}}});
  bench.say(AttitudeQuaternion{.time_boot_ms = 101, .attitude = {Quaternion(0, 0, 0, 0)}});
  bench.say(AttitudeQuaternion{.time_boot_ms = 101, .attitude = {Quaternion(Real(kNan), 0, 0, 0)}});
  Odometry odometry;
  odometry.attitude.value = Quaternion(1, 0, Real(kNan), 0);
  bench.say(odometry);
  const VehicleState state = bench.link.vehicle();
  EXPECT_EQ(state.position_received_at, then);
  EXPECT_EQ(state.attitude_received_at, then);
  EXPECT_EQ(state.position_count, 1);
  EXPECT_NEAR(state.position.x(), 2, kTolerance);
  EXPECT_EQ(bench.link.counters().refused_values, 4);
}

TEST(LinkSetpoints, LeaveInTheAutopilotsFrame) {
  Bench& bench = fresh_bench(without_rates());
  bench.say(LocalPositionNed{.position = {{1, 2, Real(-0.5)}}});
  bench.say(AttitudeQuaternion{});                // facing north
  ASSERT_TRUE(bench.link.align({10, 20, 0}, 0));  // which is the map's x
  PositionSetpoint setpoint;
  setpoint.position = {13, 21, 1};  // 3 m forward, 1 m left, 1 m up
  setpoint.velocity = {1, 2, 3};
  setpoint.acceleration = {4, 5, 6};
  setpoint.yaw = kPi / 2;  // to the left: west
  setpoint.yaw_rate = Real(0.25);
  EXPECT_TRUE(bench.link.send(setpoint));
  const auto target = bench.hear_last<SetPositionTarget>();
  ASSERT_TRUE(target.has_value());
  EXPECT_TRUE(target->target == kAutopilot);
  EXPECT_EQ(target->frame, kFrameLocalNed);
  EXPECT_EQ(target->type_mask, 0);
  const std::array<double, 9> expected{4, 1, -1.5, 1, -2, -3, 4, -5, -6};
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    EXPECT_NEAR(target->position.value[axis], expected[i], kTolerance);
    EXPECT_NEAR(target->velocity.value[axis], expected[i + 3], kTolerance);
    EXPECT_NEAR(target->acceleration.value[axis], expected[i + 6], kTolerance);
  }
  EXPECT_NEAR(target->yaw, -kPi / 2, kTolerance);
  EXPECT_NEAR(target->yaw_rate, -0.25, kTolerance);
}

TEST(LinkSetpoints, AttitudeAndRatesAreOneMessageWithDifferentMasks) {
  Bench& bench = fresh_bench(without_rates());
  EXPECT_TRUE(bench.link.send(AttitudeSetpoint{.attitude = Quaternion(1, 0, 0, 0), .thrust = Real(0.5)}));
  auto target = bench.hear_last<SetAttitudeTarget>();
  ASSERT_TRUE(target.has_value());
  EXPECT_EQ(target->type_mask, kIgnoreBodyRates);
  EXPECT_NEAR(std::abs(target->attitude.value.w()), std::sqrt(0.5), kTolerance);  // east: 90 degrees from north
  EXPECT_NEAR(target->thrust, 0.5, kTolerance);
  EXPECT_TRUE(bench.link.send(RateSetpoint{.body_rates = {1, 2, 3}, .thrust = 1}));
  target = bench.hear_last<SetAttitudeTarget>();
  ASSERT_TRUE(target.has_value());
  EXPECT_EQ(target->type_mask, kIgnoreAttitude);
  EXPECT_NEAR(target->body_rates.value.y(), -2, kTolerance);
  EXPECT_NEAR(target->body_rates.value.z(), -3, kTolerance);
}

TEST(LinkSetpoints, ThatAreNoNumbersNeverLeave) {
  Bench& bench = fresh_bench(without_rates());
  bench.step();
  bench.hear([](const Frame&) {});
  PositionSetpoint position;
  position.acceleration.z() = Real(kNan);
  EXPECT_FALSE(bench.link.send(position));
  EXPECT_FALSE(bench.link.send(AttitudeSetpoint{.thrust = Real(kNan)}));
  EXPECT_FALSE(bench.link.send(AttitudeSetpoint{.thrust = Real(1.01)}));
  EXPECT_FALSE(bench.link.send(AttitudeSetpoint{.attitude = Quaternion(0, 0, 0, 0), .thrust = Real(0.5)}));
  EXPECT_FALSE(bench.link.send(RateSetpoint{.body_rates = {Real(kNan), 0, 0}, .thrust = Real(0.5)}));
  EXPECT_FALSE(bench.link.send(RateSetpoint{.thrust = Real(-0.01)}));
  EXPECT_EQ(bench.link.counters().refused_setpoints, 6);
  int frames = 0;
  bench.hear([&frames](const Frame&) { ++frames; });
  EXPECT_EQ(frames, 0);
}

/// A device that takes so many bytes and no more.
class SmallUart final : public swiftlet::hal::Uart {
 public:
  std::size_t room = 0;
  std::size_t taken = 0;
  std::size_t write(std::span<const std::byte> bytes) override {
    const std::size_t count = std::min(room, bytes.size());
    std::copy_n(bytes.begin(), count, sent_.begin() + static_cast<std::ptrdiff_t>(taken));
    taken += count;
    room -= count;
    return count;
  }
  std::size_t read(std::span<std::byte> /*into*/) override { return 0; }
  [[nodiscard]] std::uint32_t overruns() const override { return 0; }
  [[nodiscard]] std::span<const std::byte> sent() const { return std::span(sent_).first(taken); }

 private:
  std::array<std::byte, 1024> sent_{};
};

/// The rates about x that a receiver finds in the bytes, as the digits of a number.
double rates_read(Codec& reader, std::span<const std::byte> bytes) {
  double digits = 0;
  while (const auto frame = reader.receive(bytes)) {
    if (const auto target = decode<SetAttitudeTarget>(*frame)) digits = 10 * digits + target->body_rates.value.x();
  }
  return digits;
}

TEST(LinkSetpoints, AFullDeviceGetsWholeFramesAndNothingStale) {
  static SmallUart uart;
  static Link link(uart, without_rates());
  uart.room = 21 + 10;  // the heartbeat and the beginning of a set-point
  link.step(the_clock.now());
  EXPECT_TRUE(link.send(RateSetpoint{.body_rates = {1, 0, 0}}));
  EXPECT_FALSE(link.send(RateSetpoint{.body_rates = {2, 0, 0}}));  // the first one's rest still waits
  EXPECT_EQ(link.counters().unsent_frames, 1);
  uart.room = 1000;
  EXPECT_TRUE(link.send(RateSetpoint{.body_rates = {3, 0, 0}}));
  Codec reader(kAutopilot);
  EXPECT_NEAR(rates_read(reader, uart.sent()), 13, kTolerance);
  EXPECT_EQ(reader.counters().skipped_bytes, 0);
}

TEST(LinkSetpoints, TheRestOfAFrameThatTheDeviceHeldUpIsDropped) {
  static SmallUart uart;
  static Link link(uart, without_rates());
  uart.room = 21 + 10;  // the heartbeat and the beginning of a set-point
  link.step(the_clock.now());
  EXPECT_TRUE(link.send(RateSetpoint{.body_rates = {1, 0, 0}}));
  the_clock.advance(50ms);
  link.step(the_clock.now());
  uart.room = 1000;
  the_clock.advance(10ms);
  link.step(the_clock.now());
  EXPECT_EQ(link.counters().unsent_frames, 1);
  EXPECT_EQ(link.counters().sent_frames, 1);  // the heartbeat
  EXPECT_EQ(uart.taken, 21U + 10U);
  // The receiver finds what follows inside of the frame whose end is missing.
  for (const int rate : {2, 3, 4, 5, 6}) EXPECT_TRUE(link.send(RateSetpoint{.body_rates = {Real(rate), 0, 0}}));
  Codec reader(kAutopilot);
  EXPECT_NEAR(rates_read(reader, uart.sent()), 23456, kTolerance);
}

// ---- Time

TEST(LinkTime, MeetsAClockBehindALongRoundTrip) {
  Bench& bench = fresh_bench(without_rates());
  bench.line.a_to_b().delay = 350ms;
  bench.line.b_to_a().delay = 350ms;
  bench.run(20ms);
  bench.say_heartbeat(0);
  for (int i = 0; i < 250; ++i) {
    bench.run(10ms);
    std::optional<TimeSyncMessage> answer;
    bench.hear([&answer](const Frame& frame) {
      if (const auto request = decode<TimeSyncMessage>(frame)) answer = request;
    });
    if (!answer.has_value()) continue;
    answer->tc1 = std::chrono::nanoseconds(the_clock.now() + 90s).count();
    bench.say(*answer);
    bench.say(*answer);  // twice: the second is none of ours
  }
  ASSERT_TRUE(bench.link.time_sync().synchronised());
  EXPECT_EQ(bench.link.time_sync().round_trip(), std::chrono::nanoseconds(700ms));
  EXPECT_EQ(bench.link.time_sync().offset(), std::chrono::nanoseconds(90s));
}

TEST(LinkTime, StampsOfAnotherClockInOneMessageAreNoRestart) {
  Bench& bench = fresh_bench(without_rates());
  constexpr std::uint64_t kToday = 1'700'000'000'000'000;  // [us] since 1970
  for (std::uint32_t i = 0; i < 10; ++i) {
    bench.say(LocalPositionNed{.time_boot_ms = 60'000 + 20 * i});
    Odometry odometry;
    odometry.time_us = kToday + 20'000U * std::uint64_t{i};
    bench.say(odometry);
    bench.say(AttitudeQuaternion{.time_boot_ms = 60'000 + 20 * i});
  }
  EXPECT_EQ(bench.link.autopilot().restarts, 0);
  bench.say(LocalPositionNed{.time_boot_ms = 400});
  bench.say(AttitudeQuaternion{.time_boot_ms = 400});  // of the same restart
  EXPECT_EQ(bench.link.autopilot().restarts, 1);
  bench.say(AttitudeQuaternion{.time_boot_ms = 60'000});
  bench.say(AttitudeQuaternion{.time_boot_ms = 400});
  EXPECT_EQ(bench.link.autopilot().restarts, 2);
}

TEST(LinkTime, AnswersRequestsAtOnceAndMeetsTheAutopilotsClock) {
  Bench& bench = fresh_bench(without_rates());
  bench.run(20ms);
  bench.say_heartbeat(0);
  bench.hear([](const Frame&) {});
  bench.say(TimeSyncMessage{.tc1 = 0, .ts1 = 777});
  const auto answer = bench.hear_last<TimeSyncMessage>();
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->ts1, 777);
  EXPECT_EQ(answer->tc1, std::chrono::nanoseconds(the_clock.now()).count());
  // The autopilot's clock is 90 s ahead; it answers in the middle of a round trip of 4 ms.
  constexpr auto kAhead = 90s;
  for (int i = 0; i < 10; ++i) {
    bench.run(200ms, 200ms);
    const auto request = bench.hear_last<TimeSyncMessage>();
    ASSERT_TRUE(request.has_value());
    EXPECT_EQ(request->tc1, 0);
    the_clock.advance(4ms);
    const auto theirs = std::chrono::nanoseconds(the_clock.now() - 2ms + kAhead).count();
    bench.say(TimeSyncMessage{.tc1 = theirs, .ts1 = request->ts1});
  }
  ASSERT_TRUE(bench.link.time_sync().synchronised());
  EXPECT_EQ(bench.link.time_sync().offset(), std::chrono::nanoseconds(kAhead));
  EXPECT_EQ(bench.link.time_sync().round_trip(), std::chrono::nanoseconds(4ms));
  // A sample of 15 ms ago.
  const auto sampled = std::chrono::duration_cast<std::chrono::milliseconds>(the_clock.now() - 15ms + kAhead);
  bench.say(LocalPositionNed{.time_boot_ms = static_cast<std::uint32_t>(sampled.count())});
  const auto age = bench.link.vehicle().position_received_at - bench.link.vehicle().position_sampled_at;
  EXPECT_GE(age, 15ms);
  EXPECT_LT(age, 16ms);
}

TEST(TimeSync, TakesTheShortestRoundTripAndRejectsWhatContradictsIt) {
  TimeSync sync;
  const auto round_trip = [&sync](std::chrono::nanoseconds at, std::chrono::nanoseconds there,
                                  std::chrono::nanoseconds back, std::chrono::nanoseconds ahead) {
    sync.add(at, at + there + ahead, at + there + back);
  };
  round_trip(1s, 2ms, 30ms, 5s);  // delayed on its way back: 14 ms off
  EXPECT_FALSE(sync.synchronised());
  round_trip(2s, 1ms, 1ms, 5s);
  round_trip(3s, 1ms, 2ms, 5s);
  round_trip(4s, 50ms, 1ms, 5s);
  EXPECT_TRUE(sync.synchronised());
  EXPECT_EQ(sync.offset(), std::chrono::nanoseconds(5s));
  EXPECT_EQ(sync.round_trip(), std::chrono::nanoseconds(2ms));
  EXPECT_EQ(sync.to_ours(7s), std::chrono::microseconds(2s));
  round_trip(5s, 1ms, 1ms, 6s);      // one outlier
  round_trip(6s, 1ms, -3ms, 5s);     // an answer before the question
  round_trip(7s, 600ms, 600ms, 5s);  // too long to tell anything
  EXPECT_EQ(sync.rejected(), 3);
  round_trip(7s, 1ms, 1ms, 5s);
  EXPECT_EQ(sync.offset(), std::chrono::nanoseconds(5s));
  round_trip(8s, 1ms, 1ms, 1s);  // the other side has restarted
  round_trip(9s, 1ms, 1ms, 1s);
  EXPECT_EQ(sync.offset(), std::chrono::nanoseconds(5s));
  round_trip(10s, 1ms, 1ms, 1s);
  EXPECT_EQ(sync.restarts(), 1);
  EXPECT_EQ(sync.offset(), std::chrono::nanoseconds(1s));
  EXPECT_FALSE(sync.synchronised());
}

TEST(LinkTime, NoStampIsBeyondWhatCanBeCalculatedWith) {
  constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();
  Bench& bench = fresh_bench(without_rates());
  bench.run(20ms);
  bench.say_heartbeat(0);
  Odometry odometry;
  odometry.time_us = 1'000'000;
  bench.say(odometry);
  for (const std::uint64_t time : {kLargest, kLargest / 2 + 1, kLargest / 2, kLargest / 2 - 500'000, kLargest / 4}) {
    odometry.time_us = time;
    bench.say(odometry);
  }
  EXPECT_EQ(bench.link.counters().refused_values, 5);
  EXPECT_EQ(bench.link.local_vehicle().refused_count, 5);
  EXPECT_EQ(bench.link.local_vehicle().position_count, 1);
  odometry.time_us = 1'020'000;
  bench.say(odometry);
  EXPECT_EQ(bench.link.local_vehicle().position_count, 2);
  EXPECT_EQ(bench.link.autopilot().restarts, 0);

  constexpr std::int64_t kLatest = std::numeric_limits<std::int64_t>::max();
  for (const std::int64_t theirs : {kLatest, -kLatest - 1, kLatest, -kLatest, kLatest / 2 + 2, std::int64_t{-1}}) {
    bench.run(200ms, 200ms);
    const auto request = bench.hear_last<TimeSyncMessage>();
    ASSERT_TRUE(request.has_value());
    bench.say(TimeSyncMessage{.tc1 = theirs, .ts1 = -kLatest - 1});  // none of ours
    bench.say(TimeSyncMessage{.tc1 = theirs, .ts1 = request->ts1});
    bench.say(LocalPositionNed{.time_boot_ms = 0xFFFFFFFF});
  }
  EXPECT_EQ(bench.link.time_sync().rejected(), 6);
  bench.say(TimeSyncMessage{.tc1 = 0, .ts1 = -kLatest - 1});
  EXPECT_EQ(bench.hear_last<TimeSyncMessage>()->ts1, -kLatest - 1);
}

TEST(TimeSync, MeetsTheLatestClockThatItBelieves) {
  TimeSync sync;
  for (int i = 0; i < 4; ++i) sync.add(1s, kLatestTime, 1s);
  ASSERT_TRUE(sync.synchronised());
  for (int i = 0; i < 3; ++i) sync.add(1s, 0s, 1s);
  EXPECT_EQ(sync.restarts(), 1);
  for (int i = 0; i < 6; ++i) sync.add(1s, kLatestTime, 1s);
  ASSERT_TRUE(sync.synchronised());
  EXPECT_EQ(sync.offset(), kLatestTime - 1s);
  const auto latest = std::chrono::duration_cast<std::chrono::microseconds>(kLatestTime);
  EXPECT_EQ(sync.to_ours(latest), std::chrono::microseconds(1s));
  EXPECT_EQ(sync.to_ours(0s), std::chrono::microseconds(1s) - latest);
}

// ---- People

ParameterName name_of_parameter(const char* text) {
  ParameterName name{};
  std::copy_n(text, std::strlen(text), name.begin());
  return name;
}

ParameterName to_name(std::string_view text) {
  ParameterName name{};
  std::copy(text.begin(), text.end(), name.begin());
  return name;
}

ParameterValue autopilot_says(std::string_view name, float value) {
  return {.name = to_name(name), .value = value, .type = kParameterReal32, .count = 1000, .index = 7};
}

TEST(LinkParameters, OfTheAutopilotAreAskedForByNameAndAnswered) {
  Bench& bench = fresh_bench(without_rates());
  EXPECT_TRUE(bench.link.request_parameter("MPC_THR_HOVER"));
  EXPECT_TRUE(bench.link.request_parameter("SIXTEEN_LETTERS_"));
  bench.step();
  int count = 0;
  const auto request = bench.hear_last<ParameterRequest>(&count);
  ASSERT_TRUE(request.has_value());
  EXPECT_EQ(count, 1);  // one after the other
  EXPECT_TRUE(request->target == kAutopilot);
  EXPECT_EQ(request->index, -1);
  EXPECT_TRUE(text_of(request->name) == "MPC_THR_HOVER");
  EXPECT_FALSE(bench.link.take_parameter().has_value());
  bench.say(autopilot_says("MPC_THR_HOVER", 0.35F));
  const auto answer = bench.link.take_parameter();
  ASSERT_TRUE(answer.has_value());
  EXPECT_TRUE(text_of(answer->name) == "MPC_THR_HOVER");
  EXPECT_EQ(answer->value.value_or(0), 0.35F);
  const auto second = bench.hear_last<ParameterRequest>(&count);
  ASSERT_TRUE(second.has_value());
  EXPECT_TRUE(text_of(second->name) == "SIXTEEN_LETTERS_");
  bench.say(autopilot_says("SIXTEEN_LETTERS_", -1));
  EXPECT_EQ(bench.link.take_parameter()->value.value_or(0), -1.0F);
  bench.run(2000ms);
  bench.hear_last<ParameterRequest>(&count);
  EXPECT_EQ(count, 0);
}

TEST(LinkParameters, ThatTheAutopilotDoesNotKnowAreAskedForFourTimes) {
  Bench& bench = fresh_bench(without_rates());
  EXPECT_TRUE(bench.link.request_parameter("MPC_THR_HOVER"));
  bench.run(1200ms);
  int count = 0;
  bench.hear_last<ParameterRequest>(&count);
  EXPECT_EQ(count, 4);
  EXPECT_FALSE(bench.link.take_parameter().has_value());
  bench.run(100ms);
  const auto answer = bench.link.take_parameter();
  ASSERT_TRUE(answer.has_value());
  EXPECT_TRUE(text_of(answer->name) == "MPC_THR_HOVER");
  EXPECT_FALSE(answer->value.has_value());
  bench.say(autopilot_says("MPC_THR_HOVER", 0.35F));  // too late
  EXPECT_FALSE(bench.link.take_parameter().has_value());
  bench.run(2000ms);
  bench.hear_last<ParameterRequest>(&count);
  EXPECT_EQ(count, 0);
}

TEST(LinkParameters, OfTheAutopilotHaveNoValueUnlessItIsAFiniteReal32) {
  Bench& bench = fresh_bench(without_rates());
  constexpr std::uint8_t kInt32 = 6;
  for (const ParameterValue& value : {autopilot_says("P", kNan), autopilot_says("P", -1 / 0.0F),
                                      ParameterValue{.name = to_name("P"), .value = 1, .type = kInt32}}) {
    const std::uint32_t refused = bench.link.counters().refused_values;
    EXPECT_TRUE(bench.link.request_parameter("P"));
    bench.step();
    bench.say(value);
    const auto answer = bench.link.take_parameter();
    ASSERT_TRUE(answer.has_value());
    EXPECT_FALSE(answer->value.has_value());
    EXPECT_EQ(bench.link.counters().refused_values, refused + 1);
  }
}

TEST(LinkParameters, OnlyTheAutopilotsAnswersToOurQuestionsCount) {
  Bench& bench = fresh_bench(without_rates());
  bench.say(autopilot_says("P", 1));  // that nobody asked for
  EXPECT_TRUE(bench.link.request_parameter("P"));
  bench.step();
  bench.say(autopilot_says("P2", 2));
  bench.say(bench.station, autopilot_says("P", 3));
  EXPECT_EQ(bench.link.counters().unused, 2U);
  EXPECT_EQ(bench.link.counters().foreign, 1U);
  EXPECT_FALSE(bench.link.take_parameter().has_value());
  bench.say(autopilot_says("P", 4));
  EXPECT_EQ(bench.link.take_parameter()->value.value_or(0), 4.0F);
}

TEST(LinkParameters, NamesThatAreTooLongAndTooManyAreRefused) {
  Bench& bench = fresh_bench(without_rates());
  EXPECT_FALSE(bench.link.request_parameter("SEVENTEEN_LETTERS"));
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(bench.link.request_parameter("P"));
  EXPECT_FALSE(bench.link.request_parameter("P"));
}

TEST(LinkParameters, AreListedReadAndSetWhereTheyMayBe) {
  static std::array<Parameter, 3> parameters{Parameter{"SPEED_MAX", 1.5F, 0.1F, 10, true},
                                             Parameter{"RADIUS", 0.3F, 0, 1, false},
                                             Parameter{"SIXTEEN_LETTERS_", 7, 0, 10, true}};
  static LinkConfig config = without_rates();
  config.parameters = parameters;
  Bench& bench = fresh_bench(config);
  bench.say(bench.station, ParameterListRequest{.target = {1, 0}});
  bench.run(50ms);
  int count = 0;
  const auto last = bench.hear_last<ParameterValue>(&count);
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(count, 3);
  EXPECT_EQ(last->count, 3);
  EXPECT_EQ(last->index, 2);
  EXPECT_TRUE(text_of(last->name) == "SIXTEEN_LETTERS_");

  const Address us{1, 195};
  bench.say(bench.station, ParameterRequest{.target = us, .name = name_of_parameter("RADIUS")});
  auto value = bench.hear_last<ParameterValue>();
  ASSERT_TRUE(value.has_value());
  EXPECT_EQ(value->value, 0.3F);
  bench.say(bench.station, ParameterRequest{.target = us, .index = 0});
  value = bench.hear_last<ParameterValue>();
  ASSERT_TRUE(value.has_value());
  EXPECT_TRUE(text_of(value->name) == "SPEED_MAX");
  bench.say(bench.station, ParameterRequest{.target = us, .name = name_of_parameter("NONE")});
  EXPECT_FALSE(bench.hear_last<ParameterValue>().has_value());

  const auto set = [&](const char* name, float number, std::uint8_t type) {
    bench.say(bench.station,
              ParameterSet{.target = us, .name = name_of_parameter(name), .value = number, .type = type});
    return bench.hear_last<ParameterValue>()->value;
  };
  EXPECT_EQ(set("SPEED_MAX", 2, kParameterReal32), 2.0F);
  EXPECT_EQ(set("SPEED_MAX", 11, kParameterReal32), 2.0F);
  EXPECT_EQ(set("SPEED_MAX", kNan, kParameterReal32), 2.0F);
  EXPECT_EQ(set("SPEED_MAX", 3, 6), 2.0F);  // an integer's bits
  EXPECT_EQ(set("RADIUS", 0.1F, kParameterReal32), 0.3F);
  EXPECT_EQ(bench.link.parameter_changes(), 1);
}

TEST(LinkCommands, AreHandedOverOnceAndAcknowledgedAgainWhenRepeated) {
  Bench& bench = fresh_bench(without_rates());
  CommandLong message{.target = {1, 195}, .command = 193, .param = {1, kNan, 0, 0, 0, 0, kNan}};
  bench.say(bench.station, message);
  const auto command = bench.link.take_command();
  ASSERT_TRUE(command.has_value());
  EXPECT_EQ(command->command, 193);
  EXPECT_TRUE(command->from == kGroundStation);
  message.confirmation = 1;
  bench.say(bench.station, message);  // repeated while we think
  EXPECT_FALSE(bench.link.take_command().has_value());
  bench.link.answer(*command, CommandResult::kUnsupported);
  auto ack = bench.hear_last<CommandAck>();
  ASSERT_TRUE(ack.has_value());
  EXPECT_EQ(ack->command, 193);
  EXPECT_EQ(ack->result, CommandResult::kUnsupported);
  EXPECT_TRUE(ack->target == kGroundStation);
  bench.say(bench.station, message);  // our answer was lost
  EXPECT_FALSE(bench.link.take_command().has_value());
  ack = bench.hear_last<CommandAck>();
  ASSERT_TRUE(ack.has_value());
  EXPECT_EQ(ack->result, CommandResult::kUnsupported);
  message.confirmation = 0;
  bench.say(bench.station, message);  // asked anew
  EXPECT_TRUE(bench.link.take_command().has_value());
}

TEST(LinkCommands, OfTheOtherFormCarryIntegers) {
  Bench& bench = fresh_bench(without_rates());
  const CommandInt message{
      .target = {1, 195}, .command = 192, .frame = 6, .param = {1, 2, 3, 4}, .x = 473'977'418, .y = -85, .z = 12.5F};
  bench.say(bench.station, message);
  bench.say(bench.station, message);
  const auto command = bench.link.take_command();
  ASSERT_TRUE(command.has_value());
  EXPECT_TRUE(command->is_int);
  EXPECT_EQ(command->x, 473'977'418);
  EXPECT_EQ(command->y, -85);
  EXPECT_EQ(command->param[3], 4.0F);
  EXPECT_EQ(command->param[6], 12.5F);
  EXPECT_FALSE(bench.link.take_command().has_value());
}

TEST(LinkCommands, ThatNobodyFetchesAreRefusedNotForgotten) {
  Bench& bench = fresh_bench(without_rates());
  for (std::uint16_t command = 1; command <= 5; ++command) {
    bench.say(bench.station, CommandLong{.target = {1, 195}, .command = command});
  }
  const auto ack = bench.hear_last<CommandAck>();
  ASSERT_TRUE(ack.has_value());
  EXPECT_EQ(ack->command, 5);
  EXPECT_EQ(ack->result, CommandResult::kTemporarilyRejected);
  EXPECT_EQ(bench.link.counters().dropped_events, 1);
}

SetPositionTarget goal_message(const Vector3& position, std::uint8_t frame) {
  SetPositionTarget target;
  target.target = {1, 195};
  target.frame = frame;
  target.type_mask = kIgnoreVelocity | kIgnoreAcceleration | kIgnoreYaw | kIgnoreYawRate;
  target.position.value = position;
  return target;
}

TEST(LinkGoals, ComeInTheAutopilotsFrameOrInTheMaps) {
  Bench& bench = fresh_bench(without_rates());
  bench.say(LocalPositionNed{.position = {{1, 2, Real(-0.5)}}});
  bench.say(AttitudeQuaternion{});
  ASSERT_TRUE(bench.link.align({10, 20, 0}, 0));
  bench.say(bench.station, goal_message({4, 1, Real(-1.5)}, kFrameLocalNed));
  auto goal = bench.link.take_goal();
  ASSERT_TRUE(goal.has_value());
  EXPECT_NEAR(goal->position.x(), 13, kTolerance);  // as in LinkSetpoints.LeaveInTheAutopilotsFrame
  EXPECT_NEAR(goal->position.y(), 21, kTolerance);
  EXPECT_NEAR(goal->position.z(), 1, kTolerance);
  EXPECT_FALSE(goal->yaw.has_value());
  EXPECT_TRUE(goal->local);
  EXPECT_TRUE(goal->from == kGroundStation);
  EXPECT_FALSE(bench.link.take_goal().has_value());

  SetPositionTarget message = goal_message({5, 6, 7}, kFrameLocalFlu);
  message.type_mask = static_cast<std::uint16_t>(message.type_mask & ~kIgnoreYaw);
  message.yaw = 1;
  bench.say(bench.station, goal_message({1, 1, 1}, kFrameLocalFlu));
  bench.say(bench.station, message);  // the latest counts
  goal = bench.link.take_goal();
  ASSERT_TRUE(goal.has_value());
  EXPECT_NEAR(goal->position.z(), 7, kTolerance);
  EXPECT_FALSE(goal->local);
  ASSERT_TRUE(goal->yaw.has_value());
  EXPECT_NEAR(*goal->yaw, 1, kTolerance);
}

TEST(LinkGoals, ThatAreNoneAreRefused) {
  Bench& bench = fresh_bench(without_rates());
  bench.say(bench.station, goal_message({Real(kNan), 0, 0}, kFrameLocalNed));
  bench.say(bench.station, goal_message({0, 0, 0}, kFrameBodyNed));
  SetPositionTarget message = goal_message({0, 0, 0}, kFrameLocalNed);
  message.type_mask = kIgnorePosition;
  bench.say(bench.station, message);
  message = goal_message({0, 0, 0}, kFrameLocalFlu);
  message.type_mask = static_cast<std::uint16_t>(message.type_mask & ~kIgnoreYaw);
  message.yaw = 1e9F;
  bench.say(bench.station, message);
  message = goal_message({0, 0, 0}, kFrameLocalNed);
  message.target = kAutopilot;  // somebody else's set-point, not our goal
  bench.say(bench.station, message);
  EXPECT_FALSE(bench.link.take_goal().has_value());
  EXPECT_EQ(bench.link.counters().refused_values, 4);
  EXPECT_EQ(bench.link.counters().foreign, 1);
}

TEST(LinkTexts, LongOnesTravelInPieces) {
  Bench& bench = fresh_bench(without_rates());
  static Bench other(without_rates());  // reads what the first one says
  constexpr std::string_view kHundred =
      "A text of exactly one hundred characters, which fills two messages to the brim and is ended by a 3rd";
  static_assert(kHundred.size() == 100);
  const auto carry = [&] {
    bench.hear([&](const Frame& frame) {
      if (const auto text = decode<StatusText>(frame)) other.say(*text);
    });
  };
  bench.link.send_text(Severity::kWarning, "short");
  bench.link.send_text(Severity::kInfo, kHundred);
  carry();
  auto text = other.link.take_text();
  ASSERT_TRUE(text.has_value());
  EXPECT_TRUE(text_of(text->text) == "short");
  EXPECT_EQ(text->severity, Severity::kWarning);
  EXPECT_TRUE(text->from == kAutopilot);
  text = other.link.take_text();
  ASSERT_TRUE(text.has_value());
  EXPECT_TRUE(text_of(text->text) == kHundred);
  EXPECT_FALSE(other.link.take_text().has_value());
}

TEST(LinkTexts, WithALostPieceEndWhereItWasLost) {
  Bench& bench = fresh_bench(without_rates());
  StatusText piece;
  piece.text.fill('a');
  piece.id = 9;
  bench.say(piece);
  piece.chunk = 2;
  bench.say(piece);
  const auto text = bench.link.take_text();
  ASSERT_TRUE(text.has_value());
  EXPECT_EQ(text_of(text->text).size(), 50);
  EXPECT_EQ(bench.link.counters().dropped_events, 1);
}

// ---- Signing

TEST(LinkSigning, RefusesWhatIsNotSignedAndObeysWhatIs) {
  static std::array<Parameter, 1> parameters{Parameter{"SPEED_MAX", 1, 0, 10, true}};
  LinkConfig config = without_rates();
  config.parameters = parameters;
  config.signing = test_signing(1'000'000);
  Bench& bench = fresh_bench(config);
  const Address us{1, 195};
  const ParameterSet set{.target = us, .name = name_of_parameter("SPEED_MAX"), .value = 5};
  const auto order_everything = [&] {
    bench.say(bench.station, CommandLong{.target = us, .command = 193});
    bench.say(bench.station, goal_message({1, 2, 3}, kFrameLocalNed));
    bench.say(bench.station, set);
  };
  order_everything();
  EXPECT_FALSE(bench.link.take_command().has_value());
  EXPECT_FALSE(bench.link.take_goal().has_value());
  EXPECT_EQ(bench.link.parameter_changes(), 0);
  EXPECT_EQ(bench.link.counters().unauthorised, 3);
  const auto ack = bench.hear_last<CommandAck>();
  ASSERT_TRUE(ack.has_value());
  EXPECT_EQ(ack->result, CommandResult::kDenied);
  bench.say_heartbeat(0);
  EXPECT_TRUE(bench.link.autopilot().heard);  // PX4 cannot sign

  Signing wrong = test_signing(1'000'000);
  wrong.key[0] = std::byte{0};
  bench.station.sign_with(wrong);
  order_everything();
  EXPECT_FALSE(bench.link.take_goal().has_value());
  EXPECT_EQ(bench.link.codec_counters().bad_signature, 3);

  bench.station.sign_with(test_signing(1'000'000));
  order_everything();
  EXPECT_TRUE(bench.link.take_command().has_value());
  EXPECT_TRUE(bench.link.take_goal().has_value());
  EXPECT_EQ(bench.link.parameter_changes(), 1);
}

TEST(LinkSigning, SignsWhatItSendsWithATimeThatGoesOn) {
  LinkConfig config = without_rates();
  config.signing = test_signing(1'000'000);
  Bench& bench = fresh_bench(config);
  bench.reader.sign_with(test_signing(1'000'000));
  bench.run(2000ms);
  int authentic = 0;
  bench.hear([&authentic](const Frame& frame) { authentic += frame.authentic ? 1 : 0; });
  EXPECT_EQ(authentic, 2);
  EXPECT_GE(bench.link.signing_time(), 1'000'000 + 199'000);
}

TEST(LinkSigning, MayAskTheAutopilotForItToo) {
  LinkConfig config = without_rates();
  config.signing = test_signing(1'000'000);
  config.autopilot_signs = true;
  Bench& bench = fresh_bench(config);
  bench.say_heartbeat(0);
  EXPECT_FALSE(bench.link.autopilot().heard);
  bench.autopilot.sign_with(test_signing(1'000'000));
  bench.say_heartbeat(0);
  EXPECT_TRUE(bench.link.autopilot().heard);
}

// ---- A bad line

TEST(LinkFaults, ACutAtAnyByteCostsOneFrameAndNoMore) {
  Bench& bench = fresh_bench(without_rates());
  const LocalPositionNed position{.time_boot_ms = 1, .position = {{1, 2, -3}}, .velocity = {{1, 2, 3}}};
  constexpr std::uint32_t kFrameBytes = 12 + 28;
  for (std::uint32_t cut = 1; cut < kFrameBytes; ++cut) {
    bench.line.b_to_a().cut_after_bytes = cut;
    bench.say(position);
    bench.line.b_to_a().cut = false;  // joined again in the middle of nothing
    const std::uint32_t before = bench.link.vehicle().position_count;
    for (int i = 0; i < 12; ++i) bench.say(position);
    // The cut-off frame waits for its end and takes it from the next one; that one is found inside.
    EXPECT_EQ(bench.link.vehicle().position_count - before, 12);
  }
}

TEST(LinkFaults, LossAndCorruptionLeaveEnoughToFlyBy) {
  Bench& bench = fresh_bench(without_rates());
  bench.line.b_to_a().drop_ppm = 5'000;
  bench.line.b_to_a().corrupt_ppm = 5'000;
  bench.run(50 * 20ms, 20ms);
  std::uint32_t longest_gap = 0;
  std::uint32_t gap = 0;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    the_clock.advance(20ms);
    const std::uint32_t before = bench.link.vehicle().position_count;
    bench.say(LocalPositionNed{.time_boot_ms = 20 * i, .position = {{1, 2, -3}}, .velocity = {{1, 1, 1}}});
    gap = bench.link.vehicle().position_count > before ? 0 : gap + 1;
    longest_gap = std::max(longest_gap, gap);
  }
  EXPECT_GT(bench.link.vehicle().position_count, 600);  // a frame of 40 bytes survives with 0.99^40 = 67 %
  EXPECT_LT(longest_gap, 15);
  EXPECT_NEAR(bench.link.vehicle().position.x(), 2, kTolerance);
}

TEST(LinkFaults, AStallIsSeenByTheAgeOfTheEstimate) {
  Bench& bench = fresh_bench(without_rates());
  bench.say(LocalPositionNed{.time_boot_ms = 1});
  bench.line.b_to_a().stalled_until = the_clock.now() + 200ms;
  for (std::uint32_t i = 0; i < 9; ++i) {
    the_clock.advance(20ms);
    bench.say(LocalPositionNed{.time_boot_ms = 20 * i});
  }
  EXPECT_EQ(the_clock.now() - bench.link.vehicle().position_received_at, std::chrono::microseconds(180ms));
  the_clock.advance(20ms);
  bench.step();
  EXPECT_EQ(bench.link.vehicle().position_received_at, the_clock.now());
  EXPECT_EQ(bench.link.vehicle().position_count, 10);
}

}  // namespace
