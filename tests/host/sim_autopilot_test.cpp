// What a real PX4 v1.16.1 was seen to do, one case each.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>

#include "sim/simulation.hpp"

namespace swiftlet::tools {
namespace {

/// A simulation with a companion that streams set-points.
class Companion {
 public:
  explicit Companion(const SimulationSettings& settings = {}) : sim(settings) { run(1.2); }

  Simulation sim;
  double period = 0.02;                          ///< [s] of the stream
  std::function<void(Simulation&)> target = {};  ///< sends a set-point; empty: no stream
  Vector3 home = Vector3::Zero();                ///< [m] frame L, at arming

  void run(double seconds) {
    for (int i = 0; i < std::lround(seconds * 1000); ++i) {
      since_target_ += 0.001;
      if (target && since_target_ >= period - 1e-6) {
        target(sim);
        since_target_ = 0;
      }
      sim.step();
    }
  }
  /// Runs until the claim holds; the seconds that it took, or `limit`.
  double run_until(const std::function<bool()>& claim, double limit) {
    double waited = 0;
    for (; waited < limit && !claim(); waited += 0.001) run(0.001);
    return waited;
  }
  void hold(const Vector3& offset) {
    target = [this, offset](Simulation& each) {
      if (!each.autopilot().armed()) home = each.estimate().position;
      PositionSetpoint setpoint;
      setpoint.position = home + offset;
      setpoint.yaw = 0;
      each.autopilot().set_target(setpoint, each.now());
    };
  }
  Verdict set_mode(FlightMode mode) { return sim.autopilot().set_mode(mode, sim.now()); }
  Verdict arm(bool forced = false) { return sim.autopilot().arm(forced, sim.now()); }
  void arm_offboard() {
    hold({0, 0, 1.5});
    ASSERT_EQ(set_mode(FlightMode::kOffboard), Verdict::kAccepted);
    run(0.3);
    ASSERT_EQ(arm(), Verdict::kAccepted);
  }
  /// In OFFBOARD, hovering at 1.5 m.
  void fly() {
    arm_offboard();
    run(9);
    ASSERT_GT(height(), 1.2);
  }
  [[nodiscard]] double height() const { return sim.truth().position.z() - sim.quadrotor().ground(); }

 private:
  double since_target_ = 0;
};

bool said(const std::vector<Announcement>& texts, const std::string& words) {
  return std::any_of(texts.begin(), texts.end(),
                     [&](const Announcement& text) { return text.text.find(words) != std::string::npos; });
}

// Modes and arming.

TEST(SimAutopilot, OffboardIsAcceptedWhileDisarmedWithoutASetpoint) {
  Companion companion;
  EXPECT_EQ(companion.set_mode(FlightMode::kOffboard), Verdict::kAccepted);
  EXPECT_EQ(companion.sim.autopilot().mode(), FlightMode::kOffboard);
}

TEST(SimAutopilot, OffboardIsRefusedInTheAirWithoutASetpointStream) {
  Companion companion;
  companion.fly();
  ASSERT_EQ(companion.set_mode(FlightMode::kLoiter), Verdict::kAccepted);
  companion.target = {};
  companion.run(1.5);
  EXPECT_EQ(companion.set_mode(FlightMode::kOffboard), Verdict::kTemporarilyRejected);
  EXPECT_EQ(companion.sim.autopilot().mode(), FlightMode::kLoiter);
  companion.hold({0, 0, 1.5});
  companion.run(0.2);
  EXPECT_EQ(companion.set_mode(FlightMode::kOffboard), Verdict::kAccepted);
}

TEST(SimAutopilot, ArmingInOffboardNeedsASetpointInTheLastSecond) {
  Companion companion;
  ASSERT_EQ(companion.set_mode(FlightMode::kOffboard), Verdict::kAccepted);
  EXPECT_EQ(companion.arm(), Verdict::kTemporarilyRejected);
  companion.hold({0, 0, 1.5});
  const double waited = companion.run_until([&] { return companion.arm() == Verdict::kAccepted; }, 1);
  EXPECT_GE(waited, 0.1);
  EXPECT_LE(waited, 0.2 + companion.period);
  EXPECT_TRUE(companion.sim.autopilot().armed());
}

TEST(SimAutopilot, AStreamThatEndedASecondAgoArmsNothing) {
  Companion companion;
  ASSERT_EQ(companion.set_mode(FlightMode::kOffboard), Verdict::kAccepted);
  companion.hold({0, 0, 1.5});
  companion.run(0.5);
  companion.target = {};
  companion.run(1.1);
  EXPECT_EQ(companion.arm(), Verdict::kTemporarilyRejected);
}

TEST(SimAutopilot, ThePrearmBitStaysZeroInOffboardUntilSetpointsStream) {
  Companion companion;
  EXPECT_TRUE(companion.sim.autopilot().prearm_ok());
  EXPECT_EQ(companion.sim.autopilot().system_status(), VehicleStatus::kReady);
  ASSERT_EQ(companion.set_mode(FlightMode::kOffboard), Verdict::kAccepted);
  companion.run(3);
  EXPECT_FALSE(companion.sim.autopilot().prearm_ok());
  EXPECT_EQ(companion.sim.autopilot().system_status(), VehicleStatus::kNotReady);
  companion.hold({0, 0, 1.5});
  companion.run(0.3);
  EXPECT_TRUE(companion.sim.autopilot().prearm_ok());
}

TEST(SimAutopilot, IsNotReadyToArmRightAfterBooting) {
  Simulation sim({});
  sim.step();
  EXPECT_EQ(sim.autopilot().system_status(), VehicleStatus::kNotReady);
  EXPECT_EQ(sim.autopilot().arm(false, sim.now()), Verdict::kTemporarilyRejected);
}

TEST(SimAutopilot, APositionModeWithoutAPilotArmsNothing) {
  Companion companion;
  ASSERT_EQ(companion.set_mode(FlightMode::kPosctl), Verdict::kAccepted);
  companion.run(0.2);
  EXPECT_EQ(companion.arm(), Verdict::kTemporarilyRejected);
}

TEST(SimAutopilot, DisarmingInTheAirIsRefusedUnlessForced) {
  Companion companion;
  companion.fly();
  EXPECT_EQ(companion.sim.autopilot().disarm(false), Verdict::kTemporarilyRejected);
  EXPECT_TRUE(companion.sim.autopilot().armed());
  EXPECT_EQ(companion.sim.autopilot().disarm(true), Verdict::kAccepted);
  companion.run(2);
  EXPECT_TRUE(companion.sim.quadrotor().on_ground());
  EXPECT_GT(companion.sim.quadrotor().impact_speed(), 4);  // it fell
}

TEST(SimAutopilot, ForcedArmingSkipsTheChecks) {
  Companion companion;
  ASSERT_EQ(companion.set_mode(FlightMode::kOffboard), Verdict::kAccepted);
  EXPECT_EQ(companion.arm(true), Verdict::kAccepted);
}

TEST(SimAutopilot, ArmedAndIdleItDisarmsAfterTenSeconds) {
  Companion companion;
  companion.hold({0, 0, 0});
  ASSERT_EQ(companion.set_mode(FlightMode::kOffboard), Verdict::kAccepted);
  companion.run(0.3);
  companion.hold({0, 0, -0.2});
  ASSERT_EQ(companion.arm(), Verdict::kAccepted);
  const double waited = companion.run_until([&] { return !companion.sim.autopilot().armed(); }, 15);
  EXPECT_NEAR(waited, 10, 0.1);
}

// Take-off.

TEST(SimAutopilot, AStepTo1500mmTakesFiveToEightSecondsAndSaysInAirASecondBeforeLiftOff) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SimulationSettings settings;
    settings.seed = seed;
    Companion companion(settings);
    companion.arm_offboard();
    const Autopilot& autopilot = companion.sim.autopilot();
    const double in_air = companion.run_until([&] { return autopilot.in_air(); }, 20);
    const double lift = in_air + companion.run_until([&] { return companion.height() > 0.02; }, 20);
    const double reached = lift + companion.run_until([&] { return companion.height() > 1.25; }, 20);
    EXPECT_GE(in_air, 1.2);
    EXPECT_LE(in_air, 1.9);
    EXPECT_GE(lift - in_air, 0.8);
    EXPECT_GE(reached, 5);
    EXPECT_LE(reached, 8);
  }
}

TEST(SimAutopilot, MotorsIdleForASecondAfterArmingWhateverTheThrust) {
  Companion companion;
  companion.target = [](Simulation& sim) {
    AttitudeSetpoint setpoint;
    setpoint.has_attitude = true;
    setpoint.thrust = 0.7;
    sim.autopilot().set_target(setpoint, sim.now());
  };
  ASSERT_EQ(companion.set_mode(FlightMode::kOffboard), Verdict::kAccepted);
  companion.run(0.3);
  ASSERT_EQ(companion.arm(), Verdict::kAccepted);
  companion.run(0.99);
  EXPECT_TRUE(companion.sim.quadrotor().on_ground());
  companion.run(0.5);
  EXPECT_FALSE(companion.sim.quadrotor().on_ground());
}

// Loss of the stream.

TEST(SimAutopilot, DropsOutBetween1040And1060msAfterTheLastSetpointThenLandsAndDisarms) {
  Companion companion;
  companion.fly();
  const Autopilot& autopilot = companion.sim.autopilot();
  companion.run_until([&] { return false; }, companion.period);
  companion.target(companion.sim);
  companion.target = {};
  const double waited = companion.run_until([&] { return autopilot.in_failsafe(); }, 3);
  EXPECT_GE(waited, 1.04);
  EXPECT_LE(waited, 1.06);
  EXPECT_EQ(autopilot.mode(), FlightMode::kPosctl);
  EXPECT_EQ(autopilot.intended_mode(), FlightMode::kOffboard);
  EXPECT_EQ(autopilot.system_status(), VehicleStatus::kFailsafe);
  const double disarmed = waited + companion.run_until([&] { return !autopilot.armed(); }, 30);
  EXPECT_NEAR(disarmed, 9.6, 1.2);
  EXPECT_TRUE(companion.sim.quadrotor().on_ground());
  EXPECT_LT(companion.sim.quadrotor().impact_speed(), 0.6);
  EXPECT_EQ(autopilot.mode(), FlightMode::kOffboard);  // and would arm again with a stream
}

TEST(SimAutopilot, GapsBelowASecondAndRatesDownTo1500mHzHoldOffboard) {
  for (const double period : {0.1, 0.3, 0.5, 0.6, 0.667, 0.9}) {
    Companion companion;
    companion.fly();
    companion.period = period;
    const double waited = companion.run_until([&] { return companion.sim.autopilot().in_failsafe(); }, 4);
    EXPECT_GE(waited, 4) << period;
  }
}

TEST(SimAutopilot, At900mHzOffboardFlapsInAndOut) {
  Companion companion;
  companion.fly();
  companion.period = 1 / 0.9;
  int changes = 0;
  bool before = false;
  for (int i = 0; i < 6000; ++i) {
    companion.run(0.001);
    const bool failsafe = companion.sim.autopilot().in_failsafe();
    changes += failsafe != before ? 1 : 0;
    before = failsafe;
  }
  EXPECT_GE(changes, 6);
}

TEST(SimAutopilot, TheLastSetpointStaysInForceUntilTheDropOut) {
  Companion companion;
  companion.fly();
  PositionSetpoint moving;
  moving.velocity = {1, 0, 0};
  companion.target = [moving](Simulation& sim) { sim.autopilot().set_target(moving, sim.now()); };
  companion.run(2);
  companion.target = {};
  companion.run(0.9);
  EXPECT_GT(companion.sim.truth().velocity.x(), 0.7);
}

TEST(SimAutopilot, ReturnsToOffboardByItselfWithin20To80msOfTheStream) {
  Companion companion;
  companion.fly();
  companion.target = {};
  companion.run(2);
  ASSERT_TRUE(companion.sim.autopilot().in_failsafe());
  companion.hold({0, 0, 1.5});
  companion.target(companion.sim);
  const double waited = companion.run_until([&] { return !companion.sim.autopilot().in_failsafe(); }, 1);
  EXPECT_GE(waited, 0.02);
  EXPECT_LE(waited, 0.08);
  EXPECT_EQ(companion.sim.autopilot().mode(), FlightMode::kOffboard);
}

TEST(SimAutopilot, TheActionOnLossIsAParameter) {
  for (const auto& [action, mode] : {std::pair{4, FlightMode::kLand}, std::pair{5, FlightMode::kLoiter}}) {
    Companion companion;
    companion.sim.autopilot().set_parameter(ParameterIndex::kOffboardLossAction, action);
    companion.fly();
    companion.target = {};
    companion.run(1.2);
    EXPECT_EQ(companion.sim.autopilot().mode(), mode);
    companion.run(15);
    EXPECT_EQ(companion.sim.autopilot().armed(), action == 5);
  }
}

// Landing.

TEST(SimAutopilot, AutoLandTouchesDownAfterSixToEightSecondsDisarmsTwoLaterAndIsBackInOffboard) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SimulationSettings settings;
    settings.seed = seed;
    Companion companion(settings);
    companion.fly();
    ASSERT_EQ(companion.set_mode(FlightMode::kLand), Verdict::kAccepted);
    const Autopilot& autopilot = companion.sim.autopilot();
    const double down = companion.run_until([&] { return !autopilot.in_air(); }, 20);
    EXPECT_GE(down, 6);
    EXPECT_LE(down, 8);
    EXPECT_TRUE(companion.sim.quadrotor().on_ground());
    EXPECT_NEAR(companion.run_until([&] { return !autopilot.armed(); }, 20), 2, 0.1);
    EXPECT_EQ(autopilot.mode(), FlightMode::kOffboard);
  }
}

TEST(SimAutopilot, ASetpointBelowTheGroundLandsItToo) {
  Companion companion;
  companion.fly();
  companion.hold({0, 0, -1});
  companion.run(10);
  EXPECT_FALSE(companion.sim.autopilot().armed());
  EXPECT_TRUE(said(companion.sim.autopilot().take_texts(), "Disarmed by landing"));
}

// The pilot.

TEST(SimAutopilot, ThePilotTakesOverAtOnceAndOffboardDoesNotComeBackByItself) {
  Companion companion;
  companion.fly();
  companion.sim.autopilot().take_over(FlightMode::kPosctl);
  EXPECT_EQ(companion.sim.autopilot().mode(), FlightMode::kPosctl);
  EXPECT_EQ(companion.sim.autopilot().intended_mode(), FlightMode::kPosctl);
  companion.sim.autopilot().move_sticks({0.5, 0, 0});
  const double x = companion.sim.truth().position.x();
  companion.run(4);
  EXPECT_EQ(companion.sim.autopilot().mode(), FlightMode::kPosctl);
  EXPECT_GT(companion.sim.truth().position.x() - x, 1);
  EXPECT_GT(companion.height(), 1.1);
  EXPECT_EQ(companion.sim.autopilot().system_status(), VehicleStatus::kArmed);
}

TEST(SimAutopilot, WithAPilotTheLossOfTheStreamHoldsThePositionUnderHim) {
  Companion companion;
  companion.sim.autopilot().take_over(FlightMode::kPosctl);
  companion.fly();
  companion.target = {};
  companion.run(6);
  EXPECT_EQ(companion.sim.autopilot().mode(), FlightMode::kPosctl);
  EXPECT_GT(companion.height(), 1.1);
}

// Restart.

TEST(SimAutopilot, ARestartInTheAirStopsTheMotorsAndForgetsEverythingButParameters) {
  Companion companion;
  companion.sim.autopilot().set_parameter(ParameterIndex::kOffboardLossAction, 4);
  companion.fly();
  companion.sim.restart_autopilot(std::chrono::seconds(3));
  EXPECT_TRUE(companion.sim.booting());
  companion.target = {};
  companion.run(3.5);
  EXPECT_FALSE(companion.sim.booting());
  EXPECT_TRUE(companion.sim.quadrotor().on_ground());
  EXPECT_FALSE(companion.sim.autopilot().armed());
  EXPECT_NEAR(companion.sim.now(), 0.5, 1e-9);
  EXPECT_EQ(companion.sim.autopilot().parameter(ParameterIndex::kOffboardLossAction), 4);
}

// Frames.

TEST(SimAutopilot, TheGroundIsNotAtZeroAndTheOriginDriftsUntilArming) {
  Companion companion;
  const auto local = [&] { return companion.sim.estimator().to_local(companion.sim.truth().position); };
  const Vector3 at_first = local();
  EXPECT_NE(at_first.z(), 0);
  companion.run(10);
  EXPECT_GT((local() - at_first).norm(), 0.02);
  companion.hold({0, 0, 1.5});
  ASSERT_EQ(companion.set_mode(FlightMode::kOffboard), Verdict::kAccepted);
  companion.run(0.3);
  ASSERT_EQ(companion.arm(), Verdict::kAccepted);
  companion.run(0.01);
  const Vector3 p_W{3, 4, 5};
  const Vector3 armed = companion.sim.estimator().to_local(p_W);
  companion.run(10);
  EXPECT_EQ(companion.sim.estimator().to_local(p_W), armed);
}

TEST(SimEstimator, LocalAndWorldFrameDifferByOriginAndHeading) {
  EstimatorSettings settings;
  settings.origin = {10, 20, -3};
  settings.heading = M_PI / 2;
  settings.boot_sigma.setZero();
  const Estimator estimator(settings, 1);
  EXPECT_NEAR((estimator.to_local({10, 21, -2}) - Vector3{1, 0, 1}).norm(), 0, 1e-12);
  EXPECT_NEAR((estimator.to_world(estimator.to_local({1, 2, 3})) - Vector3{1, 2, 3}).norm(), 0, 1e-12);
}

TEST(SimEstimator, ErrorsHaveTheirSizesAndTheDelayIsExact) {
  EstimatorSettings settings;
  settings.boot_sigma.setZero();
  settings.drift_sigma.setZero();
  settings.delay = 0.05;
  Estimator noisy(settings, 4);
  settings.position_sigma.setZero();
  settings.velocity_sigma.setZero();
  Estimator exact(settings, 4);
  double square = 0;
  constexpr int kSteps = 200'000;
  for (int i = 0; i < kSteps; ++i) {
    RigidState truth;
    truth.position.x() = i;
    noisy.step(0.001, truth, false);
    exact.step(0.001, truth, false);
    if (i >= 50) {
      EXPECT_EQ(exact.estimate().position.x(), i - 50);
    }
    const double error = noisy.estimate().position.y();
    square += error * error / kSteps;
  }
  EXPECT_NEAR(std::sqrt(square), 0.01, 0.002);
  exact.jump({0, 0, 1});
  exact.step(0.001, {}, true);
  EXPECT_EQ(exact.estimate().position.z(), 1);
}

// Tracking: no better than the real one.

struct Reference {
  Vector3 p;
  Vector3 v;
  Vector3 a;
};

/// A square of 3 m, 1 m/s, 1 m/s^2, at rest in its corners.
Reference square_at(double t) {
  constexpr double kLeg = 4;  // [s]
  static const std::array<Vector3, 4> corners{Vector3{0, 0, 0}, Vector3{3, 0, 0}, Vector3{3, 3, 0}, Vector3{0, 3, 0}};
  static const std::array<Vector3, 4> ways{Vector3{1, 0, 0}, Vector3{0, 1, 0}, Vector3{-1, 0, 0}, Vector3{0, -1, 0}};
  const auto leg = static_cast<std::size_t>(t / kLeg) % 4;
  const double u = std::fmod(t, kLeg);
  const double s = u < 1 ? u * u / 2 : u < 3 ? u - 0.5 : 3 - (4 - u) * (4 - u) / 2;
  const double v = std::min({u, 1.0, 4 - u});
  const double a = u < 1 ? 1 : u < 3 ? 0 : -1;
  return {corners[leg] + s * ways[leg], v * ways[leg], a * ways[leg]};
}

struct Tracking {
  double rms;
  double max;
};

/// Error of the estimated position over two rounds, the reference `lag` seconds late.
Tracking track_square(std::uint64_t seed, double lag, bool feed_forward, double noise = 1) {
  SimulationSettings settings;
  settings.seed = seed;
  settings.estimator.attitude_sigma *= noise;
  Companion companion(settings);
  companion.fly();
  companion.run(4);
  const double start = companion.sim.now();
  companion.target = [&](Simulation& sim) {
    const Reference reference = square_at(sim.now() - start);
    PositionSetpoint setpoint;
    setpoint.position = companion.home + Vector3{0, 0, 1.5} + reference.p;
    if (feed_forward) {
      setpoint.velocity = reference.v;
      setpoint.acceleration = reference.a;
    }
    setpoint.yaw = 0;
    sim.autopilot().set_target(setpoint, sim.now());
  };
  double square = 0;
  double max = 0;
  constexpr int kSteps = 32'000;
  for (int i = 0; i < kSteps; ++i) {
    companion.run(0.001);
    const Vector3 wanted =
        companion.home + Vector3{0, 0, 1.5} + square_at(std::max(companion.sim.now() - start - lag, 0.0)).p;
    const double error = (companion.sim.estimate().position - wanted).norm();
    square += error * error / kSteps;
    max = std::max(max, error);
  }
  return {std::sqrt(square), max};
}

TEST(SimTracking, WithVelocityAndAccelerationTheSquareIsFollowedToAQuarterOfAMetre) {
  double rms = 0;
  double max = 0;
  constexpr int kSeeds = 8;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Tracking tracking = track_square(seed, 0, true);
    rms += tracking.rms / kSeeds;
    max += tracking.max / kSeeds;
  }
  std::printf("position, velocity and acceleration: %.2f m RMS, %.2f m maximum, mean of %d\n", rms, max, kSeeds);
  EXPECT_GT(rms, 0.22);  // the real one: 0.23 to 0.26
  EXPECT_LT(rms, 0.28);
  EXPECT_GT(max, 0.40);  // 0.38 to 0.45
  EXPECT_LT(max, 0.60);
}

TEST(SimTracking, QuietSensorsLeaveTheDelayOfTheController) {
  const Tracking at_once = track_square(1, 0, true, 0.1);
  const Tracking late = track_square(1, 0.2, true, 0.1);
  std::printf("the same, quiet sensors: %.2f m RMS, and %.2f m against a reference 0.2 s late\n", at_once.rms,
              late.rms);
  EXPECT_GT(at_once.rms, 0.14);  // the real one: 0.14 to 0.18
  EXPECT_LT(at_once.rms, 0.19);
  EXPECT_LT(late.rms, 0.5 * at_once.rms);
}

TEST(SimTracking, PositionAloneLagsByAboutASecond) {
  const Tracking tracking = track_square(1, 0, false);
  std::printf("position alone: %.2f m RMS, %.2f m maximum\n", tracking.rms, tracking.max);
  EXPECT_NEAR(tracking.rms, 0.95, 0.1);  // the real one: 0.89
  EXPECT_LT(track_square(1, 0.8, false).rms, 0.5);
}

TEST(SimTracking, OtherVehiclesHoverAsWellAlsoWhenTheHoverThrustIsNotWhatTheAutopilotBelieves) {
  VehicleModel large;
  large.mass = 3;
  large.thrust_max = 70;
  large.thrust_min = 4;
  large.inertia = {0.08, 0.09, 0.15};
  large.arm = 0.25;
  VehicleModel small;
  small.mass = 0.3;
  small.thrust_max = 9;
  small.inertia = {0.0008, 0.0008, 0.0014};
  small.arm = 0.07;
  small.motor_lag = 0.03;
  small.drag = 0.1;
  small.angular_drag = 0.0005;
  for (const VehicleModel& model : {large, small}) {
    for (const double belief : {0.85, 1.0, 1.15}) {
      SimulationSettings settings;
      settings.vehicle = model;
      settings.hover_thrust = belief * hover_fraction(model);
      Companion companion(settings);
      companion.fly();
      companion.run(5);
      double farthest = 0;
      for (int i = 0; i < 1000; ++i) {
        companion.run(0.01);
        const Vector3 off = companion.sim.estimate().position - companion.home - Vector3{0, 0, 1.5};
        farthest = std::max(farthest, off.norm());
      }
      EXPECT_LT(farthest, 0.6) << model.mass << " kg";
      EXPECT_LT(companion.sim.truth().rate.norm(), 0.5);
    }
  }
}

// Attitude and rates.

TEST(SimTracking, AnAttitudeIsReachedAndItsThrustIsTheFractionOfFull) {
  SimulationSettings settings;
  settings.estimator.attitude_sigma.setZero();
  Companion companion(settings);
  companion.fly();
  const Quaternion tilt(Eigen::AngleAxis<double>(0.2, Vector3::UnitY()));
  companion.target = [&](Simulation& sim) {
    AttitudeSetpoint setpoint{true, tilt, Vector3::Zero(), 0.6};
    sim.autopilot().set_target(setpoint, sim.now());
  };
  companion.run(1);
  EXPECT_LT(companion.sim.truth().attitude.angularDistance(tilt), 0.02);
  double thrust = 0;
  for (const double each : companion.sim.truth().thrust) thrust += each;
  EXPECT_NEAR(thrust, 0.6 * companion.sim.quadrotor().model().thrust_max, 0.2);
}

TEST(SimTracking, ARateIsReachedAndHeld) {
  for (const Vector3& rate : {Vector3{0.8, 0, 0}, Vector3{0, -0.8, 0}, Vector3{0, 0, 0.8}}) {
    Companion companion;
    companion.fly();
    companion.target = [&](Simulation& sim) {
      AttitudeSetpoint setpoint{false, Quaternion::Identity(), rate, 0.5};
      sim.autopilot().set_target(setpoint, sim.now());
    };
    companion.run(0.7);
    EXPECT_LT((companion.sim.truth().rate - rate).norm(), 0.15);
  }
}

TEST(SimAutopilot, TheSameSeedFliesTheSameFlightToTheBit) {
  const auto fly = [](std::uint64_t seed) {
    SimulationSettings settings;
    settings.seed = seed;
    settings.wind = {{1, 0, 0}, 2, 1};
    Companion companion(settings);
    companion.fly();
    return companion.sim.truth().position;
  };
  EXPECT_EQ(fly(5), fly(5));
  EXPECT_NE(fly(5), fly(6));
}

}  // namespace
}  // namespace swiftlet::tools
