// The simulated autopilot as a companion sees it: bytes.
#include "sim/pixhawk_sim.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <functional>
#include <map>

#include "swiftlet/mavlink/codec.hpp"

namespace swiftlet::tools {
namespace {

using std::chrono::milliseconds;

constexpr unsigned kYawAlone = mavlink::kIgnoreVelocity | mavlink::kIgnoreAcceleration | mavlink::kIgnoreYawRate;

struct TimedAck {
  Microseconds at;
  mavlink::CommandAck ack;
};

/// The least that a companion needs.
class Companion {
 public:
  explicit Companion(const PixhawkSimSettings& settings = {}) : sim(settings) {}

  PixhawkSim sim;
  std::map<std::uint32_t, int> count;  ///< of messages by id
  std::vector<TimedAck> acks;
  std::vector<std::string> texts;
  std::vector<std::byte> bytes;  ///< everything that came
  mavlink::Heartbeat heartbeat;
  mavlink::LocalPositionNed position;
  mavlink::AttitudeQuaternion attitude;
  mavlink::Odometry odometry;
  mavlink::CurrentMode mode;
  mavlink::SystemStatus status;
  mavlink::ExtendedSystemState extended;
  mavlink::TimeSyncMessage timesync;
  std::vector<mavlink::ParameterValue> parameters;
  std::function<void()> stream;  ///< called at 50 Hz

  template <typename M>
  void send(const M& message) {
    sim.receive(codec_.encode(message));
  }
  void run(double seconds) {
    for (int i = 0; i < std::lround(seconds * 1000); ++i) {
      if (stream && sim.time().count() / 1000 % 20 == 0) stream();
      take(sim.step());
    }
  }
  void command(std::uint16_t id, std::array<float, 7> param, mavlink::Address target = {1, 1}) {
    send(mavlink::CommandLong{target, id, 0, param});
  }
  void set_mode(float main, float sub = 0) { command(mavlink::kCommandDoSetMode, {1, main, sub}); }
  void arm(float force = 0) { command(mavlink::kCommandArmDisarm, {1, force}); }
  void hold(double up) {
    stream = [this, up] {
      if ((heartbeat.base_mode & mavlink::kModeFlagArmed) == 0) home = position.position.value;
      mavlink::SetPositionTarget target;
      target.target = {1, 1};
      target.type_mask = kYawAlone;
      target.position.value = home - Vector3{0, 0, up};
      send(target);
    };
  }
  void fly() {
    set_mode(6);
    hold(1.5);
    run(1.5);
    arm();
    run(9);
    ASSERT_EQ(mode.custom_mode, 6U << 16);
    ASSERT_GT(home.z() - position.position.value.z(), 1.2);
  }
  [[nodiscard]] std::vector<mavlink::CommandAck> acks_of(std::uint16_t id) const {
    std::vector<mavlink::CommandAck> found;
    for (const TimedAck& each : acks) {
      if (each.ack.command == id) found.push_back(each.ack);
    }
    return found;
  }
  Vector3 home = Vector3::Zero();  ///< NED

 private:
  template <typename M>
  static void keep(const mavlink::Frame& frame, M& into) {
    if (const auto message = mavlink::decode<M>(frame)) into = *message;
  }
  void take(const std::vector<std::byte>& received) {
    bytes.insert(bytes.end(), received.begin(), received.end());
    std::span<const std::byte> rest(received);
    while (const auto frame = codec_.receive(rest)) {
      ++count[frame->id];
      keep(*frame, heartbeat);
      keep(*frame, position);
      keep(*frame, attitude);
      keep(*frame, odometry);
      keep(*frame, mode);
      keep(*frame, status);
      keep(*frame, extended);
      keep(*frame, timesync);
      if (const auto ack = mavlink::decode<mavlink::CommandAck>(*frame)) acks.push_back({sim.time(), *ack});
      if (const auto text = mavlink::decode<mavlink::StatusText>(*frame)) {
        texts.emplace_back(mavlink::text_of(text->text));
      }
      if (const auto value = mavlink::decode<mavlink::ParameterValue>(*frame)) parameters.push_back(*value);
    }
  }

  mavlink::Codec codec_{{1, mavlink::kPathPlannerComponent}};
};

PixhawkSimSettings with_fault(const char* text) {
  PixhawkSimSettings settings;
  settings.faults = {*parse_fault(text)};
  return settings;
}

// Streams.

TEST(PixhawkSim, StreamsAtPx4sUsualRates) {
  Companion companion;
  companion.run(10);
  EXPECT_NEAR(companion.count[mavlink::Heartbeat::kId], 10, 1);
  EXPECT_NEAR(companion.count[mavlink::LocalPositionNed::kId], 303, 3);
  EXPECT_NEAR(companion.count[mavlink::Odometry::kId], 303, 3);
  EXPECT_NEAR(companion.count[mavlink::AttitudeQuaternion::kId], 500, 3);
  EXPECT_NEAR(companion.count[mavlink::ExtendedSystemState::kId], 50, 1);
  EXPECT_NEAR(companion.count[mavlink::TimeSyncMessage::kId], 100, 1);
}

TEST(PixhawkSim, SetMessageIntervalIsAcknowledgedAndChangesOneRateButNotTheHeartbeats) {
  Companion companion;
  companion.command(mavlink::kCommandSetMessageInterval, {32, 20'000});
  companion.command(mavlink::kCommandSetMessageInterval, {331, -1});
  companion.command(mavlink::kCommandSetMessageInterval, {0, 10'000});
  companion.command(mavlink::kCommandSetMessageInterval, {9999, 10'000});
  companion.command(mavlink::kCommandSetMessageInterval, {NAN, NAN});
  companion.run(0.02);
  const auto acks = companion.acks_of(mavlink::kCommandSetMessageInterval);
  ASSERT_EQ(acks.size(), 5U);
  EXPECT_EQ(acks[0].result, mavlink::CommandResult::kAccepted);
  EXPECT_EQ(acks[0].target, (mavlink::Address{1, mavlink::kPathPlannerComponent}));
  EXPECT_EQ(acks[3].result, mavlink::CommandResult::kFailed);
  EXPECT_EQ(acks[4].result, mavlink::CommandResult::kFailed);
  companion.count.clear();
  companion.run(10);
  EXPECT_NEAR(companion.count[mavlink::LocalPositionNed::kId], 500, 2);
  EXPECT_EQ(companion.count[mavlink::Odometry::kId], 0);
  EXPECT_NEAR(companion.count[mavlink::Heartbeat::kId], 10, 1);
  companion.command(mavlink::kCommandSetMessageInterval, {331, 0});  // back to the usual rate
  companion.count.clear();
  companion.run(10);
  EXPECT_NEAR(companion.count[mavlink::Odometry::kId], 303, 3);
}

TEST(PixhawkSim, ARequestedMessageComesOnce) {
  Companion companion;
  companion.run(0.5);
  companion.count.clear();
  companion.command(mavlink::kCommandRequestMessage, {436});
  companion.run(0.01);
  EXPECT_EQ(companion.count[mavlink::CurrentMode::kId], 1);
  EXPECT_EQ(companion.acks_of(mavlink::kCommandRequestMessage).at(0).result, mavlink::CommandResult::kAccepted);
}

TEST(PixhawkSim, PoseIsNedAndFrdAndOdometrysVelocityIsInTheLocalFrame) {
  PixhawkSimSettings settings;
  settings.simulation.start_yaw = 0.3;  // from east, anticlockwise
  settings.simulation.estimator.boot_sigma.setZero();
  settings.simulation.estimator.origin = {-1, -2, -3};
  Companion companion(settings);
  companion.run(0.2);
  const Vector3 at = companion.position.position.value;
  EXPECT_NEAR((at - Vector3{2, 1, -3}).norm(), 0, 0.15);
  const Vector3 nose = companion.attitude.attitude.value * Vector3::UnitX();
  EXPECT_NEAR(std::atan2(nose.y(), nose.x()), M_PI / 2 - 0.3, 0.05);
  EXPECT_EQ(companion.odometry.child_frame, mavlink::kFrameLocalNed);
}

TEST(PixhawkSim, TimesyncRequestsAreAnsweredAtOnceWithBootTime) {
  Companion companion;
  companion.run(1);
  companion.send(mavlink::TimeSyncMessage{0, 1234567});
  companion.run(0.001);
  EXPECT_EQ(companion.timesync.ts1, 1234567);
  EXPECT_NEAR(static_cast<double>(companion.timesync.tc1), 1e9, 2e6);
}

// Commands.

TEST(PixhawkSim, AModeCommandHasTwoAcknowledgementsOfWhichTheFirstMeansNothing) {
  Companion companion;
  companion.fly();
  companion.set_mode(4, 3);
  companion.run(0.1);
  companion.stream = {};
  companion.run(1.5);
  companion.acks.clear();
  companion.set_mode(6);
  companion.run(0.1);
  const auto acks = companion.acks_of(mavlink::kCommandDoSetMode);
  ASSERT_EQ(acks.size(), 2U);
  EXPECT_EQ(acks[0].result, mavlink::CommandResult::kAccepted);
  EXPECT_EQ(acks[1].result, mavlink::CommandResult::kTemporarilyRejected);
  EXPECT_GT(companion.acks[1].at, companion.acks[0].at);
  EXPECT_EQ(companion.mode.custom_mode, 4U << 16 | 3U << 24);
}

TEST(PixhawkSim, ArmingHasOneAcknowledgementAndShowsInTheHeartbeat) {
  Companion companion;
  companion.run(1.5);
  companion.set_mode(6);
  companion.run(0.2);
  companion.arm();
  companion.run(0.2);
  ASSERT_EQ(companion.acks_of(mavlink::kCommandArmDisarm).size(), 1U);
  EXPECT_EQ(companion.acks_of(mavlink::kCommandArmDisarm)[0].result, mavlink::CommandResult::kTemporarilyRejected);
  EXPECT_EQ(companion.status.sensors_health & mavlink::kSensorPrearmCheck, 0U);
  companion.hold(1.5);
  companion.run(0.5);
  EXPECT_EQ(companion.status.sensors_health & mavlink::kSensorPrearmCheck, mavlink::kSensorPrearmCheck);
  companion.arm();
  companion.run(1.1);
  EXPECT_EQ(companion.acks_of(mavlink::kCommandArmDisarm).back().result, mavlink::CommandResult::kAccepted);
  EXPECT_NE(companion.heartbeat.base_mode & mavlink::kModeFlagArmed, 0);
  EXPECT_EQ(static_cast<int>(companion.heartbeat.system_status), 4);
}

TEST(PixhawkSim, AnotherTargetIsIgnoredSilentlyAndAnUnknownCommandIsNot) {
  Companion companion;
  companion.command(mavlink::kCommandArmDisarm, {1, 21196}, {2, 1});
  companion.command(mavlink::kCommandArmDisarm, {1, 21196}, {1, 154});
  companion.run(0.1);
  EXPECT_TRUE(companion.acks.empty());
  companion.command(31999, {});
  companion.run(0.1);
  ASSERT_EQ(companion.acks.size(), 1U);
  EXPECT_EQ(companion.acks[0].ack.result, mavlink::CommandResult::kUnsupported);
}

TEST(PixhawkSim, AModeThatItDoesNotHaveIsDenied) {
  Companion companion;
  for (const float main : {7.0F, NAN, -1.0F, 1e20F}) {
    companion.acks.clear();
    companion.set_mode(main);
    companion.command(mavlink::kCommandDoSetMode, {main, 6});
    companion.run(0.1);
    const auto acks = companion.acks_of(mavlink::kCommandDoSetMode);
    ASSERT_EQ(acks.size(), 4U);
    EXPECT_EQ(acks[2].result, mavlink::CommandResult::kDenied);
    EXPECT_EQ(acks[0].result, mavlink::CommandResult::kAccepted);
  }
}

TEST(PixhawkSim, ForeignCommandsAppearOnTheLink) {
  Companion companion;
  companion.run(6);
  EXPECT_GE(companion.count[mavlink::CommandLong::kId], 1);
}

// Texts.

TEST(PixhawkSim, ACompanionGetsNoTextsAndAGroundStationDoes) {
  for (const auto& [type, hears] :
       {std::pair{mavlink::kTypeOnboardController, false}, std::pair{mavlink::kTypeGroundStation, true}}) {
    Companion companion;
    mavlink::Heartbeat heartbeat;
    heartbeat.type = type;
    companion.send(heartbeat);
    companion.run(0.5);
    companion.arm();  // too early
    companion.run(0.5);
    EXPECT_EQ(!companion.texts.empty(), hears);
  }
}

// Set-points.

TEST(PixhawkSim, TheDropOutAndTheReturnShowInCurrentModeAndHeartbeat) {
  Companion companion;
  companion.fly();
  auto stream = companion.stream;
  companion.stream = {};
  companion.run(1.2);
  EXPECT_EQ(companion.mode.custom_mode, 3U << 16);
  EXPECT_EQ(companion.mode.intended_custom_mode, 6U << 16);
  companion.run(1);
  EXPECT_EQ(static_cast<int>(companion.heartbeat.system_status), 5);
  companion.stream = stream;
  companion.run(0.12);
  EXPECT_EQ(companion.mode.custom_mode, 6U << 16);
}

TEST(PixhawkSim, TypeMasksSayWhatIsAskedFor) {
  Companion companion;
  companion.run(0.1);
  mavlink::SetPositionTarget target;
  target.target = {1, 1};
  target.type_mask = mavlink::kIgnorePosition | mavlink::kIgnoreAcceleration | mavlink::kIgnoreYaw | 0x020;
  target.position.value = {NAN, 1, 2};
  target.velocity.value = {1, 2, 3};
  target.yaw_rate = 0.5;
  companion.send(target);
  companion.run(0.2);
  const PositionSetpoint setpoint = companion.sim.simulation().autopilot().position_target().value();
  EXPECT_TRUE(setpoint.position.array().isNaN().all());
  EXPECT_TRUE(setpoint.acceleration.array().isNaN().all());
  EXPECT_EQ(setpoint.velocity.head<2>(), Eigen::Vector2d(2, 1));  // ENU
  EXPECT_TRUE(std::isnan(setpoint.velocity.z()));
  EXPECT_TRUE(std::isnan(setpoint.yaw));
  EXPECT_NEAR(setpoint.yaw_rate, -0.5, 1e-9);
}

TEST(PixhawkSim, SetpointsThatAskForNothingOrInAnotherFrameAreNone) {
  Companion companion;
  companion.run(0.1);
  mavlink::SetPositionTarget target;
  target.target = {1, 1};
  target.type_mask = mavlink::kIgnorePosition | mavlink::kIgnoreVelocity | mavlink::kIgnoreAcceleration;
  companion.send(target);
  target.type_mask = 0;
  target.frame = mavlink::kFrameBodyFrd;
  companion.send(target);
  target.frame = mavlink::kFrameLocalNed;
  target.target = {9, 1};
  companion.send(target);
  mavlink::SetAttitudeTarget attitude;
  attitude.target = {1, 1};
  attitude.thrust = NAN;
  companion.send(attitude);
  companion.run(0.3);
  EXPECT_FALSE(companion.sim.simulation().autopilot().position_target().has_value());
  companion.set_mode(6);
  companion.run(0.3);
  EXPECT_FALSE(companion.sim.simulation().autopilot().prearm_ok());
}

TEST(PixhawkSim, NoSetpointMakesTheVehiclesStateAnythingButNumbers) {
  Companion companion;
  companion.fly();
  Noise noise(2);
  const std::array<float, 6> values{NAN, INFINITY, -INFINITY, 3e38F, -3e38F, 0};
  const auto any = [&] { return values[noise.below(values.size())]; };
  const auto vector = [&] { return Vector3{any(), any(), any()}; };
  companion.stream = [&] {
    mavlink::SetPositionTarget position;
    position.target = {1, 1};
    position.type_mask = static_cast<std::uint16_t>(noise.below(0x1000));
    position.position.value = vector();
    position.velocity.value = vector();
    position.acceleration.value = vector();
    position.yaw = any();
    position.yaw_rate = any();
    mavlink::SetAttitudeTarget attitude;
    attitude.target = {1, 1};
    attitude.type_mask = static_cast<std::uint8_t>(noise.below(256));
    attitude.attitude.value.coeffs() << any(), any(), any(), any();
    attitude.body_rates.value = vector();
    attitude.thrust = any();
    noise.below(2) == 0 ? companion.send(position) : companion.send(attitude);
  };
  companion.run(20);
  const RigidState& truth = companion.sim.simulation().truth();
  EXPECT_TRUE(truth.position.allFinite() && truth.velocity.allFinite() && truth.rate.allFinite());
  EXPECT_TRUE(truth.attitude.coeffs().allFinite());
}

TEST(PixhawkSim, AttitudeAndRateTargetsTurnTheVehicle) {
  for (const bool rates : {false, true}) {
    PixhawkSimSettings settings;
    settings.simulation.estimator.attitude_sigma.setZero();
    Companion companion(settings);
    companion.fly();
    const Quaternion north(Eigen::AngleAxis<double>(M_PI / 2, Vector3::UnitZ()));     // where `hold` looks
    const Quaternion tilt = north * Eigen::AngleAxis<double>(0.2, Vector3::UnitY());  // nose down
    companion.stream = [&] {
      mavlink::SetAttitudeTarget target;
      target.target = {1, 1};
      target.type_mask = rates ? mavlink::kIgnoreAttitude : mavlink::kIgnoreBodyRates;
      target.attitude = mavlink::to_ned(tilt);
      target.body_rates = mavlink::to_frd({0, 0.5, 0});
      target.thrust = 0.5;
      companion.send(target);
    };
    companion.run(0.7);
    const RigidState& truth = companion.sim.simulation().truth();
    if (rates) {
      EXPECT_NEAR((truth.rate - Vector3{0, 0.5, 0}).norm(), 0, 0.1);
    } else {
      EXPECT_LT(truth.attitude.angularDistance(tilt), 0.03);
      EXPECT_GT(truth.velocity.y(), 0.5);
    }
  }
}

// Parameters.

TEST(PixhawkSim, ParametersAreListedReadAndSetWithIntegersAsBytes) {
  Companion companion;
  companion.send(mavlink::ParameterListRequest{{1, 1}});
  companion.run(0.1);
  const std::size_t count = companion.sim.simulation().autopilot().parameters().size();
  ASSERT_EQ(companion.parameters.size(), count);
  EXPECT_EQ(companion.parameters[0].count, count);
  mavlink::ParameterName name{};
  std::copy_n("COM_OBL_RC_ACT", 14, name.begin());
  constexpr std::int32_t kLand = 4;
  companion.parameters.clear();
  companion.send(mavlink::ParameterSet{{1, 1}, name, std::bit_cast<float>(kLand), 6});
  companion.run(0.02);
  ASSERT_EQ(companion.parameters.size(), 1U);
  EXPECT_EQ(std::bit_cast<std::int32_t>(companion.parameters[0].value), kLand);
  EXPECT_EQ(companion.sim.simulation().autopilot().parameter(ParameterIndex::kOffboardLossAction), 4);
  companion.parameters.clear();
  companion.send(mavlink::ParameterRequest{{1, 1}, name, -1});
  companion.send(mavlink::ParameterRequest{{1, 1}, {}, 6});
  companion.send(mavlink::ParameterRequest{{1, 1}, {}, 999});
  companion.run(0.02);
  ASSERT_EQ(companion.parameters.size(), 2U);
  EXPECT_EQ(mavlink::text_of(companion.parameters[1].name), "MPC_THR_HOVER");
}

TEST(PixhawkSim, WhatACompanionReadsByNameIsReal32AndAnUnknownNameIsNotAnswered) {
  Companion companion;
  for (const std::string_view text : {"MPC_THR_HOVER", "COM_OF_LOSS_T", "MOT_THST_HOVER"}) {
    mavlink::ParameterName name{};
    std::copy(text.begin(), text.end(), name.begin());
    companion.send(mavlink::ParameterRequest{{1, 1}, name, -1});
  }
  companion.run(0.5);
  ASSERT_EQ(companion.parameters.size(), 2U);
  for (const mavlink::ParameterValue& parameter : companion.parameters) {
    EXPECT_EQ(parameter.type, mavlink::kParameterReal32);
  }
  EXPECT_EQ(companion.parameters[0].value, 0.5F);
  EXPECT_EQ(companion.parameters[1].value, 1.0F);
}

// Determinism and rubbish.

TEST(PixhawkSim, TheSameSeedAndBytesGiveTheSameBytes) {
  const auto fly = [](std::uint64_t seed) {
    PixhawkSimSettings settings;
    settings.simulation.seed = seed;
    settings.simulation.wind.gust = 2;
    settings.link_delay = milliseconds(20);
    settings.faults = {*parse_fault("corrupt@4"), *parse_fault("loss@5+1"), *parse_fault("cut@9")};
    Companion companion(settings);
    companion.set_mode(6);
    companion.hold(1.5);
    companion.run(1.5);
    companion.arm();
    companion.run(9);
    return companion.bytes;
  };
  const std::vector<std::byte> bytes = fly(3);
  EXPECT_GT(bytes.size(), 20'000U);
  EXPECT_TRUE(bytes == fly(3));
  EXPECT_FALSE(bytes == fly(4));
}

TEST(PixhawkSim, RandomBytesNeverUpsetIt) {
  Companion companion;
  Noise noise(9);
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::byte> rubbish(noise.below(60));
    for (std::byte& byte : rubbish) byte = static_cast<std::byte>(noise.below(256));
    companion.sim.receive(rubbish);
    companion.run(0.001);
  }
  companion.run(0.5);
  EXPECT_GT(companion.sim.counters().skipped_bytes, 10'000U);
  EXPECT_TRUE(companion.sim.simulation().quadrotor().on_ground());
}

// Faults.

TEST(PixhawkSimFault, KindsParseWithTimeAndDuration) {
  EXPECT_EQ(parse_fault("cut@3")->at, 3);
  EXPECT_TRUE(std::isinf(parse_fault("cut@3")->duration));
  EXPECT_EQ(parse_fault("stall@2.5")->duration, 0.2);
  EXPECT_EQ(parse_fault("pilot@10+4")->duration, 4);
  EXPECT_EQ(parse_fault("pilot@10+4")->kind, FaultKind::kPilot);
  for (const char* wrong : {"", "cut", "cut@", "cut@x", "cut@1+", "cut@-1", "cut@1+2+3", "fire@3", "cut@nan", "cut@inf",
                            "position-jump@3+1", "@3", "cut@1 "}) {
    EXPECT_FALSE(parse_fault(wrong).has_value()) << wrong;
  }
}

TEST(PixhawkSimFault, TheListNamesEveryKindAndEachNameParses) {
  const std::string list = list_faults();
  for (int kind = 0; kind <= static_cast<int>(FaultKind::kClockJump); ++kind) {
    const std::string name = describe(static_cast<FaultKind>(kind));
    EXPECT_NE(list.find("  " + name + "@T"), std::string::npos) << name;
    EXPECT_EQ(static_cast<int>(parse_fault(name + "@1")->kind), kind);
  }
}

TEST(PixhawkSimFault, ACutEndsBothDirectionsForGoodOrForItsDuration) {
  Companion companion(with_fault("cut@2+1"));
  companion.run(2.3);
  const std::size_t before = companion.bytes.size();
  companion.run(0.6);
  EXPECT_EQ(companion.bytes.size(), before);
  EXPECT_EQ(companion.sim.take_begun().size(), 1U);
  EXPECT_TRUE(companion.sim.take_begun().empty());
  companion.run(0.5);
  EXPECT_GT(companion.bytes.size(), before);
  Companion forever(with_fault("cut@0"));
  forever.run(3);
  EXPECT_LT(forever.bytes.size(), 64U);
}

TEST(PixhawkSimFault, LossTakesThirtyPercentOfTheMessagesAndCorruptionMore) {
  Companion whole;
  whole.run(10);
  const int all = whole.count[mavlink::AttitudeQuaternion::kId];
  Companion lossy(with_fault("loss@0+10"));
  lossy.run(10);
  EXPECT_NEAR(lossy.count[mavlink::AttitudeQuaternion::kId], 0.7 * all, 0.06 * all);
  Companion corrupt(with_fault("corrupt@0+10"));
  corrupt.run(10);
  EXPECT_LT(corrupt.count[mavlink::AttitudeQuaternion::kId], 0.75 * all);
  EXPECT_GT(corrupt.count[mavlink::AttitudeQuaternion::kId], 0.5 * all);
}

TEST(PixhawkSimFault, AStallHoldsEverythingBackAndThenDeliversIt) {
  Companion companion(with_fault("stall@1"));
  companion.run(1.0);
  const std::size_t before = companion.bytes.size();
  companion.run(0.19);
  EXPECT_EQ(companion.bytes.size(), before);
  companion.count.clear();
  companion.run(0.012);
  EXPECT_GE(companion.count[mavlink::AttitudeQuaternion::kId], 9);
}

TEST(PixhawkSimFault, StarvedOfSetpointsItDropsOutAndComesBack) {
  Companion companion(with_fault("starve@12"));
  companion.fly();
  companion.run(2.7);  // 13.2 s
  EXPECT_EQ(companion.mode.custom_mode, 3U << 16);
  companion.run(1.5);
  EXPECT_EQ(companion.mode.custom_mode, 6U << 16);
}

TEST(PixhawkSimFault, StaleOdometryRepeatsOldTimesAndNanOdometryHasNoNumbers) {
  Companion stale(with_fault("odometry-stale@1"));
  stale.run(1.5);
  EXPECT_NEAR(stale.position.time_boot_ms, 1000, 2);
  EXPECT_NEAR(static_cast<double>(stale.odometry.time_us), 1e6, 2e3);
  const int before = stale.count[mavlink::LocalPositionNed::kId];
  stale.run(0.5);
  EXPECT_GT(stale.count[mavlink::LocalPositionNed::kId], before + 10);
  stale.run(1.1);
  EXPECT_NEAR(stale.position.time_boot_ms, 3100, 40);
  Companion nan(with_fault("odometry-nan@1"));
  nan.run(1.5);
  EXPECT_TRUE(std::isnan(nan.position.position.value.x()));
  EXPECT_TRUE(nan.odometry.attitude.value.coeffs().hasNaN());
  nan.run(0.6);
  EXPECT_TRUE(nan.position.position.value.allFinite());
}

TEST(PixhawkSimFault, APositionJumpMovesTheEstimateAndNotTheVehicle) {
  Companion companion(with_fault("position-jump@1"));
  companion.run(0.99);
  const Vector3 before = companion.position.position.value;
  companion.run(0.1);
  EXPECT_NEAR(companion.position.position.value.y() - before.y(), 1, 0.1);  // 1 m east
  EXPECT_EQ(companion.sim.simulation().truth().position, Vector3::Zero());
}

TEST(PixhawkSimFault, ARestartIsSilentThenBootsWithUsualRatesAndItsClockAtZero) {
  Companion companion(with_fault("restart@2+2"));
  companion.command(mavlink::kCommandSetMessageInterval, {32, -1});
  companion.run(2.01);
  const std::size_t before = companion.bytes.size();
  companion.run(1.9);
  EXPECT_EQ(companion.bytes.size(), before);
  companion.count.clear();
  companion.run(1.1);
  EXPECT_NEAR(companion.count[mavlink::LocalPositionNed::kId], 30, 3);
  EXPECT_NEAR(companion.position.time_boot_ms, 1000, 50);
}

TEST(PixhawkSimFault, ThePilotTakesOverAndGivesBack) {
  Companion companion(with_fault("pilot@11+2"));
  companion.fly();
  companion.run(1);
  EXPECT_EQ(companion.mode.custom_mode, 3U << 16);
  EXPECT_EQ(companion.mode.intended_custom_mode, 3U << 16);
  companion.run(2);
  EXPECT_EQ(companion.mode.custom_mode, 6U << 16);
}

TEST(PixhawkSimFault, AClockJumpShowsInEveryTime) {
  Companion companion(with_fault("clock-jump@1"));
  companion.run(1.2);
  EXPECT_NEAR(companion.position.time_boot_ms, 6190, 30);
  companion.send(mavlink::TimeSyncMessage{0, 5});
  companion.run(0.001);
  EXPECT_NEAR(static_cast<double>(companion.timesync.tc1), 6.2e9, 3e7);
}

TEST(PixhawkSim, TheLinksDelayCountsInEachDirection) {
  PixhawkSimSettings settings;
  settings.link_delay = milliseconds(20);
  Companion companion(settings);
  companion.run(1);
  companion.send(mavlink::TimeSyncMessage{0, 77});
  companion.run(0.039);
  EXPECT_NE(companion.timesync.ts1, 77);
  companion.run(0.004);
  EXPECT_EQ(companion.timesync.ts1, 77);
}

}  // namespace
}  // namespace swiftlet::tools
