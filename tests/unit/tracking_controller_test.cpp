#include "swiftlet/tracking_controller.hpp"

#include <bit>
#include <cmath>
#include <limits>

#include "harness/random_corridor.hpp"
#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr bool kIsDouble = sizeof(Real) == 8;
constexpr Real kTolerance = kIsDouble ? Real(1e-9) : Real(1e-4);
constexpr Real kNan = std::numeric_limits<Real>::quiet_NaN();
constexpr Real kStep = Real(0.02);
const Vector3 kNone = Vector3::Zero();
using test::Random;

Reference hover_at(const Vector3& position, Real yaw = 0) {
  Reference reference;
  reference.sample = {position, Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
  reference.yaw = yaw;
  return reference;
}

bool all_finite(const TrackingCommand& c) {
  return c.position.allFinite() && c.velocity.allFinite() && c.acceleration.allFinite() && std::isfinite(c.yaw) &&
         std::isfinite(c.yaw_rate) && c.attitude.coeffs().allFinite() && c.body_rates.allFinite() &&
         std::isfinite(c.thrust) && std::isfinite(c.force) && c.moment.allFinite() &&
         c.commanded_acceleration.allFinite();
}

Real tilt_of(const Quaternion& q) { return std::acos(std::min(Real(1), q.toRotationMatrix()(2, 2))); }

TEST(TrackingController, HoversWhereItShould) {
  TrackingController controller({});
  const TrackingCommand command = controller.step(hover_at({1, 2, 3}, Real(0.5)), {0, {1, 2, 3}}, kNone);
  EXPECT_TRUE(command.basis == CommandBasis::kFeedback);
  EXPECT_NEAR(command.thrust, 9.80665, kTolerance);
  EXPECT_NEAR(heading_of(command.attitude.toRotationMatrix()), 0.5, kTolerance);
  EXPECT_NEAR(tilt_of(command.attitude), 0, 1e-3);
  EXPECT_NEAR(command.position[2], 3, kTolerance);
}

// Eq. 4 by hand: m = 2, 0.1 m too far east, 0.2 m/s too fast north, accelerating up by 1, level, turning about x.
TEST(TrackingController, GivesTheThrustAndMomentOfEquation4) {
  ControllerSettings settings;
  settings.mass = 2;
  TrackingController controller(settings);
  Reference reference = hover_at({0, 0, 5});
  reference.sample.acceleration = {0, 0, 1};
  VehicleState state;
  state.position = {Real(0.1), 0, 5};
  state.velocity = {0, Real(0.2), 0};
  state.body_rates = {Real(0.1), 0, 0};
  const TrackingCommand command = controller.step(reference, state, kNone);
  const Vector3 force{-Real(0.1) * 12, -Real(0.2) * 5, 1 + kGravity};  // specific
  EXPECT_NEAR(command.force, 2 * (1 + 9.80665), 10 * kTolerance);      // z_B = z_W
  EXPECT_LE((command.commanded_acceleration + Vector3{0, 0, kGravity} - force).norm(), kTolerance);
  // e_R of R = 1 against R_d: to first order minus the rotation vector to R_d, whose tilt is (z_W x f) / |f|.
  const Matrix3 R_WD = command.attitude.toRotationMatrix();
  const Vector3 e_R = Vector3{R_WD(1, 2) - R_WD(2, 1), R_WD(2, 0) - R_WD(0, 2), R_WD(0, 1) - R_WD(1, 0)} / 2;
  EXPECT_NEAR(e_R.x(), -1.0 / force.norm(), 1e-3);
  EXPECT_NEAR(e_R.y(), 1.2 / force.norm(), 1e-3);
  EXPECT_NEAR(command.moment.x(), -0.8 * e_R.x() - 0.12 * 0.1, kTolerance);
  EXPECT_NEAR(command.moment.y(), -0.8 * e_R.y(), kTolerance);
  EXPECT_NEAR(command.body_rates.x(), -7 * e_R.x(), 1e-3);
}

TEST(TrackingController, BoundsTiltThrustAndRatesWhateverTheError) {
  const ControllerSettings settings;
  Random random(1);
  for (int i = 0; i < 500; ++i) {
    TrackingController controller(settings);
    const Real size = i % 2 == 0 ? 1 : 1000;
    VehicleState state;
    state.position = {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
    state.velocity = {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
    state.attitude = Quaternion(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1), 1).normalized();
    const TrackingCommand command = controller.step(hover_at(Vector3::Zero()), state, kNone);
    EXPECT_LE(tilt_of(command.attitude), settings.tilt_max + Real(1e-3));
    EXPECT_GE(command.thrust, settings.thrust_min);
    EXPECT_LE(command.thrust, settings.thrust_max);
    EXPECT_TRUE((command.body_rates.array().abs() <= settings.rate_max.array() + kTolerance).all());
    EXPECT_LE((command.commanded_acceleration + Vector3{0, 0, kGravity}).norm(), settings.thrust_max + Real(1e-3));
  }
}

TEST(TrackingController, AnUnusableStateIsFlownOpenLoopOnTheReference) {
  TrackingController controller({});
  Reference reference = hover_at({1, 2, 3});
  reference.sample.acceleration = {1, 0, 0};
  for (int field = 0; field < 4; ++field) {
    VehicleState state;
    if (field == 0) state.position[1] = kNan;
    if (field == 1) state.velocity[2] = std::numeric_limits<Real>::infinity();
    if (field == 2) state.attitude = Quaternion(0, 0, 0, 0);
    if (field == 3) state.body_rates[0] = kNan;
    const TrackingCommand command = controller.step(reference, state, kNone);
    EXPECT_TRUE(command.basis == CommandBasis::kReference);
    EXPECT_TRUE(all_finite(command));
    EXPECT_NEAR(command.position[0], 1, kTolerance);
    EXPECT_NEAR(tilt_of(command.attitude), std::atan(1 / 9.80665), 1e-3);
  }
}

TEST(TrackingController, AnUnusableReferenceGivesLevelHoverAtTheLastHeading) {
  TrackingController controller({});
  static_cast<void>(controller.step(hover_at(Vector3::Zero(), 2), {}, kNone));
  for (int field = 0; field < 5; ++field) {
    Reference reference = hover_at(Vector3::Zero());
    if (field == 0) reference.sample.position[0] = kNan;
    if (field == 1) reference.sample.velocity[0] = kNan;
    if (field == 2) reference.sample.jerk[0] = std::numeric_limits<Real>::max();
    if (field == 3) reference.yaw = kNan;
    if (field == 4) reference.yaw_rate = -std::numeric_limits<Real>::infinity();
    const TrackingCommand command = controller.step(reference, {}, kNone);
    EXPECT_TRUE(command.basis == CommandBasis::kLevel);
    EXPECT_TRUE(all_finite(command));
    EXPECT_NEAR(tilt_of(command.attitude), 0, 1e-3);
    EXPECT_NEAR(command.yaw, 2, 100 * kTolerance);
    EXPECT_NEAR(command.thrust, 9.80665, kTolerance);
    EXPECT_EQ(command.body_rates.norm(), 0);
  }
}

// Any bits at all, in any field.
TEST(TrackingController, NothingThatIsNotFiniteLeaves) {
  Random random(7);
  TrackingController controller({});
  for (int i = 0; i < 3000; ++i) {
    std::array<Real, 29> values;
    for (Real& value : values) {
      value = random.uniform(-10, 10);
      if (random.below(20) != 0) continue;
      if constexpr (kIsDouble) {
        value = static_cast<Real>(std::bit_cast<double>(random.next()));
      } else {
        value = static_cast<Real>(std::bit_cast<float>(static_cast<std::uint32_t>(random.next())));
      }
    }
    const auto vector = [&](std::size_t first) { return Vector3{values[first], values[first + 1], values[first + 2]}; };
    const Reference reference{{vector(0), vector(3), vector(6), vector(9)}, values[12], values[13]};
    VehicleState state{0, vector(14), vector(17), Quaternion(values[20], values[21], values[22], values[23]),
                       vector(24)};
    if (i % 2 == 0) state.attitude.normalize();
    const TrackingCommand command = controller.step(reference, state, {values[26], values[27], values[28]});
    EXPECT_TRUE(all_finite(command));
    EXPECT_NEAR(command.attitude.norm(), 1, 1e-4);
  }
}

TEST(TrackingController, TakesTheDisturbanceOffAndIgnoresOneThatIsNone) {
  TrackingController controller({});
  const Vector3 wind{1, Real(-0.5), Real(0.2)};
  const TrackingCommand command = controller.step(hover_at(Vector3::Zero()), {}, wind);
  EXPECT_LE((command.commanded_acceleration + wind).norm(), kTolerance);
  EXPECT_EQ(command.acceleration.norm(), 0);  // the autopilot's own loop has an integral
  const TrackingCommand without = controller.step(hover_at(Vector3::Zero()), {}, {kNan, 0, 0});
  EXPECT_LE(without.commanded_acceleration.norm(), kTolerance);
}

TEST(TrackingController, ThePositionFormsAccelerationCarriesBoundedFeedback) {
  const ControllerSettings settings;
  TrackingController controller(settings);
  VehicleState state;
  state.position = {Real(0.1), 0, 5};
  state.velocity = {0, Real(0.2), 0};
  const TrackingCommand command = controller.step(hover_at(Vector3::Zero()), state, kNone);
  EXPECT_LE((command.acceleration - Vector3{Real(-0.3), Real(-0.2), -settings.form_feedback_max}).norm(), kTolerance);
  state.position[0] = kNan;
  EXPECT_EQ(controller.step(hover_at(Vector3::Zero()), state, kNone).acceleration.norm(), 0);
}

/// A point mass that follows the commanded attitude with a lag, with drag, a disturbance and delays both ways.
struct Plant {
  Real attitude_lag = Real(0.12);
  Real drag = Real(0.25);
  Vector3 disturbance = Vector3::Zero();
  std::size_t delay = 0;  // control steps: commands act and measurements are this old
  Vector3 position = Vector3::Zero();
  Vector3 velocity = Vector3::Zero();
  Vector3 thrust_axis = Vector3::UnitZ();
  std::array<TrackingCommand, 8> commands{};
  std::array<VehicleState, 8> states{};
  std::size_t steps = 0;

  static TimeUs time_of(std::size_t step) { return static_cast<TimeUs>(step) * 20'000; }

  void advance(const TrackingCommand& command) {
    commands[steps % 8] = command;
    const TrackingCommand& acting = commands[(steps + 8 - delay) % 8];
    ++steps;
    constexpr int kPieces = 10;
    const Real h = kStep / kPieces;
    for (int i = 0; i < kPieces; ++i) {
      const Vector3 wanted = acting.attitude.toRotationMatrix().col(2);
      thrust_axis = (thrust_axis + (wanted - thrust_axis) * (h / attitude_lag)).normalized();
      const Vector3 acceleration =
          thrust_axis * acting.thrust - Vector3{0, 0, kGravity} - drag * velocity + disturbance;
      position += velocity * h + acceleration * (h * h / 2);
      velocity += acceleration * h;
    }
    Singularity none{};
    states[steps % 8] = {time_of(steps), position, velocity,
                         to_quaternion(attitude_from(thrust_axis, 0, Matrix3::Identity(), none)), Vector3::Zero()};
  }
  [[nodiscard]] const VehicleState& measured() const { return states[(steps + 8 - delay) % 8]; }
};

/// Circle of 3 m diameter at 1 m/s, entered from rest over two seconds.
Reference circle(Real t) {
  const Real w = t < 2 ? t / 2 : Real(1);
  const Real angle = t < 2 ? t * t / 4 / Real(1.5) : (t - 1) / Real(1.5);
  const Real speed = w;
  const Real grow = t < 2 ? Real(0.5) : Real(0);
  const Vector3 radial{std::cos(angle), std::sin(angle), 0};
  const Vector3 along{-std::sin(angle), std::cos(angle), 0};
  Reference reference;
  reference.sample.position = Real(1.5) * radial - Vector3{Real(1.5), 0, 0};
  reference.sample.velocity = speed * along;
  reference.sample.acceleration = grow * along - speed * speed / Real(1.5) * radial;
  reference.sample.jerk = -speed * speed * speed / Real(2.25) * along;
  return reference;
}

struct Error {
  Real rms = 0;
  Real most = 0;
};

Error fly_circle(Plant plant, const ControllerSettings& settings, bool compensate) {
  TrackingController controller(settings);
  PredictorSettings answer;
  answer.response_time = Real(0.12);
  answer.thrust_time = 0;
  StatePredictor predictor(answer);
  Error error;
  constexpr int kSteps = 1000;
  for (int i = 0; i < kSteps; ++i) {
    const TimeUs now = Plant::time_of(plant.steps);
    // The command acts after the delay: reference and state are those of that instant.
    const TimeUs acts = compensate ? now + Plant::time_of(plant.delay) : now;
    predictor.learn(plant.measured());
    const VehicleState state = compensate ? predictor.predict(plant.measured(), acts) : plant.measured();
    const TrackingCommand command = controller.step(circle(to_seconds(acts)), state, predictor.disturbance());
    predictor.record(acts, command.commanded_acceleration, command.thrust);
    plant.advance(command);
    const Real distance = (plant.position - circle(to_seconds(Plant::time_of(plant.steps))).sample.position).norm();
    error.rms += distance * distance / kSteps;
    error.most = std::max(error.most, distance);
  }
  error.rms = std::sqrt(error.rms);
  return error;
}

TEST(TrackingController, FollowsACircleDespiteLagAndDrag) {
  const Error error = fly_circle({}, {}, true);
  EXPECT_LE(error.rms, Real(0.06));
  EXPECT_LE(error.most, Real(0.15));
}

TEST(TrackingController, FollowsACircleInSteadyWindThroughDelays) {
  Plant plant;
  plant.delay = 2;  // 40 ms each way
  plant.disturbance = {Real(0.8), 0, Real(-0.4)};
  const Error with = fly_circle(plant, {}, true);
  const Error without = fly_circle(plant, {}, false);
  EXPECT_LE(with.rms, Real(0.06));
  EXPECT_LE(with.most, Real(0.2));  // while the wind is learnt, which sets in at once
  EXPECT_LT(with.rms, without.rms);
}

}  // namespace
}  // namespace swiftlet
