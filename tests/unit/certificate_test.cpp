#include "swiftlet/certificate.hpp"

#include "harness/random_corridor.hpp"
#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr bool kIsDouble = sizeof(Real) == 8;
constexpr Real kInfinity = std::numeric_limits<Real>::infinity();
using test::RandomCorridor;

/// A trajectory that stops at every gate of a random corridor, and what it was asked to respect.
struct Flight {
  RandomCorridor corridor;
  std::array<Segment, RandomCorridor::kMost> storage;
  CertificateRequest request;

  explicit Flight(std::uint64_t seed) : corridor(seed, 4, true) {
    const TrajectoryProblem problem = corridor.problem();
    stop_at_gates(std::span(corridor.points).first(5), problem.v_max, problem.a_max, storage);
    request = {problem.boxes, problem.gates, problem.start, problem.goal,
               problem.v_max, problem.a_max, kInfinity,     kInfinity};
  }
  [[nodiscard]] std::span<Segment> segments() { return std::span(storage).first(4); }
  [[nodiscard]] Certificate certificate() { return certify(segments(), request); }
};

TEST(Certificate, BoundsAreAboveEverySampleAndCloseToTheLargest) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    Flight flight(seed);
    test::Random random(seed);
    // Any polynomial will do here, also one that leaves its box.
    for (Segment& segment : flight.segments()) {
      for (auto& axis : segment.coefficients) {
        for (Real& c : axis) c += random.uniform(Real(-0.5), Real(0.5));
      }
    }
    const Certificate certificate = flight.certificate();
    Vector3 speed = Vector3::Zero();
    Vector3 acceleration = Vector3::Zero();
    Real speed_norm = 0;
    Real acceleration_norm = 0;
    Real margin = kInfinity;
    for (std::size_t i = 0; i < 4; ++i) {
      for (int k = 0; k <= 1000; ++k) {
        const Sample s = sample_segment(flight.storage[i], flight.storage[i].duration * static_cast<Real>(k) / 1000);
        speed = speed.cwiseMax(s.velocity.cwiseAbs());
        acceleration = acceleration.cwiseMax(s.acceleration.cwiseAbs());
        speed_norm = std::max(speed_norm, s.velocity.norm());
        acceleration_norm = std::max(acceleration_norm, s.acceleration.norm());
        margin = std::min({margin, (s.position - flight.corridor.boxes[i].lo).minCoeff(),
                           (flight.corridor.boxes[i].hi - s.position).minCoeff()});
      }
    }
    const Real rounding = kIsDouble ? Real(1e-12) : Real(1e-3);
    const Real slack = kIsDouble ? Real(1e-4) : Real(1e-2);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      EXPECT_GE(certificate.max_speed[axis], speed[axis] - rounding * speed[axis]);
      EXPECT_LE(certificate.max_speed[axis], speed[axis] + slack * speed[axis]);
      EXPECT_GE(certificate.max_acceleration[axis], acceleration[axis] - rounding * acceleration[axis]);
      EXPECT_LE(certificate.max_acceleration[axis], acceleration[axis] + slack * acceleration[axis]);
    }
    EXPECT_GE(certificate.max_speed_norm, speed_norm * (1 - rounding));
    EXPECT_LE(certificate.max_speed_norm, speed_norm * (1 + slack));
    EXPECT_GE(certificate.max_acceleration_norm, acceleration_norm * (1 - rounding));
    EXPECT_LE(certificate.max_acceleration_norm, acceleration_norm * (1 + slack));
    EXPECT_LE(certificate.box_margin, margin + rounding);
    EXPECT_GE(certificate.box_margin, margin - slack * (1 + std::fabs(margin)));
  }
}

TEST(Certificate, PassesATrajectoryThatKeepsEverything) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) EXPECT_TRUE(Flight(seed).certificate().pass);
}

TEST(Certificate, FailsOnASpeedJustOverTheLimit) {
  Flight flight(1);
  flight.request.v_max = flight.certificate().max_speed * Real(0.99);
  EXPECT_FALSE(flight.certificate().pass);
}

TEST(Certificate, FailsOnAnAccelerationJustOverTheLimit) {
  Flight flight(1);
  flight.request.a_max = flight.certificate().max_acceleration * Real(0.99);
  EXPECT_FALSE(flight.certificate().pass);
}

TEST(Certificate, FailsOnEuclideanLimits) {
  Flight flight(1);
  flight.request.speed_max = flight.certificate().max_speed_norm * Real(0.99);
  EXPECT_FALSE(flight.certificate().pass);
  flight.request.speed_max = kInfinity;
  flight.request.acceleration_norm_max = flight.certificate().max_acceleration_norm * Real(0.99);
  EXPECT_FALSE(flight.certificate().pass);
}

TEST(Certificate, FailsOutsideABoxByMoreThanTheTolerance) {
  Flight flight(1);
  const Real tolerance = flight.certificate().tolerance;
  const Real far = flight.corridor.points[2][0];  // a junction: the path is there
  flight.corridor.boxes[1].lo[0] = far + 3 * tolerance;
  flight.corridor.boxes[1].hi[0] = far + 10;
  EXPECT_FALSE(flight.certificate().pass);
  EXPECT_LT(flight.certificate().box_margin, Real(0));
}

TEST(Certificate, FailsOnAJunctionOutsideItsGate) {
  Flight flight(1);
  flight.corridor.gates[1].lo[0] = flight.corridor.points[2][0] + Real(0.1);
  EXPECT_FALSE(flight.certificate().pass);
}

TEST(Certificate, FailsOnAJumpInPositionVelocityOrAcceleration) {
  for (const std::size_t term : {0, 1, 2}) {
    Flight flight(1);
    flight.storage[2].coefficients[1][term] += Real(0.02);
    EXPECT_FALSE(flight.certificate().pass);
    EXPECT_GT(flight.certificate().max_jump[term], Real(0.019));
  }
}

TEST(Certificate, FailsOnAnEndThatIsNotTheRequestedOne) {
  Flight at_start(1);
  at_start.request.start.position[2] += Real(0.01);
  EXPECT_FALSE(at_start.certificate().pass);
  Flight at_goal(1);
  at_goal.request.goal.velocity[0] = Real(0.1);
  EXPECT_FALSE(at_goal.certificate().pass);
}

TEST(Certificate, NeverPassesNumbersThatAreNone) {
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  for (std::size_t term = 0; term < kQuinticTerms; ++term) {
    for (const Real value : {nan, kInfinity, -kInfinity}) {
      Flight flight(1);
      flight.storage[1].coefficients[2][term] = value;
      EXPECT_FALSE(flight.certificate().pass);
    }
  }
  for (const Real value : {nan, kInfinity, Real(0), Real(-1)}) {
    Flight flight(1);
    flight.storage[1].duration = value;
    EXPECT_FALSE(flight.certificate().pass);
  }
}

TEST(Certificate, NeverPassesCountsThatDoNotMatch) {
  Flight flight(1);
  EXPECT_FALSE(certify({}, flight.request).pass);
  EXPECT_FALSE(certify(flight.segments().first(3), flight.request).pass);
  flight.request.gates = flight.request.gates.first(2);
  EXPECT_FALSE(flight.certificate().pass);
}

TEST(Certificate, JerkThrustAndRateBoundsAreAboveEverySampleAndClose) {
  constexpr Vehicle kVehicle{.mass = 2, .thrust_min = 1, .thrust_max = 60, .rate_max = 20};
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    Flight flight(seed);
    flight.request.vehicle = kVehicle;
    const Certificate certificate = flight.certificate();
    Vector3 jerk = Vector3::Zero();
    Real jerk_norm = 0;
    Real most = 0;
    Real least = kInfinity;
    Real rate = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      for (int k = 0; k <= 1000; ++k) {
        const Sample s = sample_segment(flight.storage[i], flight.storage[i].duration * static_cast<Real>(k) / 1000);
        const Real thrust = kVehicle.mass * (s.acceleration + Vector3{0, 0, kGravity}).norm();
        jerk = jerk.cwiseMax(s.jerk.cwiseAbs());
        jerk_norm = std::max(jerk_norm, s.jerk.norm());
        most = std::max(most, thrust);
        least = std::min(least, thrust);
        rate = std::max(rate, s.jerk.norm() * kVehicle.mass / thrust);
      }
    }
    const Real rounding = kIsDouble ? Real(1e-12) : Real(1e-4);
    const Real slack = kIsDouble ? Real(1e-4) : Real(1e-2);
    EXPECT_GE(certificate.max_jerk_norm, jerk_norm * (1 - rounding));
    EXPECT_LE(certificate.max_jerk_norm, jerk_norm * (1 + slack));
    for (Eigen::Index axis = 0; axis < 3; ++axis) EXPECT_GE(certificate.max_jerk[axis], jerk[axis] * (1 - rounding));
    EXPECT_GE(certificate.max_thrust, most * (1 - rounding));
    EXPECT_LE(certificate.max_thrust, most * (1 + slack));
    EXPECT_LE(certificate.min_thrust, least * (1 + rounding));
    EXPECT_GE(certificate.min_thrust, least * (1 - slack));
    EXPECT_GE(certificate.max_rate, rate * (1 - rounding));
  }
}

TEST(Certificate, EachNewBoundCanFailIt) {
  const auto passes = [](auto&& tighten) {
    Flight flight(3);
    tighten(flight.request);
    return flight.certificate().pass;
  };
  const Vehicle strong{.mass = 2, .thrust_min = 1, .thrust_max = 60, .rate_max = 20};
  EXPECT_TRUE(passes([&](CertificateRequest& request) { request.vehicle = strong; }));
  EXPECT_FALSE(passes([](CertificateRequest& request) { request.j_max = Vector3::Constant(Real(0.1)); }));
  EXPECT_FALSE(passes([](CertificateRequest& request) { request.jerk_norm_max = Real(0.1); }));
  EXPECT_FALSE(passes([&](CertificateRequest& request) {
    request.vehicle = strong;
    request.vehicle->thrust_min = Real(19.6);
  }));
  EXPECT_FALSE(passes([&](CertificateRequest& request) {
    request.vehicle = strong;
    request.vehicle->thrust_max = Real(19.63);
  }));
  EXPECT_FALSE(passes([&](CertificateRequest& request) {
    request.vehicle = strong;
    request.vehicle->rate_max = Real(0.01);
  }));
}

}  // namespace
}  // namespace swiftlet
