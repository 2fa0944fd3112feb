#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "map_test_worlds.hpp"
#include "sim/clearance_meter.hpp"
#include "sim/quadrotor.hpp"
#include "sim/wind.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kStep = 0.001;  // [s]
const Vector3 kCalm = Vector3::Zero();

void run(Quadrotor& quadrotor, double seconds, const MotorCommands& commands, const Vector3& wind_W = kCalm) {
  for (int i = 0; i < std::lround(seconds / kStep); ++i) quadrotor.step(kStep, commands, wind_W);
}

MotorCommands all(double command) { return {command, command, command, command}; }

/// In the air at about `height` above the ground, hovering and at rest within a few millimetres a second.
Quadrotor hovering(const VehicleModel& model, double ground) {
  Quadrotor quadrotor(model, {1, 2, ground}, 0.5);
  run(quadrotor, 1, all(1.2 * hover_fraction(model)));
  return quadrotor;
}

TEST(SimQuadrotor, StandsStillOnItsGroundUntilThrustExceedsWeight) {
  Quadrotor quadrotor({}, {1, 2, -0.7}, 0.5);
  run(quadrotor, 2, all(0.98 * hover_fraction({})), {5, 0, 0});
  EXPECT_TRUE(quadrotor.on_ground());
  EXPECT_EQ(quadrotor.state().position, Vector3(1, 2, -0.7));
  run(quadrotor, 1, all(1.1 * hover_fraction({})));
  EXPECT_FALSE(quadrotor.on_ground());
  EXPECT_GT(quadrotor.state().position.z(), -0.5);
  EXPECT_NEAR(yaw_of(quadrotor.state().attitude), 0.5, 1e-9);
}

TEST(SimQuadrotor, AMotorReaches63PercentOfAStepAfterItsLag) {
  Quadrotor quadrotor({}, kCalm, 0);
  run(quadrotor, 0.05, all(0.4));
  EXPECT_NEAR(quadrotor.state().thrust[0], 2 * (1 - std::exp(-1.0)), 1e-6);
}

TEST(SimQuadrotor, FallsWithTheWorkedTerminalSpeedAndReportsTheImpact) {
  VehicleModel model;
  model.drag = 5;
  Quadrotor quadrotor = hovering(model, 0);
  run(quadrotor, 3, all(hover_fraction(model) * 1.3));
  run(quadrotor, 1, all(0));
  EXPECT_NEAR(quadrotor.state().velocity.z(), -model.mass * kGravity / model.drag, 0.06);
  run(quadrotor, 10, all(0));
  EXPECT_TRUE(quadrotor.on_ground());
  EXPECT_NEAR(quadrotor.impact_speed(), model.mass * kGravity / model.drag, 0.05);
  EXPECT_EQ(quadrotor.state().velocity, kCalm);
}

TEST(SimQuadrotor, WindCarriesItAwayWithDragOverMass) {
  Quadrotor quadrotor = hovering({}, 0);
  run(quadrotor, 0.5, all(hover_fraction({})), {4, 0, 0});
  EXPECT_NEAR(quadrotor.state().velocity.x(), 4 * (1 - std::exp(-0.25 * 0.5)), 1e-6);
  EXPECT_NEAR(quadrotor.state().velocity.y(), 0, 1e-12);
}

TEST(SimQuadrotor, TheMixerGivesTheThrustAndTorqueThatItIsAskedFor) {
  const VehicleModel model;
  for (const Vector3& torque : {Vector3{0.1, 0, 0}, Vector3{0, -0.15, 0}, Vector3{0, 0, 0.02}}) {
    Quadrotor quadrotor = hovering(model, 0);
    const Vector3 before = quadrotor.state().rate;
    const MotorCommands commands = mix(model, 8, torque);
    double sum = 0;
    for (const double command : commands) sum += command * model.thrust_max / 4;
    EXPECT_NEAR(sum, 8, 1e-12);
    // Past the lag the rate grows by torque over inertia, but for the angular drag; small torques keep that small.
    run(quadrotor, 0.3, mix(model, 8, 0.01 * torque));
    const Vector3 rate = quadrotor.state().rate;
    run(quadrotor, 0.01, mix(model, 8, 0.01 * torque));
    const Vector3 gain = (quadrotor.state().rate - rate) / 0.01;
    const Vector3 expected = (0.01 * torque - model.angular_drag * rate).cwiseQuotient(model.inertia);
    EXPECT_NEAR((gain - expected).norm(), 0, 0.05 * expected.norm());
    EXPECT_EQ(before, kCalm);
  }
}

TEST(SimQuadrotor, TheMixerKeepsEveryMotorInRangeAndGivesUpYawFirst) {
  VehicleModel model;
  model.thrust_min = 1;
  for (const double thrust : {-5.0, 0.0, 3.0, 10.0, 19.0, 50.0}) {
    for (const double torque : {-9.0, -0.5, 0.0, 0.5, 9.0}) {
      for (const double command : mix(model, thrust, {torque, -torque / 2, torque})) {
        EXPECT_GE(command, 0.05 - 1e-12);
        EXPECT_LE(command, 1);
      }
    }
  }
  const MotorCommands commands = mix({}, 10, {0.2, 0, 5});  // far more yaw than there is
  const double roll = 5 * 0.2 * (commands[1] + commands[2] - commands[0] - commands[3]);
  EXPECT_NEAR(roll, 0.2, 1e-9);
}

TEST(SimQuadrotor, ASpinningBodyKeepsItsMomentumWithoutDrag) {
  VehicleModel model;
  model.angular_drag = 0;
  model.inertia = {0.01, 0.02, 0.03};
  Quadrotor quadrotor = hovering(model, 0);
  run(quadrotor, 0.2, mix(model, 9, {0.05, 0.08, 0.01}));
  run(quadrotor, 1, all(hover_fraction(model)));  // motors even out
  const auto momentum = [&] {
    const RigidState& s = quadrotor.state();
    return Vector3(s.attitude * model.inertia.cwiseProduct(s.rate));
  };
  const Vector3 before = momentum();
  ASSERT_GT(before.norm(), 0.005);
  run(quadrotor, 0.3, all(hover_fraction(model)));
  EXPECT_NEAR((momentum() - before).norm(), 0, 1e-6 * before.norm() + 1e-9);
}

TEST(SimWind, GustsAreSeededReachTheirSpeedAndNeverExceedIt) {
  const WindSettings settings{{2, 0, 0}, 3, 1};
  Wind wind(settings, 7);
  Wind same(settings, 7);
  Wind other(settings, 8);
  double fastest = 0;
  double mean = 0;
  bool differs = false;
  constexpr int kSteps = 200'000;
  for (int i = 0; i < kSteps; ++i) {
    for (Wind* each : {&wind, &same, &other}) each->step(0.004);
    ASSERT_EQ(wind.velocity(), same.velocity());
    differs = differs || wind.velocity() != other.velocity();
    fastest = std::max(fastest, (wind.velocity() - settings.mean).norm());
    mean += wind.velocity().x() / kSteps;
  }
  EXPECT_TRUE(differs);
  EXPECT_LE(fastest, 3 + 1e-12);
  EXPECT_GT(fastest, 2.9);
  EXPECT_NEAR(mean, 2, 0.2);
}

TEST(SimWind, WithoutGustsItIsSteady) {
  Wind wind({{1, 2, 3}, 0, 1}, 1);
  for (int i = 0; i < 100; ++i) wind.step(0.01);
  EXPECT_EQ(wind.velocity(), Vector3(1, 2, 3));
}

TEST(SimClearance, IsTheLeastDistanceToAnyBoxAsLookingAtEveryBoxSays) {
  Noise noise(3);
  std::vector<Box> boxes;
  for (int i = 0; i < 400; ++i) {
    const Vector3 lo = 4 * noise.vector();
    boxes.push_back({lo, lo + Vector3::Constant(0.1)});
  }
  ClearanceMeter meter(boxes);
  double least = 1e9;
  Vector3 point = Vector3::Zero();
  for (int i = 0; i < 2000; ++i) {
    point += 0.02 * noise.vector();
    if (i == 1000) point = {3, -3, 1};  // a jump
    meter.visit(point);
    for (const Box& box : boxes) {
      Vector3 gap;
      for (int axis = 0; axis < 3; ++axis) {
        gap[axis] = std::max({box.lo[axis] - point[axis], point[axis] - box.hi[axis], 0.0});
      }
      least = std::min(least, gap.norm());
    }
    ASSERT_DOUBLE_EQ(meter.least(), least) << i;
  }
}

TEST(SimClearance, IsInfiniteWithoutBoxesAndZeroInside) {
  ClearanceMeter none({});
  none.visit({1, 2, 3});
  EXPECT_TRUE(std::isinf(none.least()));
  ClearanceMeter inside({{{0, 0, 0}, {1, 1, 1}}});
  inside.visit({0.5, 0.5, 0.5});
  EXPECT_EQ(inside.least(), 0);
}

TEST(SimClearance, OccupiedLeavesBecomeBoxesOfTheirEdge) {
  VoxelMap map;
  map.resolution = 0.5;
  map.origin = {-1, -2, 0};
  map.leaves = {{{1, 0, 0}, 1, true}, {{0, 0, 0}, 0, false}};
  const std::vector<Box> boxes = occupied_boxes(map);
  ASSERT_EQ(boxes.size(), 1U);
  EXPECT_EQ(boxes[0].lo, Vector3(-0.5, -2, 0));
  EXPECT_EQ(boxes[0].hi, Vector3(0.5, -1, 1));
}

TEST(SimClearance, AMapBlobHasTheObstaclesOfItsSource) {
  std::mt19937 random(5);
  for (int i = 0; i < 20; ++i) {
    const VoxelMap map = test::voxel_map(test::random_world(random));
    test::MapBuildOptions options;
    options.radius = 0;
    const Expected<BuiltMap> built = build_map(map, "source", options, [](std::string_view, double) {});
    if (!built) continue;  // nothing free
    const Result<BoxGraphView> view = BoxGraphView::open(built->blob);
    ASSERT_TRUE(view.ok());
    const Expected<std::vector<Box>> boxes = occupied_boxes(*view);
    ASSERT_TRUE(boxes.has_value());
    ClearanceMeter of_blob(*boxes);
    ClearanceMeter of_source(occupied_boxes(map));
    Noise noise(1);
    for (int j = 0; j < 50; ++j) {
      const Vector3 point = 2 * noise.vector();
      of_blob.visit(point);
      of_source.visit(point);
      EXPECT_DOUBLE_EQ(of_blob.least(), of_source.least());
    }
  }
}

}  // namespace
}  // namespace swiftlet::tools
