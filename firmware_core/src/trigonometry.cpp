#include "swiftlet/trigonometry.hpp"

#include <cmath>
#include <numbers>

namespace swiftlet {
namespace {

// A right angle in two parts; the first has 33 bits, so its product with up to a million turns is exact.
constexpr double kRightAngle = 0x1.921fb544p+0;
constexpr double kRightAngleRest = 0x1.0b4611a626331p-34;

/// Taylor's series 1 - x/(n (n+1)) (1 - x/((n+2) (n+3)) (...)), innermost first: sine for n = 2, cosine for n = 1.
double series(double angle2, int first) {
  double sum = 1;
  for (int n = first + 16; n >= first; n -= 2) sum = 1 - angle2 / (n * (n + 1)) * sum;
  return sum;
}

/// An angle as quarter turns and a rest of at most an eighth of a turn, give or take a rounding.
struct Reduced {
  double quarter;  // 0, 1, 2 or 3
  double rest;     // [rad]
};

Reduced reduce(double angle) {
  const double quarters = std::floor(angle * (2 / std::numbers::pi) + 0.5);
  const double rest = (angle - quarters * kRightAngle) - quarters * kRightAngleRest;
  return {quarters - 4 * std::floor(quarters / 4), rest};
}

/// The sine of the angle and `quarters_more` quarter turns.
double sine_of(Reduced angle, int quarters_more) {
  const double square = angle.rest * angle.rest;
  const double quarter = angle.quarter + quarters_more;
  const bool is_cosine = quarter == 1 || quarter == 3;
  const double value = is_cosine ? series(square, 1) : angle.rest * series(square, 2);
  return quarter == 2 || quarter == 3 ? -value : value;
}

/// Arc tangent for 0 <= t <= 1: the angle is halved twice, then its series converges at a digit and a half a term.
double arc_tangent(double t) {
  for (int i = 0; i < 2; ++i) t /= 1 + std::sqrt(1 + t * t);
  double sum = 0;
  for (int n = 21; n >= 1; n -= 2) sum = 1.0 / n - t * t * sum;
  return 4 * t * sum;
}

}  // namespace

Real sine(Real angle) { return static_cast<Real>(sine_of(reduce(static_cast<double>(angle)), 0)); }

Real cosine(Real angle) { return static_cast<Real>(sine_of(reduce(static_cast<double>(angle)), 1)); }

Real angle_of(Real y, Real x) {
  const auto rise = static_cast<double>(std::fabs(y));
  const auto run = static_cast<double>(std::fabs(x));
  if (rise == 0 && run == 0) return std::copysign(std::signbit(x) ? std::numbers::pi_v<Real> : Real(0), y);
  const bool steep = rise > run;
  double angle = arc_tangent(steep ? run / rise : rise / run);
  if (steep) angle = std::numbers::pi / 2 - angle;
  if (x < 0) angle = std::numbers::pi - angle;
  return std::copysign(static_cast<Real>(angle), y);
}

}  // namespace swiftlet
