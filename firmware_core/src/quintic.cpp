#include "swiftlet/quintic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace swiftlet {
namespace {

constexpr int kDegree = 5;

// Row k: coefficients of tau^0..tau^5 of the Hermite basis function that belongs to end state k.
constexpr std::array<std::array<Real, 6>, 6> kHermite{{
    {1, 0, 0, -10, 15, -6},
    {0, 1, 0, -6, 8, -3},
    {0, 0, Real(0.5), Real(-1.5), Real(1.5), Real(-0.5)},
    {0, 0, 0, 10, -15, 6},
    {0, 0, 0, -4, 7, -3},
    {0, 0, 0, Real(0.5), -1, Real(0.5)},
}};

// Row d: what d differentiations multiply the coefficients of tau^0..tau^5 by.
constexpr std::array<std::array<Real, 6>, 3> kFalling{{
    {1, 1, 1, 1, 1, 1},
    {0, 1, 2, 3, 4, 5},
    {0, 0, 2, 6, 12, 20},
}};

template <std::size_t kOrder>
using Polynomial = std::array<Real, kOrder + 1>;

template <std::size_t kOrder>
Real value_at(const Polynomial<kOrder>& p, Real x) {
  Real value = p[kOrder];
  for (std::size_t j = kOrder; j-- > 0;) value = value * x + p[j];
  return value;
}

template <std::size_t kOrder>
Polynomial<kOrder - 1> differentiate(const Polynomial<kOrder>& p) {
  Polynomial<kOrder - 1> slope;
  for (std::size_t j = 1; j <= kOrder; ++j) slope[j - 1] = p[j] * static_cast<Real>(j);
  return slope;
}

// A Newton step as short as this leaves its square; in float only rounding is small enough.
constexpr Real kSettled = sizeof(Real) == 8 ? Real(1e-8) : std::numeric_limits<Real>::epsilon();

struct Point {
  Real x;
  Real value;
};

/// The root of p between two points, where p is monotone and changes sign: Newton steps kept inside the bracket by
/// bisection. They start in the middle: at either end the slope may be zero.
template <std::size_t kOrder>
Real bracketed_root(const Polynomial<kOrder>& p, const Polynomial<kOrder - 1>& slope, Point low, Point high) {
  constexpr int kSteps = 80;  // bisection alone needs 53
  Real a = low.x;
  Real b = high.x;
  const bool rising = high.value > 0;
  Real x = (a + b) / 2;
  for (int step = 0; step < kSteps; ++step) {
    const Real value = value_at<kOrder>(p, x);
    if (value == 0) return x;
    ((value > 0) == rising ? b : a) = x;
    const Real d = value_at<kOrder - 1>(slope, x);
    Real next = d != 0 ? x - value / d : a - 1;
    if (!(next > a && next < b)) next = (a + b) / 2;
    if (std::fabs(next - x) <= kSettled) return next;
    x = next;
  }
  return x;
}

/// The roots of the third derivative in [0, 1], ascending.
CriticalPoints roots_of_jerk(const Quintic& quintic) {
  const Real c = quintic[3];
  const Real b = 2 * quintic[4];  // half the coefficient of tau, all over 6
  const Real a = 10 * quintic[5];
  const Real discriminant = b * b - a * c;
  CriticalPoints roots;
  if (!(discriminant >= 0)) return roots;
  const Real q = b < 0 ? std::sqrt(discriminant) - b : -std::sqrt(discriminant) - b;
  // q / a and c / q, of which a division by zero gives neither.
  Real first = q / a;
  Real second = c / q;
  if (second < first) std::swap(first, second);
  for (const Real tau : {first, second}) {
    if (tau >= 0 && tau <= 1) roots.tau[roots.count++] = tau;
  }
  return roots;
}

/// The roots of p in [0, 1], ascending, given those of its slope: between two of them p is monotone.
template <std::size_t kOrder>
CriticalPoints roots_between(const Polynomial<kOrder>& p, const Polynomial<kOrder - 1>& slope,
                             const CriticalPoints& bends) {
  CriticalPoints roots;
  Point a{0, p[0]};
  for (std::size_t i = 0; i <= bends.count; ++i) {
    const Real end = i < bends.count ? bends.tau[i] : Real(1);
    const Point b{end, value_at<kOrder>(p, end)};
    if ((a.value > 0) != (b.value > 0) && a.x < b.x && roots.count < roots.tau.size()) {
      roots.tau[roots.count++] = bracketed_root<kOrder>(p, slope, a, b);
    }
    a = b;
  }
  return roots;
}

}  // namespace

QuinticEnds quintic_basis(int derivative, Real tau) {
  QuinticEnds weights{};
  for (std::size_t k = 0; k < weights.size(); ++k) weights[k] = quintic_value(kHermite[k], derivative, tau);
  return weights;
}

Real quintic_value(const Quintic& quintic, int derivative, Real tau) {
  const auto d = static_cast<std::size_t>(derivative);
  Real value = 0;
  for (std::size_t j = kDegree + 1; j-- > d;) value = value * tau + kFalling[d][j] * quintic[j];
  return value;
}

CriticalPoints critical_points(const Quintic& quintic, int derivative) {
  const CriticalPoints of_acceleration = roots_of_jerk(quintic);
  if (derivative == 2) return of_acceleration;
  const Polynomial<4> velocity = differentiate<5>(quintic);
  const Polynomial<3> acceleration = differentiate<4>(velocity);
  const Polynomial<2> jerk = differentiate<3>(acceleration);
  const CriticalPoints of_velocity = roots_between<3>(acceleration, jerk, of_acceleration);
  return derivative == 1 ? of_velocity : roots_between<4>(velocity, acceleration, of_velocity);
}

}  // namespace swiftlet
