#include "swiftlet/flight_limits.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

bool is_in_range(Real limit) { return limit >= kLeastLimit && limit <= kLargestLimit; }

bool is_usable(const Vehicle& vehicle) {
  const Real weight = vehicle.mass * kGravity;
  return vehicle.mass > 0 && vehicle.thrust_min >= 0 && vehicle.thrust_min < weight && weight < vehicle.thrust_max &&
         vehicle.thrust_max < kUnlimited && vehicle.rate_max > 0 && vehicle.rate_max < kUnlimited;
}

}  // namespace

bool is_usable(const FlightLimits& limits) {
  return is_in_range(limits.v_max) && is_in_range(limits.a_max) && limits.j_max >= kLeastLimit &&
         (!limits.vehicle || is_usable(*limits.vehicle));
}

MotionBounds motion_bounds(const FlightLimits& limits) {
  MotionBounds bounds;
  const bool per_axis = limits.norm == LimitNorm::kAxis;
  // A norm bounds each axis as well.
  bounds.v = {limits.v_max, per_axis ? kUnlimited : limits.v_max};
  bounds.a = {limits.a_max, per_axis ? kUnlimited : limits.a_max};
  (per_axis ? bounds.j.axis : bounds.j.norm) = limits.j_max;
  if (!limits.vehicle) return bounds;
  const Vehicle& vehicle = *limits.vehicle;
  // A hair inside, for the rounding of what follows.
  constexpr Real kInside = 1 - Real(sizeof(Real) == 8 ? 1e-9 : 1e-5);
  const Real afforded =
      kInside * std::min(kGravity - vehicle.thrust_min / vehicle.mass, vehicle.thrust_max / vehicle.mass - kGravity);
  // The rate bound needs thrust left at the largest acceleration: half of gravity at least where thrust_min is zero.
  const Real reached = std::min({afforded, kGravity / 2, per_axis ? Real(1.7320509) * limits.a_max : limits.a_max});
  bounds.a.norm = std::min(bounds.a.norm, reached);
  bounds.a.axis = std::min(bounds.a.axis, reached);
  bounds.j.norm = std::min(bounds.j.norm, kInside * vehicle.rate_max * (kGravity - reached));
  return bounds;
}

Real cube_root(Real x) {
  if (!(x > 0)) return 0;
  // A start within a factor of two, then quadratic convergence.
  Real root = 1;
  for (int i = 0; i < 400 && root * root * root < x; ++i) root *= 2;
  for (int i = 0; i < 400 && root * root * root > 8 * x; ++i) root /= 2;
  for (int i = 0; i < 7; ++i) root = (2 * root + x / (root * root)) / 3;
  return root;
}

Real slow_down(const Segment& segment, const MotionBounds& bounds) {
  constexpr int kPieces = 8;
  Real speed = 0;
  Real acceleration = 0;
  Real jerk = 0;
  for (int i = 0; i <= kPieces; ++i) {
    const Sample sample = sample_segment(segment, segment.duration * static_cast<Real>(i) / kPieces);
    speed = std::max(speed, sample.velocity.squaredNorm() / (bounds.v.norm * bounds.v.norm));
    acceleration = std::max(acceleration, sample.acceleration.squaredNorm() / (bounds.a.norm * bounds.a.norm));
    jerk = std::max({jerk, sample.jerk.squaredNorm() / (bounds.j.norm * bounds.j.norm),
                     sample.jerk.cwiseAbs2().maxCoeff() / (bounds.j.axis * bounds.j.axis)});
  }
  return std::max({std::sqrt(speed), std::sqrt(std::sqrt(acceleration)), cube_root(std::sqrt(jerk))});
}

}  // namespace swiftlet
