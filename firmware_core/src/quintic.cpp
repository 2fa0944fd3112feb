#include "swiftlet/quintic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

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

struct Polynomial {
  std::array<Real, 6> c{};
  int degree = 0;

  [[nodiscard]] Real operator()(Real x) const {
    Real value = c[static_cast<std::size_t>(degree)];
    for (int j = degree - 1; j >= 0; --j) value = value * x + c[static_cast<std::size_t>(j)];
    return value;
  }
};

Polynomial differentiate(const Polynomial& p) {
  Polynomial d;
  d.degree = p.degree - 1;
  for (int j = 1; j <= p.degree; ++j) {
    d.c[static_cast<std::size_t>(j - 1)] = p.c[static_cast<std::size_t>(j)] * static_cast<Real>(j);
  }
  return d;
}

// A Newton step as short as this leaves its square; in float only rounding is small enough.
constexpr Real kSettled = sizeof(Real) == 8 ? Real(1e-8) : std::numeric_limits<Real>::epsilon();

/// The root of p in [a, b], where p is monotone and changes sign: Newton steps kept inside the bracket by bisection.
Real bracketed_root(const Polynomial& p, const Polynomial& slope, Real a, Real b) {
  constexpr int kSteps = 80;  // bisection alone needs 53
  const bool rising = p(a) < p(b);
  Real x = (a + b) / 2;
  for (int step = 0; step < kSteps; ++step) {
    const Real value = p(x);
    if (value == 0) return x;
    ((value > 0) == rising ? b : a) = x;
    const Real d = slope(x);
    Real next = d != 0 ? x - value / d : a - 1;
    if (!(next > a && next < b)) next = (a + b) / 2;
    if (std::fabs(next - x) <= kSettled) return next;
    x = next;
  }
  return x;
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
  // Each derivative is monotone between the roots of the next one, so roots are found from the linear one upwards.
  std::array<Polynomial, 5> chain;  // chain[d] is the (d + 1)-th derivative, degree 4 - d
  chain[0] = differentiate({quintic, kDegree});
  for (std::size_t d = 1; d < chain.size(); ++d) chain[d] = differentiate(chain[d - 1]);
  CriticalPoints roots;
  for (std::size_t d = chain.size() - 1; d-- > static_cast<std::size_t>(derivative);) {
    const CriticalPoints bends = roots;
    roots.count = 0;
    Real a = 0;
    for (std::size_t i = 0; i <= bends.count; ++i) {
      const Real b = i < bends.count ? bends.tau[i] : Real(1);
      const bool changes_sign = (chain[d](a) > 0) != (chain[d](b) > 0);
      if (changes_sign && a < b && roots.count < roots.tau.size()) {
        roots.tau[roots.count++] = bracketed_root(chain[d], chain[d + 1], a, b);
      }
      a = b;
    }
  }
  return roots;
}

}  // namespace swiftlet
