/// The whole chain that flies: plans spliced in motion, brakes, supervisor and controller together, in three rooms.
#include <algorithm>
#include <cmath>

#include "harness/random_corridor.hpp"
#include "swiftlet/storage.hpp"
#include "swiftlet/supervisor.hpp"
#include "swiftlet/tracking_controller.hpp"
#include "swiftlet/trajectory_store.hpp"
#include "swiftlet_test.hpp"
#include "unit/test_blob.hpp"

namespace swiftlet {
namespace {

constexpr bool kIsDouble = sizeof(Real) == 8;
constexpr TimeUs kTick = 20'000;
constexpr TimeUs kLatency = 40'000;
constexpr TimeUs kStart = 3'600 * kSecondUs;
constexpr Real kSpeed = 1;
constexpr Real kAcceleration = 2;
constexpr std::uint64_t kFlights = 1 + test::kPropertyRuns / 100;

PlannerStorage<Capacity{.segments = 16, .search_nodes = 64}> planner_memory;
TrajectorySlots<16> store_memory;

/// Rooms of 4 x 4 x 3 m joined by passages of 1 m. Units of 1 m. Static: too large for a small stack.
test::TestBlob blob{{18, 8, 3},
                    {{{0, 0, 0}, {4, 4, 3}},
                     {{4, 1, 0}, {6, 2, 3}},
                     {{6, 0, 0}, {10, 4, 3}},
                     {{10, 3, 0}, {12, 4, 3}},
                     {{12, 0, 0}, {16, 4, 3}}}};

struct World {
  BoxGraphView graph = blob.view();
  Planner planner{planner_memory.spans()};
  TrajectoryStore store{store_memory.spans()};

  /// A goal in one of the rooms, begun at `now` and done `took` later.
  OfferResult fly_to(const Vector3& goal, TimeUs now, TimeUs took) {
    const Splice splice = store.begin(now, kLatency);
    if (splice.id == 0) return OfferResult::kSuperseded;
    PlanRequest request;
    request.start = splice.state;
    request.goal.position = goal;
    request.v_max = kSpeed;
    request.a_max = kAcceleration;
    const Plan& plan = planner.plan(graph, request);
    PlanOffer offer{plan.segments, plan.certificate, {}};
    offer.limits.a_max = plan.qp_a_max;
    return store.offer(offer, splice, now + took);
  }
};

Vector3 random_goal(test::Random& random) {
  const Real room = static_cast<Real>(random.below(3)) * 6;
  return {room + random.uniform(Real(0.2), Real(3.8)), random.uniform(Real(0.2), Real(3.8)),
          random.uniform(Real(0.2), Real(2.8))};
}

struct Watch {
  Sample last;
  bool started = false;
  Real jump = 0;  // [m/s] of velocity beyond what acceleration explains
  Real speed = 0;
  Real acceleration = 0;
  bool inside = true;

  void see(const World& world, const Sample& sample) {
    if (started) {
      const Vector3 mean = (sample.acceleration + last.acceleration) / 2;
      jump = std::max(jump, (sample.velocity - last.velocity - mean * to_seconds(kTick)).norm());
    }
    started = true;
    last = sample;
    speed = std::max(speed, sample.velocity.cwiseAbs().maxCoeff());
    acceleration = std::max(acceleration, sample.acceleration.cwiseAbs().maxCoeff());
    inside = inside && world.graph.nearest_free(sample.position)->distance < Real(2e-3);
  }
};

// Goals change in flight, plans come in time or late, brakes come at any instant: the reference stays one smooth motion
// within the limits, in free space, and comes to rest.
TEST(Flight, TheReferenceStaysSmoothWithinItsLimitsAndFreeWhateverHappens) {
  World world;
  int accepted_in_motion = 0;
  int brakes = 0;
  for (std::uint64_t seed = 0; seed < kFlights; ++seed) {
    test::Random random(seed);
    Watch watch;
    TimeUs now = kStart;
    world.store.hold(random_goal(random), now);
    for (int i = 0; i < 1500; ++i, now += kTick) {
      const bool moves = !world.store.at_rest(now);
      if (random.below(60) == 0 || (!moves && i < 1000)) {
        const TimeUs took = random.below(4) == 0 ? kLatency + 1 : kLatency / 2;
        const OfferResult result = world.fly_to(random_goal(random), now, took);
        EXPECT_TRUE(took <= kLatency || result != OfferResult::kAccepted);
        accepted_in_motion += moves && result == OfferResult::kAccepted ? 1 : 0;
      }
      if (random.below(200) == 0) {
        brakes += moves ? 1 : 0;
        world.store.brake(now);
      }
      watch.see(world, world.store.sample(now));
    }
    EXPECT_LE(watch.jump, Real(0.02));
    EXPECT_LE(watch.speed, kSpeed + Real(2e-3));
    EXPECT_LE(watch.acceleration, kAcceleration + (kIsDouble ? Real(1e-4) : Real(1e-2)));
    EXPECT_TRUE(watch.inside);
    EXPECT_TRUE(world.store.at_rest(now + 60 * kSecondUs));
    EXPECT_EQ(world.store.sample(now + 60 * kSecondUs).velocity.norm(), 0);
  }
  EXPECT_GT(accepted_in_motion, 5);
  EXPECT_GT(brakes, 5);
}

/// A vehicle that follows attitude and thrust with a lag; what it reports is one tick old.
struct Vehicle {
  Vector3 position;
  Vector3 velocity = Vector3::Zero();
  Vector3 thrust_axis = Vector3::UnitZ();
  VehicleState reported;

  void advance(const TrackingCommand& command, TimeUs now) {
    Singularity none{};
    reported = {now, position, velocity, to_quaternion(attitude_from(thrust_axis, 0, Matrix3::Identity(), none)),
                Vector3::Zero()};
    const Real h = to_seconds(kTick) / 10;
    for (int i = 0; i < 10; ++i) {
      const Vector3 wanted = command.attitude.toRotationMatrix().col(2);
      thrust_axis = (thrust_axis + (wanted - thrust_axis) * (h / Real(0.1))).normalized();
      const Vector3 acceleration = thrust_axis * command.thrust - Vector3{0, 0, kGravity} - Real(0.25) * velocity;
      position += velocity * h + acceleration * (h * h / 2);
      velocity += acceleration * h;
    }
  }
};

/// Companion and vehicle in closed loop, as a board would run them.
struct Loop {
  World world;
  Supervisor supervisor{{}};
  TrackingController controller{{}};
  StatePredictor predictor{{}};
  Vehicle vehicle;
  SupervisorInputs inputs;
  Decision decision;
  TimeUs now = kStart;
  bool odometry_stopped = false;
  Real most_off = 0;

  explicit Loop(const Vector3& start) {
    vehicle.position = start;
    vehicle.reported = {now, start};
    world.store.hold(start, now);
    inputs.engage = inputs.airborne = true;
  }

  void step() {
    now += kTick;
    inputs.now = now;
    inputs.last_message = now;
    if (!odometry_stopped) inputs.odometry = vehicle.reported;
    inputs.has_odometry = true;
    inputs.reference_position = world.store.sample(inputs.odometry.time).position;
    inputs.reference_at_rest = world.store.at_rest(now);
    decision = supervisor.step(inputs);
    if (decision.hold_here) world.store.hold(inputs.odometry.position, now);
    if (decision.brake) world.store.brake(now);
    if (decision.setpoints != Setpoints::kNone) inputs.last_setpoint = now;
    inputs.armed = inputs.in_our_mode = inputs.armed || decision.may_ask_for_control;
    const Sample reference = world.store.sample(now);
    predictor.learn(inputs.odometry);
    const VehicleState state = predictor.predict(inputs.odometry, now);
    const TrackingCommand command = controller.step({reference, 0, 0}, state, predictor.disturbance());
    predictor.record(now, command.commanded_acceleration, command.thrust);
    vehicle.advance(command, now);
    most_off = std::max(most_off, (vehicle.position - world.store.sample(now + kTick).position).norm());
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) step();
  }
};

TEST(Flight, FliesThreeGoalsInARowAndArrives) {
  Loop loop({1, 1, 1});
  loop.run(10);
  for (const Vector3& goal : {Vector3{9, 1, 2}, Vector3{15, 1, 1}, Vector3{2, 3, 1}}) {
    EXPECT_TRUE(loop.world.fly_to(goal, loop.now, 1'000) == OfferResult::kAccepted);
    loop.run(1500);
    EXPECT_TRUE(loop.decision.state == FlightState::kHolding);
    EXPECT_TRUE(loop.decision.reason == Reason::kArrived);
    EXPECT_LE((loop.vehicle.position - goal).norm(), Real(0.02));
  }
  EXPECT_LE(loop.most_off, Real(0.06));
}

TEST(Flight, StopsInTheCorridorWhenTheOdometryStops) {
  Loop loop({1, 1, 1});
  loop.run(10);
  EXPECT_TRUE(loop.world.fly_to({9, 1, 2}, loop.now, 1'000) == OfferResult::kAccepted);
  loop.run(150);
  EXPECT_TRUE(loop.decision.state == FlightState::kFlying);
  loop.odometry_stopped = true;
  loop.run(12);
  EXPECT_TRUE(loop.decision.state == FlightState::kBraking);
  loop.run(200);
  EXPECT_TRUE(loop.decision.state == FlightState::kHolding);
  const Vector3 stop = loop.world.store.sample(loop.now).position;
  EXPECT_LT(stop.x(), Real(8));
  EXPECT_LE(loop.world.graph.nearest_free(stop)->distance, Real(1e-3));
}

}  // namespace
}  // namespace swiftlet
