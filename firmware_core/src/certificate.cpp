#include "swiftlet/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace swiftlet {
namespace {

constexpr Real kEpsilon = std::numeric_limits<Real>::epsilon();
constexpr Real kInfinity = std::numeric_limits<Real>::infinity();
constexpr bool kIsDouble = sizeof(Real) == 8;

constexpr Real kTolerance = kIsDouble ? Real(1e-6) : Real(1e-3);
constexpr std::array<Real, 3> kJumpLimits = kIsDouble ? std::array<Real, 3>{Real(1e-6), Real(1e-5), Real(1e-4)}
                                                      : std::array<Real, 3>{Real(1e-4), Real(1e-3), Real(1e-2)};

// Bisections of one segment. The gap between hull and polynomial shrinks fourfold with each, so twelve leave a ten
// millionth of it.
constexpr std::size_t kDepth = 12;

/// A polynomial on [0, 1] by its control points, each wrong by at most `error`: conversion and kDepth bisections
/// included.
template <std::size_t kDegree>
struct Bernstein {
  std::array<Real, kDegree + 1> points{};
  Real error = 0;
};

constexpr std::array<std::array<Real, 9>, 9> kBinomial = [] {
  std::array<std::array<Real, 9>, 9> table{};
  for (std::size_t n = 0; n < table.size(); ++n) {
    table[n][0] = 1;
    for (std::size_t k = 1; k <= n; ++k) table[n][k] = table[n - 1][k - 1] + (k < n ? table[n - 1][k] : Real(0));
  }
  return table;
}();

// Rounding, in units of epsilon: a control point is a sum of at most six terms that were rounded at most eight times
// each; kDepth bisections of a polynomial of degree eight average 96 times, half a unit each.
constexpr Real kConversion = 8 * kEpsilon;
constexpr Real kBisections = 64 * kEpsilon;

template <std::size_t kSize>
Real largest_magnitude(const std::array<Real, kSize>& values) {
  Real largest = 0;
  for (const Real value : values) largest = std::max(largest, std::fabs(value));
  return largest;
}

/// Control points of sum_j c_j t^j over 0 <= t <= T.
template <std::size_t kDegree>
Bernstein<kDegree> to_bernstein(const std::array<Real, kDegree + 1>& c, Real T) {
  Bernstein<kDegree> result;
  std::array<Real, kDegree + 1> scaled{};
  Real power = 1;
  Real magnitude = 0;
  for (std::size_t j = 0; j <= kDegree; ++j) {
    scaled[j] = c[j] * power;
    magnitude += std::fabs(scaled[j]);
    power *= T;
  }
  for (std::size_t i = 0; i <= kDegree; ++i) {
    for (std::size_t j = 0; j <= i; ++j) result.points[i] += kBinomial[i][j] / kBinomial[kDegree][j] * scaled[j];
  }
  result.error = kConversion * magnitude + kBisections * largest_magnitude(result.points);
  return result;
}

/// Adds the square of `factor` to `sum`, whose degree is twice as large.
template <std::size_t kDegree>
void add_square(const Bernstein<kDegree>& factor, Bernstein<2 * kDegree>& sum) {
  for (std::size_t i = 0; i <= kDegree; ++i) {
    for (std::size_t j = 0; j <= kDegree; ++j) {
      const Real weight = kBinomial[kDegree][i] * kBinomial[kDegree][j] / kBinomial[2 * kDegree][i + j];
      sum.points[i + j] += weight * factor.points[i] * factor.points[j];
    }
  }
  // |x^2 - y^2| <= 2 |x| d + d^2; a sum of fifteen products of four factors, three times.
  const Real largest = largest_magnitude(factor.points);
  sum.error += factor.error * (2 * largest + factor.error) + (4 * kConversion + kBisections) * largest * largest;
}

/// Outward-rounded upper bound of the polynomial on [0, 1], or `floor` when the bound is not above it: branch and bound
/// over halves, the stack holding at most one waiting half a level.
template <std::size_t kDegree>
Real upper_bound(const Bernstein<kDegree>& polynomial, Real floor) {
  if (!(polynomial.error < kInfinity)) return kInfinity;  // overflow or NaN in the coefficients
  struct Piece {
    std::array<Real, kDegree + 1> points;
    std::size_t depth;
  };
  std::array<Piece, kDepth + 2> stack;
  stack[0] = {polynomial.points, 0};
  std::size_t count = 1;
  // What is attained for sure, at ends of pieces: a half whose hull hardly exceeds it needs no further look.
  Real attained = floor - polynomial.error;
  Real bound = floor;
  while (count > 0) {
    Piece left = stack[--count];
    attained = std::max({attained, left.points[0], left.points[kDegree]});
    const Real hull = *std::max_element(left.points.begin(), left.points.end());
    const bool tight = hull <= attained + kTolerance / 16;
    if (tight || left.depth == kDepth) {
      if (hull + polynomial.error > bound) bound = hull + polynomial.error;
      continue;
    }
    Piece right;
    right.depth = ++left.depth;
    for (std::size_t i = 0; i <= kDegree; ++i) {
      right.points[kDegree - i] = left.points[kDegree];
      for (std::size_t j = kDegree; j > i; --j) left.points[j] = (left.points[j - 1] + left.points[j]) / 2;
    }
    stack[count++] = right;
    stack[count++] = left;
  }
  return bound;
}

template <std::size_t kDegree>
Bernstein<kDegree> negated(Bernstein<kDegree> polynomial) {
  for (Real& point : polynomial.points) point = -point;
  return polynomial;
}

/// Running extreme values of a trajectory.
struct Extremes {
  Real outside = -kInfinity;  // [m] beyond a face of the boxes
  Vector3 speed = Vector3::Zero();
  Vector3 acceleration = Vector3::Zero();
  Real speed2 = 0;
  Real acceleration2 = 0;
  Vector3 jerk = Vector3::Zero();
  Real jerk2 = 0;
  Real least_thrust2 = kInfinity;  // thrust over mass, squared [m^2/s^4]
  Real most_thrust2 = 0;
  Real rate = 0;
};

/// Square root, rounded up.
Real root_up(Real square) { return std::sqrt(square) * (1 + 2 * kEpsilon); }

/// Square root, rounded down; 0 for a bound below zero.
Real root_down(Real square) { return square > 0 ? std::sqrt(square) * (1 - 2 * kEpsilon) : Real(0); }

/// Thrust m |a + g e_z| and body rates, which are at most |jerk| / |a + g e_z| (Sec. IV-A).
void visit_thrust(std::array<Bernstein<3>, 3> force, const Bernstein<4>& jerk2, Extremes& extremes) {
  for (Real& point : force[2].points) point += kGravity;
  force[2].error += kEpsilon * (largest_magnitude(force[2].points) + kGravity);
  Bernstein<6> thrust2;
  for (const Bernstein<3>& component : force) add_square(component, thrust2);
  extremes.most_thrust2 = upper_bound(thrust2, extremes.most_thrust2);
  const Real least = -upper_bound(negated(thrust2), -kInfinity);
  extremes.least_thrust2 = std::min(extremes.least_thrust2, least);
  const Real rate = root_up(upper_bound(jerk2, 0)) / root_down(least) * (1 + 2 * kEpsilon);
  extremes.rate = std::max(extremes.rate, least > 0 ? rate : kInfinity);
}

void visit_segment(const Segment& segment, const Box& box, bool has_vehicle, Extremes& extremes) {
  const Real T = segment.duration;
  Bernstein<8> speed2;
  Bernstein<6> acceleration2;
  Bernstein<4> jerk2;
  std::array<Bernstein<3>, 3> accelerations;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<Eigen::Index>(axis);
    const std::array<Real, kQuinticTerms>& c = segment.coefficients[axis];
    // Distances to the faces: c[0] - face is one rounding, and small numbers keep their digits.
    const Real face_error = kEpsilon * std::fabs(c[0]);
    const Bernstein<5> above = to_bernstein<5>({c[0] - box.hi[row], c[1], c[2], c[3], c[4], c[5]}, T);
    const Bernstein<5> below = negated(to_bernstein<5>({c[0] - box.lo[row], c[1], c[2], c[3], c[4], c[5]}, T));
    const Bernstein<4> v = to_bernstein<4>({c[1], 2 * c[2], 3 * c[3], 4 * c[4], 5 * c[5]}, T);
    const Bernstein<3> a = to_bernstein<3>({2 * c[2], 6 * c[3], 12 * c[4], 20 * c[5]}, T);
    extremes.outside = std::max(extremes.outside, upper_bound(above, extremes.outside - face_error) + face_error);
    extremes.outside = std::max(extremes.outside, upper_bound(below, extremes.outside - face_error) + face_error);
    extremes.speed[row] = upper_bound(v, extremes.speed[row]);
    extremes.speed[row] = upper_bound(negated(v), extremes.speed[row]);
    extremes.acceleration[row] = upper_bound(a, extremes.acceleration[row]);
    extremes.acceleration[row] = upper_bound(negated(a), extremes.acceleration[row]);
    const Bernstein<2> j = to_bernstein<2>({6 * c[3], 24 * c[4], 60 * c[5]}, T);
    extremes.jerk[row] = upper_bound(j, extremes.jerk[row]);
    extremes.jerk[row] = upper_bound(negated(j), extremes.jerk[row]);
    add_square(v, speed2);
    add_square(a, acceleration2);
    add_square(j, jerk2);
    accelerations[axis] = a;
  }
  extremes.speed2 = upper_bound(speed2, extremes.speed2);
  extremes.acceleration2 = upper_bound(acceleration2, extremes.acceleration2);
  extremes.jerk2 = upper_bound(jerk2, extremes.jerk2);
  if (has_vehicle) visit_thrust(accelerations, jerk2, extremes);
}

std::array<Vector3, 3> state_of(const Sample& sample) {
  return {sample.position, sample.velocity, sample.acceleration};
}
std::array<Vector3, 3> state_of(const State& state) { return {state.position, state.velocity, state.acceleration}; }

/// Raises `largest` to the per-derivative differences of two states; a NaN raises it to infinity.
void raise_to_difference(const std::array<Vector3, 3>& a, const std::array<Vector3, 3>& b,
                         std::array<Real, 3>& largest) {
  for (std::size_t d = 0; d < 3; ++d) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const Real difference = std::fabs(a[d][axis] - b[d][axis]);
      if (!(difference <= largest[d])) largest[d] = difference <= kInfinity ? difference : kInfinity;
    }
  }
}

bool within(const std::array<Real, 3>& values, const std::array<Real, 3>& limits) {
  return values[0] <= limits[0] && values[1] <= limits[1] && values[2] <= limits[2];
}

bool lies_in(const Vector3& point, const Box& box) {
  return (point.array() >= box.lo.array() - kTolerance).all() && (point.array() <= box.hi.array() + kTolerance).all();
}

bool has_form(std::span<const Segment> segments, const CertificateRequest& request) {
  if (segments.empty() || request.boxes.size() != segments.size()) return false;
  if (request.gates.size() + 1 != segments.size()) return false;
  for (const Segment& segment : segments) {
    if (!(segment.duration > 0 && segment.duration < kInfinity)) return false;
  }
  return true;
}

bool keeps_vehicle(const Certificate& certificate, const std::optional<Vehicle>& vehicle) {
  return !vehicle || (certificate.min_thrust >= vehicle->thrust_min - kTolerance &&
                      certificate.max_thrust <= vehicle->thrust_max + kTolerance &&
                      certificate.max_rate <= vehicle->rate_max + kTolerance);
}

}  // namespace

CertificateRequest certificate_request(const FlightLimits& limits) {
  const bool per_axis = limits.norm == LimitNorm::kAxis;
  const auto axes = [&](Real limit) { return Vector3::Constant(per_axis ? limit : kInfinity); };
  const auto norm = [&](Real limit) { return per_axis ? kInfinity : limit; };
  return {{},
          {},
          {},
          {},
          axes(limits.v_max),
          axes(limits.a_max),
          norm(limits.v_max),
          norm(limits.a_max),
          axes(limits.j_max),
          norm(limits.j_max),
          limits.vehicle};
}

Certificate certify(std::span<const Segment> segments, const CertificateRequest& request) {
  Certificate certificate;
  certificate.tolerance = kTolerance;
  if (!has_form(segments, request)) return certificate;
  Extremes extremes;
  bool gates_kept = true;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    visit_segment(segments[i], request.boxes[i], request.vehicle.has_value(), extremes);
    if (i + 1 == segments.size()) continue;
    const Sample end = sample_segment(segments[i], segments[i].duration);
    raise_to_difference(state_of(end), state_of(sample_segment(segments[i + 1], 0)), certificate.max_jump);
    gates_kept = gates_kept && lies_in(end.position, request.gates[i]);
  }
  raise_to_difference(state_of(sample_segment(segments.front(), 0)), state_of(request.start),
                      certificate.max_end_error);
  raise_to_difference(state_of(sample_segment(segments.back(), segments.back().duration)), state_of(request.goal),
                      certificate.max_end_error);
  certificate.box_margin = -extremes.outside;
  certificate.max_speed = extremes.speed;
  certificate.max_acceleration = extremes.acceleration;
  certificate.max_speed_norm = root_up(extremes.speed2);
  certificate.max_acceleration_norm = root_up(extremes.acceleration2);
  certificate.max_jerk = extremes.jerk;
  certificate.max_jerk_norm = root_up(extremes.jerk2);
  if (request.vehicle) {
    certificate.min_thrust = request.vehicle->mass * root_down(extremes.least_thrust2) * (1 - kEpsilon);
    certificate.max_thrust = request.vehicle->mass * root_up(extremes.most_thrust2) * (1 + kEpsilon);
    certificate.max_rate = extremes.rate;
  }
  certificate.pass = certificate.box_margin >= -kTolerance && gates_kept &&
                     (extremes.speed.array() <= request.v_max.array() + kTolerance).all() &&
                     (extremes.acceleration.array() <= request.a_max.array() + kTolerance).all() &&
                     certificate.max_speed_norm <= request.speed_max + kTolerance &&
                     certificate.max_acceleration_norm <= request.acceleration_norm_max + kTolerance &&
                     (extremes.jerk.array() <= request.j_max.array() + kTolerance).all() &&
                     certificate.max_jerk_norm <= request.jerk_norm_max + kTolerance &&
                     keeps_vehicle(certificate, request.vehicle) && within(certificate.max_jump, kJumpLimits) &&
                     within(certificate.max_end_error, kJumpLimits);
  return certificate;
}

}  // namespace swiftlet
