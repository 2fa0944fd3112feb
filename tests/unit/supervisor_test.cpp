#include "swiftlet/supervisor.hpp"

#include <limits>

#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr TimeUs kTick = 10'000;
constexpr TimeUs kStart = 5'000'000'000;
constexpr Real kNan = std::numeric_limits<Real>::quiet_NaN();

/// A flight at 1 m/s along x, stepped at 100 Hz with odometry at 50 Hz, 20 ms old. Faults are switched on by the tests.
struct Flight {
  Supervisor supervisor;
  SupervisorInputs inputs;
  Decision decision;
  TimeUs now = kStart;  // true time
  TimeUs clock_error = 0;
  bool moving = false;
  bool braking = false;
  TimeUs braking_since = 0;
  // Faults.
  bool link_cut = false;
  bool odometry_stopped = false;
  bool odometry_is_nan = false;
  bool sending_stopped = false;
  Vector3 estimate_error = Vector3::Zero();
  Vector3 reference_shift = Vector3::Zero();

  explicit Flight(const SupervisorSettings& settings = {}) : supervisor(settings) {
    inputs.airborne = true;
    inputs.map_id = inputs.plan_map_id = 7;
  }

  [[nodiscard]] Vector3 path(TimeUs time) const { return {to_seconds(time - kStart), 0, 1}; }

  Decision step() {
    now += kTick;
    inputs.now = now + clock_error;
    if (!link_cut) inputs.last_message = inputs.now;
    if (!link_cut && !odometry_stopped && (now / kTick) % 2 == 0) {
      inputs.has_odometry = true;
      inputs.odometry.time = inputs.now - 20'000;
      inputs.odometry.position = path(now - 20'000) + estimate_error;
      inputs.odometry.velocity = {1, 0, 0};
      if (odometry_is_nan) inputs.odometry.position[1] = kNan;
      inputs.reference_position = path(now - 20'000) + reference_shift;
    }
    inputs.reference_at_rest = !moving || (braking && now - braking_since > 1'500'000);
    decision = supervisor.step(inputs);
    if (decision.setpoints != Setpoints::kNone && !sending_stopped) inputs.last_setpoint = inputs.now;
    reference_shift += decision.position_shift;
    if (decision.brake && !braking) {
      braking = true;
      braking_since = now;
    }
    return decision;
  }

  void run(TimeUs duration) {
    for (const TimeUs end = now + duration; now < end;) step();
  }

  /// Steps until `state`; the time it took [us], or -1 after five seconds.
  TimeUs until(FlightState state) {
    const TimeUs begin = now;
    while (step().state != state) {
      if (now - begin > 5 * kSecondUs) return -1;
    }
    return now - begin;
  }

  void take_control() {
    inputs.engage = true;
    run(100'000);
    inputs.armed = inputs.in_our_mode = true;
    run(100'000);
  }
  void fly() {
    take_control();
    moving = true;
    run(500'000);
  }
};

Flight flying() {
  Flight flight;
  flight.fly();
  EXPECT_TRUE(flight.decision.state == FlightState::kFlying);
  return flight;
}

/// Checks that the flight brakes for `reason` within `limit`, then holds, in control and without further ado.
void expect_brake(Flight& flight, Reason reason, TimeUs limit) {
  const TimeUs taken = flight.until(FlightState::kBraking);
  EXPECT_GE(taken, 0);
  EXPECT_LE(taken, limit);
  EXPECT_TRUE(flight.decision.brake);
  EXPECT_TRUE(flight.decision.reason == reason);
  EXPECT_TRUE(flight.decision.setpoints != Setpoints::kNone);
}

/// Checks that control is given up for `reason` within `limit`, and that nothing is sent or asked for afterwards.
void expect_yield(Flight& flight, Reason reason, TimeUs limit) {
  const TimeUs taken = flight.until(FlightState::kYielded);
  EXPECT_GE(taken, 0);
  EXPECT_LE(taken, limit);
  EXPECT_TRUE(flight.decision.reason == reason);
  for (int i = 0; i < 200; ++i) {
    EXPECT_TRUE(flight.decision.setpoints == Setpoints::kNone);
    EXPECT_FALSE(flight.decision.may_ask_for_control);
    EXPECT_FALSE(flight.decision.may_plan);
    flight.step();
  }
}

TEST(Supervisor, GoesFromIdleThroughReadyAndHoldingToFlyingAndArrives) {
  Flight flight;
  flight.run(500'000);
  EXPECT_TRUE(flight.decision.state == FlightState::kIdle);
  EXPECT_TRUE(flight.decision.setpoints == Setpoints::kNone);
  flight.inputs.engage = true;
  flight.run(100'000);
  EXPECT_TRUE(flight.decision.state == FlightState::kReady);
  EXPECT_TRUE(flight.decision.setpoints == Setpoints::kPosition);
  EXPECT_TRUE(flight.decision.hold_here);
  EXPECT_TRUE(flight.decision.may_ask_for_control);
  flight.inputs.armed = true;
  flight.run(100'000);
  EXPECT_TRUE(flight.decision.state == FlightState::kReady);
  flight.inputs.in_our_mode = flight.inputs.standing = true;
  flight.run(100'000);
  EXPECT_TRUE(flight.decision.state == FlightState::kReady);
  flight.inputs.standing = false;
  flight.run(100'000);
  EXPECT_TRUE(flight.decision.state == FlightState::kHolding);
  EXPECT_FALSE(flight.decision.hold_here);
  EXPECT_FALSE(flight.decision.may_ask_for_control);
  EXPECT_TRUE(flight.decision.may_plan);
  EXPECT_FALSE(flight.decision.replan);
  flight.inputs.goal_pending = true;
  EXPECT_TRUE(flight.step().replan);
  flight.moving = true;
  flight.inputs.goal_pending = false;
  flight.run(3 * kSecondUs);
  EXPECT_TRUE(flight.decision.state == FlightState::kFlying);
  EXPECT_TRUE(flight.decision.setpoints == Setpoints::kAnyForm);
  EXPECT_FALSE(flight.decision.brake);
  flight.moving = false;
  flight.run(100'000);
  EXPECT_TRUE(flight.decision.state == FlightState::kHolding);
  EXPECT_TRUE(flight.decision.reason == Reason::kArrived);
  EXPECT_EQ(flight.supervisor.event_count(), 4U);
}

TEST(Supervisor, LandsByItsOwnRequestWithoutCallingItATakeOver) {
  Flight flight = flying();
  flight.moving = false;
  flight.run(100'000);
  flight.inputs.landing = true;
  flight.run(100'000);
  flight.inputs.in_our_mode = false;
  EXPECT_EQ(flight.until(FlightState::kYielded), kTick);
  EXPECT_TRUE(flight.decision.reason == Reason::kLandingRequested);
  flight.inputs.armed = false;
  EXPECT_EQ(flight.until(FlightState::kLanded), kTick);
  flight.inputs.in_our_mode = true;  // PX4 goes back to OFFBOARD after landing
  flight.run(kSecondUs);
  EXPECT_TRUE(flight.decision.state == FlightState::kLanded);
  EXPECT_TRUE(flight.decision.setpoints == Setpoints::kNone);
  flight.inputs.engage = false;
  flight.run(100'000);
  EXPECT_TRUE(flight.decision.state == FlightState::kIdle);
}

TEST(Supervisor, DisarmedInControlIsLanded) {
  Flight flight = flying();
  flight.inputs.armed = false;
  EXPECT_EQ(flight.until(FlightState::kLanded), kTick);
  EXPECT_TRUE(flight.decision.setpoints == Setpoints::kNone);
}

TEST(Supervisor, StopsOnRequest) {
  Flight flight = flying();
  flight.inputs.stop = true;
  expect_brake(flight, Reason::kStopRequested, kTick);
  EXPECT_GE(flight.until(FlightState::kHolding), 0);
  flight.inputs.goal_pending = true;
  EXPECT_FALSE(flight.step().replan);
  flight.inputs.stop = false;
  flight.moving = false;
  EXPECT_TRUE(flight.step().replan);
}

// From here on: one case for each row of the table in docs/flight.md.

TEST(Supervisor, LinkCutBrakesAfter200msAndYieldsAfterOneSecond) {
  Flight flight = flying();
  flight.link_cut = true;
  expect_brake(flight, Reason::kOdometryStale, 210'000);
  EXPECT_TRUE(flight.decision.setpoints == Setpoints::kPosition);
  expect_yield(flight, Reason::kLinkLost, 820'000);
}

TEST(Supervisor, StaleOdometryBrakesAfter200msOnThePositionForm) {
  Flight flight = flying();
  flight.odometry_stopped = true;
  expect_brake(flight, Reason::kOdometryStale, 210'000);
  EXPECT_TRUE(flight.decision.setpoints == Setpoints::kPosition);
  EXPECT_GE(flight.until(FlightState::kHolding), 0);
  EXPECT_FALSE(flight.decision.may_plan);
  EXPECT_TRUE(flight.decision.setpoints == Setpoints::kPosition);
}

TEST(Supervisor, NanOdometryGoesToThePositionFormAtOnceAndBrakesAfter200ms) {
  Flight flight = flying();
  flight.odometry_is_nan = true;
  flight.step();
  EXPECT_TRUE(flight.step().setpoints == Setpoints::kPosition);
  expect_brake(flight, Reason::kOdometryInvalid, 210'000);
}

TEST(Supervisor, OneNanSampleBrakesNothing) {
  Flight flight = flying();
  flight.odometry_is_nan = true;
  flight.run(40'000);
  flight.odometry_is_nan = false;
  flight.run(500'000);
  EXPECT_TRUE(flight.decision.state == FlightState::kFlying);
  EXPECT_TRUE(flight.decision.setpoints == Setpoints::kAnyForm);
}

TEST(Supervisor, PositionJumpMovesTheReferenceAlongBrakesAndWaitsForTheOperator) {
  Flight flight = flying();
  flight.estimate_error = {0, Real(0.8), 0};
  expect_brake(flight, Reason::kPositionJump, 2 * kTick);
  EXPECT_NEAR(flight.reference_shift[1], 0.8, 0.05);
  EXPECT_GE(flight.until(FlightState::kHolding), 0);
  EXPECT_NEAR(flight.reference_shift[1], 0.8, 0.05);
  flight.inputs.goal_pending = true;
  flight.run(kSecondUs);
  EXPECT_FALSE(flight.decision.may_plan);
  flight.inputs.engage = false;
  flight.step();
  flight.inputs.engage = true;
  EXPECT_TRUE(flight.step().may_plan);
}

TEST(Supervisor, AutopilotRestartYieldsAtOnce) {
  Flight flight = flying();
  ++flight.inputs.autopilot_boots;
  expect_yield(flight, Reason::kAutopilotRestart, kTick);
}

TEST(Supervisor, PilotTakesOverAtOnceFromEveryStateInControl) {
  for (const int brake_first : {0, 1, 2}) {
    Flight flight = flying();
    if (brake_first > 0) {
      flight.inputs.stop = true;
      flight.run(brake_first == 1 ? 100'000 : 3 * kSecondUs);
    }
    flight.inputs.in_our_mode = false;
    expect_yield(flight, Reason::kPilotTookOver, kTick);
    // The mode coming back is no invitation.
    flight.inputs.in_our_mode = true;
    flight.run(kSecondUs);
    EXPECT_TRUE(flight.decision.state == FlightState::kYielded);
    // The operator's fresh word is: first the present position is streamed.
    flight.inputs.engage = false;
    flight.run(50'000);
    flight.inputs.engage = true;
    flight.inputs.in_our_mode = false;
    flight.run(50'000);
    EXPECT_TRUE(flight.decision.state == FlightState::kReady);
    EXPECT_TRUE(flight.decision.hold_here);
  }
}

TEST(Supervisor, ModeOrArmingTakenBackBeforeControlBeginsIsAYield) {
  for (const bool disarmed : {false, true}) {
    Flight flight;
    flight.inputs.engage = true;
    flight.run(100'000);
    flight.inputs.in_our_mode = flight.inputs.armed = flight.inputs.standing = true;
    flight.run(2 * kSecondUs);
    EXPECT_TRUE(flight.decision.state == FlightState::kReady);
    (disarmed ? flight.inputs.armed : flight.inputs.in_our_mode) = false;
    EXPECT_TRUE(flight.step().state == FlightState::kYielded);
    EXPECT_TRUE(flight.decision.reason == (disarmed ? Reason::kDisarmed : Reason::kPilotTookOver));
    flight.inputs.armed = flight.inputs.in_our_mode = true;
    flight.inputs.standing = false;
    for (int i = 0; i < 100; ++i) {
      EXPECT_TRUE(flight.decision.setpoints == Setpoints::kNone);
      EXPECT_FALSE(flight.decision.may_ask_for_control);
      flight.step();
    }
    flight.inputs.engage = false;
    flight.run(50'000);
    flight.inputs.engage = true;
    EXPECT_TRUE(flight.step().state == FlightState::kReady);
  }
}

TEST(Supervisor, AModeTakenAwayBehindAFaultIsNotAskedForAgain) {
  Flight flight;
  flight.inputs.engage = flight.inputs.in_our_mode = true;
  flight.run(100'000);
  flight.link_cut = true;
  EXPECT_GE(flight.until(FlightState::kIdle), 0);
  flight.inputs.in_our_mode = false;
  flight.link_cut = false;
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(flight.step().may_ask_for_control);
}

TEST(Supervisor, AnAutopilotThatRestartsOnceItHasGrantedSomethingIsLetGo) {
  Flight flight;
  flight.inputs.engage = true;
  flight.run(100'000);
  ++flight.inputs.autopilot_boots;  // nothing of ours is lost
  flight.run(100'000);
  EXPECT_TRUE(flight.decision.state == FlightState::kReady);
  flight.inputs.in_our_mode = true;
  flight.run(100'000);
  ++flight.inputs.autopilot_boots;
  EXPECT_TRUE(flight.step().state == FlightState::kYielded);
  EXPECT_TRUE(flight.decision.reason == Reason::kAutopilotRestart);
}

TEST(Supervisor, StarvedSetpointsBrakeAfter250msAndYieldAfter900ms) {
  Flight flight = flying();
  flight.sending_stopped = true;
  expect_brake(flight, Reason::kSetpointStarved, 260'000);
  expect_yield(flight, Reason::kSetpointStarved, 650'000);
}

TEST(Supervisor, AStallOfOurselvesBrakesAtTheNextStep) {
  Flight flight = flying();
  flight.now += 400'000;
  expect_brake(flight, Reason::kSetpointStarved, kTick);
  EXPECT_EQ(flight.decision.clock_shift, 0);
}

TEST(Supervisor, AClockJumpEitherWayBrakesAtOnceAndShiftsTheReference) {
  for (const TimeUs jump : {-20 * kSecondUs, -2 * kTick, 3 * kSecondUs, 100'000 * kSecondUs}) {
    Flight flight = flying();
    flight.clock_error = jump;
    flight.step();
    EXPECT_TRUE(flight.decision.state == FlightState::kBraking);
    EXPECT_TRUE(flight.decision.reason == Reason::kClockJump);
    EXPECT_EQ(flight.decision.clock_shift, jump + kTick);
    flight.run(500'000);  // neither old stamps nor new ones are mistaken
    EXPECT_TRUE(flight.decision.state == FlightState::kBraking);
    EXPECT_TRUE(flight.decision.setpoints == Setpoints::kAnyForm);
    EXPECT_EQ(flight.decision.clock_shift, 0);
    EXPECT_GE(flight.until(FlightState::kHolding), 0);
  }
}

TEST(Supervisor, ALinkCutAcrossAClockJumpIsStillNoticed) {
  for (const TimeUs jump : {-20 * kSecondUs, 20 * kSecondUs}) {
    Flight flight = flying();
    flight.link_cut = true;
    flight.clock_error = jump;
    expect_yield(flight, Reason::kLinkLost, 1'020'000);  // the jump hides one step
  }
}

TEST(Supervisor, AReplacedMapBrakesAtOnceAndAsksForAPlan) {
  Flight flight = flying();
  flight.inputs.map_id = 8;
  expect_brake(flight, Reason::kMapReplaced, kTick);
  EXPECT_GE(flight.until(FlightState::kHolding), 0);
  flight.inputs.goal_pending = true;
  EXPECT_TRUE(flight.step().replan);
}

TEST(Supervisor, AFullStorageIsNotedInFlightAndForbidsAStart) {
  Flight flight = flying();
  const std::uint32_t before = flight.supervisor.event_count();
  flight.inputs.storage_full = true;
  flight.run(kSecondUs);
  EXPECT_TRUE(flight.decision.state == FlightState::kFlying);
  EXPECT_EQ(flight.supervisor.event_count(), before + 1);
  EXPECT_TRUE(flight.supervisor.event(before).reason == Reason::kStorageFull);
  Flight on_ground;
  on_ground.inputs.storage_full = true;
  on_ground.inputs.engage = true;
  on_ground.run(kSecondUs);
  EXPECT_TRUE(on_ground.decision.state == FlightState::kIdle);
  EXPECT_TRUE(on_ground.decision.reason == Reason::kStorageFull);
}

TEST(Supervisor, AFullStorageThatIsNotNeededIsNotedAndForbidsNothing) {
  SupervisorSettings settings;
  settings.storage_needed = false;
  Flight flight(settings);
  const std::uint32_t before = flight.supervisor.event_count();
  flight.inputs.storage_full = true;
  flight.run(kSecondUs);
  EXPECT_TRUE(flight.supervisor.event(before).reason == Reason::kStorageFull);
  flight.fly();
  EXPECT_TRUE(flight.decision.state == FlightState::kFlying);
}

TEST(Supervisor, ATrackingErrorBeyondTheTubeBrakesWithTheNextSample) {
  Flight flight = flying();
  flight.estimate_error = {0, Real(0.16), 0};
  expect_brake(flight, Reason::kTrackingError, 2 * kTick);
  Flight on_ground;
  on_ground.inputs.airborne = false;
  on_ground.reference_shift = {0, 0, 1};  // a take-off's reference is above the vehicle
  on_ground.fly();
  EXPECT_TRUE(on_ground.decision.state == FlightState::kFlying);
}

TEST(Supervisor, ThreeDeadlineMissesInARowBrake) {
  Flight flight = flying();
  flight.inputs.deadline_misses = 2;
  flight.run(kSecondUs);
  EXPECT_TRUE(flight.decision.state == FlightState::kFlying);
  flight.inputs.deadline_misses = 3;
  expect_brake(flight, Reason::kDeadlineMisses, kTick);
  EXPECT_GE(flight.until(FlightState::kHolding), 0);
  EXPECT_TRUE(flight.decision.may_plan);
}

TEST(Supervisor, ABlockedPathIsReplannedAndBrakesAfter100ms) {
  Flight flight = flying();
  flight.inputs.path_blocked = true;
  EXPECT_TRUE(flight.step().replan);
  flight.run(50'000);
  flight.inputs.path_blocked = false;  // a plan round it was found
  flight.run(kSecondUs);
  EXPECT_TRUE(flight.decision.state == FlightState::kFlying);
  flight.inputs.path_blocked = true;
  expect_brake(flight, Reason::kPathBlocked, 110'000);
}

TEST(Supervisor, MarginsThatTheMapDoesNotCoverForbidAStart) {
  Flight flight;
  flight.inputs.margins_covered = false;
  flight.inputs.engage = true;
  flight.run(kSecondUs);
  EXPECT_TRUE(flight.decision.state == FlightState::kIdle);
  EXPECT_TRUE(flight.decision.reason == Reason::kMarginsTooSmall);
}

TEST(Supervisor, ReadyFallsBackToIdleWithTheReason) {
  Flight flight;
  flight.inputs.engage = true;
  flight.run(100'000);
  flight.odometry_is_nan = true;
  flight.run(40'000);
  EXPECT_TRUE(flight.decision.state == FlightState::kIdle);
  EXPECT_TRUE(flight.decision.reason == Reason::kOdometryInvalid);
  EXPECT_FALSE(flight.decision.hold_here);
}

TEST(Supervisor, EveryTransitionIsKeptWithItsReasonUntilTheRingIsFull) {
  Flight flight;
  flight.run(100'000);
  for (int i = 0; i < 100; ++i) {
    flight.inputs.engage = !flight.inputs.engage;
    flight.run(50'000);
  }
  EXPECT_EQ(flight.supervisor.event_count(), 100U);
  TimeUs last = 0;
  for (std::uint32_t n = 100 - Supervisor::kEvents; n < 100; ++n) {
    const FlightEvent& event = flight.supervisor.event(n);
    EXPECT_GT(event.time, last);
    EXPECT_TRUE(event.reason == (n % 2 == 0 ? Reason::kEngaged : Reason::kReleased));
    EXPECT_TRUE(event.to == (n % 2 == 0 ? FlightState::kReady : FlightState::kIdle));
    last = event.time;
  }
}

TEST(Supervisor, SameInputsGiveTheSameDecisions) {
  Flight a = flying();
  Flight b = flying();
  a.odometry_stopped = b.odometry_stopped = true;
  for (int i = 0; i < 300; ++i) {
    a.step();
    b.step();
    EXPECT_TRUE(a.decision.state == b.decision.state && a.decision.reason == b.decision.reason &&
                a.decision.setpoints == b.decision.setpoints && a.decision.brake == b.decision.brake);
  }
}

TEST(Supervisor, DescribesEveryStateAndReason) {
  for (int i = 0; i <= static_cast<int>(FlightState::kLanded); ++i) {
    const char* text = describe(static_cast<FlightState>(i));
    EXPECT_FALSE(text[0] == 'u' && text[1] == 'n');
  }
  for (int i = 0; i <= static_cast<int>(Reason::kMarginsTooSmall); ++i) {
    const char* text = describe(static_cast<Reason>(i));
    EXPECT_FALSE(text[0] == 'u' && text[1] == 'n');
  }
}

}  // namespace
}  // namespace swiftlet
