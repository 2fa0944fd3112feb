#include "swiftlet/vehicle_state.hpp"

#include <cmath>
#include <limits>

#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr Real kTolerance = sizeof(Real) == 8 ? Real(1e-9) : Real(1e-5);

VehicleState moving() {
  VehicleState state;
  state.time = 1'000'000;
  state.position = {1, 2, 3};
  state.velocity = {1, 0, 0};
  return state;
}

PredictorSettings at_once(TimeUs longest) {
  PredictorSettings settings;
  settings.response_time = 0;
  settings.longest = longest;
  return settings;
}

/// What is learnt in `seconds` of hovering on `thrust` [m/s^2] while `disturbance` acts, with odometry every `period`
/// [us] and an axis tilted north by `tilt` [rad].
Vector3 learned(const PredictorSettings& settings, const Vector3& disturbance, Real seconds, Real thrust = kGravity,
                TimeUs period = 20'000, Real tilt = 0) {
  StatePredictor predictor(settings);
  VehicleState state = moving();
  state.attitude = Quaternion(std::cos(tilt / 2), -std::sin(tilt / 2), 0, 0);
  const Vector3 acceleration =
      state.attitude.toRotationMatrix().col(2) * thrust - Vector3{0, 0, kGravity} + disturbance;
  const int steps = static_cast<int>(seconds / to_seconds(period));
  for (int i = 0; i < steps; ++i) {
    predictor.record(state.time, Vector3::Zero(), thrust);
    predictor.learn(state);
    state.time += period;
    state.velocity += acceleration * to_seconds(period);
  }
  return predictor.disturbance();
}

TEST(StatePredictor, LearnsTheDisturbanceFromWhatThrustDoesNotExplain) {
  const Vector3 wind{Real(0.5), Real(-0.8), Real(0.3)};
  const Real tolerance = sizeof(Real) == 8 ? Real(1e-6) : Real(1e-2);
  EXPECT_LE((learned({}, wind, 3) - wind).norm(), tolerance);
  EXPECT_LE((learned({}, wind, 3, 8, 33'000, Real(0.3)) - wind).norm(), tolerance);
  // First order: within its time constant two thirds of the way (implicit steps: a little less).
  const Real share = learned({}, {1, 0, 0}, Real(0.12)).x();
  EXPECT_GT(share, Real(0.5));
  EXPECT_LT(share, Real(0.7));
}

TEST(StatePredictor, TheDisturbanceIsBoundedAndOneWildSampleMovesItLittle) {
  const PredictorSettings settings;
  EXPECT_NEAR(learned(settings, {50, -50, 0}, 3).x(), settings.disturbance_max, 1e-3);
  EXPECT_NEAR(learned(settings, {50, -50, 0}, 3).y(), -settings.disturbance_max, 1e-3);
  EXPECT_LE(learned(settings, {1000, 0, 0}, Real(0.04)).x(), settings.disturbance_max / 5);
}

TEST(StatePredictor, LearnsNothingFromNumbersThatAreNoneRepeatedOrAfterAGap) {
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  StatePredictor predictor({});
  VehicleState state = moving();
  predictor.learn(state);
  for (int i = 0; i < 50; ++i) {
    VehicleState bad = state;
    bad.time += 10'000;
    if (i % 3 == 0) bad.velocity[i % 2] = nan;
    if (i % 3 == 1) bad.attitude = Quaternion(nan, 0, 0, 1);
    if (i % 3 == 2) bad.time = state.time;  // the same again, though moved
    if (i % 3 == 2) bad.velocity[0] = 9;
    predictor.learn(bad);
    if (i % 10 == 9) {  // after a gap, or a clock that went back
      state.time += i % 20 == 9 ? 500'000 : -200'000;
      state.velocity[0] += 1;
      predictor.learn(state);
    }
  }
  EXPECT_EQ(predictor.disturbance().norm(), 0);
}

TEST(StatePredictor, ForgetsTheDisturbanceWhenReset) {
  StatePredictor predictor({});
  VehicleState state = moving();
  for (int i = 0; i < 10; ++i) {
    predictor.learn(state);
    state.time += 20'000;
  }
  EXPECT_LT(predictor.disturbance().z(), Real(1.3) * kGravity);
  predictor.reset();
  EXPECT_EQ(predictor.disturbance().norm(), 0);
}

TEST(StatePredictor, TheDisturbanceMovesThePrediction) {
  PredictorSettings settings = at_once(500'000);
  StatePredictor predictor(settings);
  VehicleState state = moving();
  for (int i = 0; i < 100; ++i) {
    predictor.record(state.time, Vector3::Zero(), kGravity);
    predictor.learn(state);
    state.time += 20'000;
    state.velocity.y() += Real(0.5) * Real(0.02);
  }
  const VehicleState later = predictor.predict(state, state.time + 200'000);
  EXPECT_NEAR(later.velocity.y() - state.velocity.y(), 0.1, 1e-2);
}

TEST(StatePredictor, WithoutCommandsItGoesStraightOn) {
  const StatePredictor predictor({});
  const VehicleState state = predictor.predict(moving(), 1'200'000);
  EXPECT_NEAR(state.position[0], 1.2, kTolerance);
  EXPECT_NEAR(state.velocity[0], 1, kTolerance);
  EXPECT_EQ(state.time, 1'200'000);
}

// Without lag: 2 m/s^2 north from 1.0 s, upwards from 1.1 s on.
TEST(StatePredictor, IntegratesTheCommandsThatActMeanwhile) {
  StatePredictor predictor(at_once(500'000));
  predictor.record(0, {9, 9, 9}, kGravity);
  predictor.record(900'000, {0, 2, 0}, kGravity);
  predictor.record(1'100'000, {0, 0, 2}, kGravity);
  predictor.record(1'900'000, {7, 7, 7}, kGravity);
  const VehicleState state = predictor.predict(moving(), 1'200'000);
  EXPECT_NEAR(state.velocity[1], 0.2, kTolerance);
  EXPECT_NEAR(state.velocity[2], 0.2, kTolerance);
  EXPECT_NEAR(state.position[1], 2 + 0.01 + 0.02, kTolerance);
  EXPECT_NEAR(state.position[2], 3 + 0.01, kTolerance);
}

TEST(StatePredictor, TheAnswerLagsBehindTheCommand) {
  StatePredictor predictor({});
  for (int i = 0; i < 30; ++i) predictor.record(TimeUs{900'000} + TimeUs{10'000} * i, {0, 0, 2}, kGravity + 2);
  const VehicleState state = predictor.predict(moving(), 1'150'000);
  EXPECT_GT(state.velocity[2], 0.1);
  EXPECT_LE(state.velocity[2], 0.3 + kTolerance);
}

TEST(StatePredictor, TurnsByTheBodyRates) {
  VehicleState state = moving();
  state.body_rates = {0, 0, 1};
  EXPECT_NEAR(heading_of(StatePredictor({}).predict(state, 1'250'000).attitude.toRotationMatrix()), 0.25, kTolerance);
}

TEST(StatePredictor, GoesNoFurtherThanItsHorizonAndNeverBack) {
  const StatePredictor predictor(at_once(300'000));
  EXPECT_NEAR(predictor.predict(moving(), 9'000'000).position[0], 1.3, kTolerance);
  EXPECT_EQ(predictor.predict(moving(), 500'000).position[0], 1);
}

TEST(StatePredictor, ForgetsTheOldestCommandsOfALongFlight) {
  StatePredictor predictor(at_once(500'000));
  for (int i = 0; i < 500; ++i) predictor.record(TimeUs{10'000} * i, {0, 1, 0}, kGravity);
  VehicleState state = moving();
  state.time = 4'900'000;
  EXPECT_NEAR(predictor.predict(state, 5'000'000).velocity[1], 0.1, kTolerance);
  predictor.reset();
  EXPECT_NEAR(predictor.predict(state, 5'000'000).velocity[1], 0, kTolerance);
}

TEST(StatePredictor, IgnoresCommandsThatAreNoneOrOutOfOrder) {
  StatePredictor predictor(at_once(500'000));
  predictor.record(900'000, {0, 1, 0}, kGravity);
  predictor.record(950'000, {0, std::numeric_limits<Real>::quiet_NaN(), 0}, kGravity);
  predictor.record(800'000, {0, 50, 0}, kGravity);
  EXPECT_NEAR(predictor.predict(moving(), 1'100'000).velocity[1], 0.1, kTolerance);
}

TEST(VehicleState, KnowsAnUnusableOne) {
  EXPECT_TRUE(is_usable(moving()));
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  for (int field = 0; field < 6; ++field) {
    VehicleState state = moving();
    if (field == 0) state.position[2] = nan;
    if (field == 1) state.velocity[0] = std::numeric_limits<Real>::infinity();
    if (field == 2) state.attitude = Quaternion(nan, 0, 0, 0);
    if (field == 3) state.attitude = Quaternion(0, 0, 0, 0);
    if (field == 4) state.attitude = Quaternion(2, 0, 0, 0);
    if (field == 5) state.body_rates[1] = -std::numeric_limits<Real>::max();
    EXPECT_FALSE(is_usable(state));
    EXPECT_EQ(StatePredictor({}).predict(state, 2'000'000).time, state.time);
  }
}

}  // namespace
}  // namespace swiftlet
