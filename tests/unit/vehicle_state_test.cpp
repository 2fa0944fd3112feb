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

TEST(StatePredictor, WithoutCommandsItGoesStraightOn) {
  const StatePredictor predictor({});
  const VehicleState state = predictor.predict(moving(), 1'200'000);
  EXPECT_NEAR(state.position[0], 1.2, kTolerance);
  EXPECT_NEAR(state.velocity[0], 1, kTolerance);
  EXPECT_EQ(state.time, 1'200'000);
}

// Without lag: 2 m/s^2 north from 1.0 s, upwards from 1.1 s on.
TEST(StatePredictor, IntegratesTheCommandsThatActMeanwhile) {
  StatePredictor predictor({0, 500'000});
  predictor.record(0, {9, 9, 9}, Vector3::Zero());
  predictor.record(900'000, {0, 2, 0}, Vector3::Zero());
  predictor.record(1'100'000, {0, 1, 2}, {0, 1, 0});
  predictor.record(1'900'000, {7, 7, 7}, Vector3::Zero());
  const VehicleState state = predictor.predict(moving(), 1'200'000);
  EXPECT_NEAR(state.velocity[1], 0.2, kTolerance);
  EXPECT_NEAR(state.velocity[2], 0.2, kTolerance);
  EXPECT_NEAR(state.position[1], 2 + 0.01 + 0.02, kTolerance);
  EXPECT_NEAR(state.position[2], 3 + 0.01, kTolerance);
}

TEST(StatePredictor, TheAnswerLagsBehindTheCommand) {
  StatePredictor predictor({Real(0.2), 500'000});
  for (int i = 0; i < 30; ++i) predictor.record(TimeUs{900'000} + TimeUs{10'000} * i, {0, 0, 2}, Vector3::Zero());
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
  const StatePredictor predictor({0, 300'000});
  EXPECT_NEAR(predictor.predict(moving(), 9'000'000).position[0], 1.3, kTolerance);
  EXPECT_EQ(predictor.predict(moving(), 500'000).position[0], 1);
}

TEST(StatePredictor, ForgetsTheOldestCommandsOfALongFlight) {
  StatePredictor predictor({0, 500'000});
  for (int i = 0; i < 500; ++i) predictor.record(TimeUs{10'000} * i, {0, 1, 0}, Vector3::Zero());
  VehicleState state = moving();
  state.time = 4'900'000;
  EXPECT_NEAR(predictor.predict(state, 5'000'000).velocity[1], 0.1, kTolerance);
  predictor.reset();
  EXPECT_NEAR(predictor.predict(state, 5'000'000).velocity[1], 0, kTolerance);
}

TEST(StatePredictor, IgnoresCommandsThatAreNoneOrOutOfOrder) {
  StatePredictor predictor({0, 500'000});
  predictor.record(900'000, {0, 1, 0}, Vector3::Zero());
  predictor.record(950'000, {0, std::numeric_limits<Real>::quiet_NaN(), 0}, Vector3::Zero());
  predictor.record(800'000, {0, 50, 0}, Vector3::Zero());
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
