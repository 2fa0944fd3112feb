// The whole trajectory stage on random corridors: there is always an answer, and an independent look agrees with its
// certificate. SWIFTLET_PROPERTY_RUNS corridors; `./go soak` runs 100,000.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "harness/random_flight.hpp"
#include "swiftlet/storage.hpp"
#include "swiftlet/trajectory_planner.hpp"

namespace {

using swiftlet::Box;
using swiftlet::FittedTrajectory;
using swiftlet::Real;
using swiftlet::Segment;
using swiftlet::Status;
using swiftlet::TrajectoryPlanner;
using swiftlet::Vector3;
using swiftlet::test::Random;
using swiftlet::test::RandomFlight;

constexpr bool kIsDouble = sizeof(Real) == 8;
constexpr double kTolerance = kIsDouble ? 2e-6 : 2e-3;

std::uint64_t runs() {
  const char* asked = std::getenv("SWIFTLET_PROPERTY_RUNS");
  return asked != nullptr ? std::strtoull(asked, nullptr, 10) : SWIFTLET_PROPERTY_RUNS;
}

struct Motion {
  std::array<double, 3> p{};
  std::array<double, 3> v{};
  std::array<double, 3> a{};
  std::array<double, 3> j{};
};

/// A segment at time t, in double, by plain powers.
Motion motion_at(const Segment& segment, double t) {
  Motion at;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 6; k-- > 0;) {
      const auto c = static_cast<double>(segment.coefficients[axis][k]);
      const auto n = static_cast<double>(k);
      at.p[axis] = at.p[axis] * t + c;
      if (k > 0) at.v[axis] = at.v[axis] * t + n * c;
      if (k > 1) at.a[axis] = at.a[axis] * t + n * (n - 1) * c;
      if (k > 2) at.j[axis] = at.j[axis] * t + n * (n - 1) * (n - 2) * c;
    }
  }
  return at;
}

/// What a limit bounds: the largest axis or the length.
double magnitude(const std::array<double, 3>& x, swiftlet::LimitNorm norm) {
  if (norm == swiftlet::LimitNorm::kEuclidean) return std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
  return std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])});
}

/// Looks at a trajectory every millisecond: what it finds, or nothing.
std::string look(std::span<const Segment> segments, std::span<const Box> boxes,
                 const swiftlet::TrajectoryRequest& request) {
  const swiftlet::FlightLimits& limits = request.limits;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const double T = segments[i].duration;
    const auto steps = static_cast<std::size_t>(T / 1e-3) + 1;
    for (std::size_t k = 0; k <= steps; ++k) {
      const Motion at = motion_at(segments[i], T * static_cast<double>(k) / static_cast<double>(steps));
      const std::string where = " of segment " + std::to_string(i);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto row = static_cast<Eigen::Index>(axis);
        if (at.p[axis] < boxes[i].lo[row] - kTolerance || at.p[axis] > boxes[i].hi[row] + kTolerance) {
          return "position" + where;
        }
      }
      if (magnitude(at.v, limits.norm) > limits.v_max + kTolerance) return "speed" + where;
      if (magnitude(at.a, limits.norm) > limits.a_max + kTolerance) return "acceleration" + where;
      if (magnitude(at.j, limits.norm) > limits.j_max * (1 + kTolerance) + kTolerance) return "jerk" + where;
      if (!limits.vehicle) continue;
      std::array<double, 3> lift = at.a;
      lift[2] += static_cast<double>(swiftlet::kGravity);
      const double thrust = limits.vehicle->mass * magnitude(lift, swiftlet::LimitNorm::kEuclidean);
      const double slack = kTolerance * limits.vehicle->mass;
      if (thrust < limits.vehicle->thrust_min - slack || thrust > limits.vehicle->thrust_max + slack) {
        return "thrust" + where;
      }
    }
  }
  return {};
}

/// Limits beyond those of each axis: Euclidean, jerk and vehicle in all combinations, by the seed.
void add_limits(swiftlet::FlightLimits& limits, std::uint64_t seed) {
  const std::uint64_t kinds = 1 + seed % 7;
  if ((kinds & 1U) != 0) limits.norm = swiftlet::LimitNorm::kEuclidean;
  if ((kinds & 2U) != 0) limits.j_max = static_cast<Real>(1 + seed % 5) * limits.a_max;
  if ((kinds & 4U) != 0) limits.vehicle = swiftlet::Vehicle{Real(1.5), 3, 25, static_cast<Real>(1 + seed % 3)};
}

struct Counts {
  std::uint64_t flights = 0;
  std::uint64_t optimal = 0;
  std::uint64_t fallback = 0;
  std::uint64_t unanswered = 0;
  std::uint64_t defects = 0;
};

class Flights {
 public:
  const FittedTrajectory& fly(RandomFlight& flight, Counts& counts, const char* kind, std::uint64_t seed) {
    const FittedTrajectory& fitted = planner_.fit(flight.corridor(), flight.count, flight.request);
    ++counts.flights;
    counts.optimal += fitted.status == Status::kOk ? 1 : 0;
    counts.fallback += fitted.status == Status::kFallback ? 1 : 0;
    if (fitted.segments.empty()) {
      ++counts.unanswered;
      std::printf("%s, seed %llu: %s, box %u axis %d misses %g m\n", kind, static_cast<unsigned long long>(seed),
                  describe(fitted.status), fitted.report.blocking.box, fitted.report.blocking.axis,
                  static_cast<double>(fitted.report.blocking.missing));
      return fitted;
    }
    const std::string defect = look(fitted.segments, std::span(flight.boxes).first(fitted.box_count), flight.request);
    if (!fitted.certificate.pass || !defect.empty()) {
      ++counts.defects;
      std::printf("%s, seed %llu: %s\n", kind, static_cast<unsigned long long>(seed), defect.c_str());
    }
    return fitted;
  }

 private:
  std::unique_ptr<swiftlet::TrajectoryPlannerStorage<RandomFlight::kMost>> storage_ =
      std::make_unique<swiftlet::TrajectoryPlannerStorage<RandomFlight::kMost>>();
  TrajectoryPlanner planner_{storage_->spans()};
};

void report(const char* kind, const Counts& counts) {
  std::printf("%s: %llu flights, %llu optimal, %llu fallback, %llu without an answer, %llu defects\n", kind,
              static_cast<unsigned long long>(counts.flights), static_cast<unsigned long long>(counts.optimal),
              static_cast<unsigned long long>(counts.fallback), static_cast<unsigned long long>(counts.unanswered),
              static_cast<unsigned long long>(counts.defects));
}

/// What is left of a flight after a random part of it, from the state that it has there.
void continue_flight(RandomFlight& flight, std::span<const Segment> flown, std::span<const Box> boxes,
                     std::uint64_t seed) {
  Random random(seed);
  const Real t = random.uniform(0, 1) * swiftlet::total_duration(flown);
  flight.start_from(flown, boxes, t);
}

TEST(TrajectoryProperty, EveryRandomCorridorIsFlownFromRestAndFromMotion) {
  Flights flights;
  Counts rest;
  Counts limited;
  Counts roomy;
  Counts sampled;
  for (std::uint64_t seed = 0; seed < runs(); ++seed) {
    RandomFlight flight(seed);
    RandomFlight moving = flight;
    RandomFlight replanned = flight;
    const FittedTrajectory& fitted = flights.fly(flight, rest, "from rest", seed);
    const std::vector<Segment> flown(fitted.segments.begin(), fitted.segments.end());
    RandomFlight bounded = replanned;
    add_limits(bounded.request.limits, seed);
    (void)flights.fly(bounded, limited, "other limits", seed);
    moving.start_with_room(seed);
    (void)flights.fly(moving, roomy, "with room", seed);
    if (flown.empty()) continue;
    continue_flight(replanned, flown, flight.boxes, seed);
    (void)flights.fly(replanned, sampled, "sampled", seed);
  }
  report("from rest", rest);
  report("other limits", limited);
  report("with room", roomy);
  report("sampled", sampled);
  EXPECT_EQ(rest.unanswered + limited.unanswered + roomy.unanswered, 0U);
  // The remainder of a certified trajectory shows that there is an answer.
  EXPECT_LE(sampled.unanswered, kIsDouble ? 0 : sampled.flights / 50 + 1);
  EXPECT_EQ(rest.defects + limited.defects + roomy.defects + sampled.defects, 0U);
  EXPECT_LE(static_cast<double>(rest.fallback), (kIsDouble ? 0.001 : 0.01) * static_cast<double>(rest.flights) + 1);
}

// Of slow flights with hard accelerations, of a gate a few microseconds ahead, of one that full speed just reaches, and
// on a face: states from which there once was no answer.
TEST(TrajectoryProperty, StatesOnceLostAreFlownFrom) {
  if (!kIsDouble) return;
  Flights flights;
  Counts rest;
  Counts sampled;
  for (const std::uint64_t seed : {52678U, 80854U, 84442U, 143046U, 151716U}) {
    RandomFlight flight(seed);
    RandomFlight replanned = flight;
    const FittedTrajectory& fitted = flights.fly(flight, rest, "from rest", seed);
    const std::vector<Segment> flown(fitted.segments.begin(), fitted.segments.end());
    continue_flight(replanned, flown, flight.boxes, seed);
    (void)flights.fly(replanned, sampled, "sampled", seed);
  }
  EXPECT_EQ(sampled.unanswered, 0U);
}

}  // namespace
