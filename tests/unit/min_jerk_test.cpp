#include "swiftlet/min_jerk.hpp"

#include "harness/random_corridor.hpp"
#include "swiftlet/trajectory.hpp"
#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr bool kIsDouble = sizeof(Real) == 8;
constexpr std::size_t kSegments = 6;
constexpr std::size_t kUnknowns = kBlockSize * (kSegments - 1);

/// Gates of +-100 m (or thin ones) under random durations and end states.
struct Chain {
  std::array<Real, kSegments> durations{};
  std::array<Real, kSegments - 1> scales{};
  std::array<Box, kSegments - 1> gates;
  AxisProblem problem;
  std::array<FactorBlock, kSegments - 1> factor{};
  std::array<Real, kUnknowns> optimum{};

  Chain(std::uint64_t seed, bool pin_some) {
    test::Random random(seed);
    for (Real& duration : durations) duration = random.uniform(Real(0.3), 2);
    for (std::size_t k = 0; k < gates.size(); ++k) {
      const Real middle = random.uniform(-2, 2);
      const Real half = pin_some && k % 2 == 1 ? Real(0) : Real(100);
      gates[k] = {Vector3::Constant(middle - half), Vector3::Constant(middle + half)};
    }
    junction_scales(durations, scales);
    problem = {
        1, durations, scales, gates, {0, random.uniform(-1, 1), random.uniform(-1, 1)}, {3, 0, random.uniform(-1, 1)},
        0};
    factor_jerk_cost(problem, factor, optimum);
  }

  /// Integral of squared jerk at `unknowns`, from the polynomials themselves.
  [[nodiscard]] Real cost(const std::array<Real, kUnknowns>& unknowns) const {
    Real sum = 0;
    for (std::size_t i = 0; i < kSegments; ++i) {
      const Quintic quintic = quintic_from_ends(segment_ends(problem, i, unknowns));
      Segment segment;
      segment.duration = durations[i];
      Real unit = 1;
      for (std::size_t j = 0; j < kQuinticTerms; ++j, unit *= durations[i]) {
        segment.coefficients[0][j] = quintic[j] / unit;
      }
      sum += jerk_cost(std::span(&segment, 1), 0);
    }
    return sum;
  }

  /// |D U e|^2.
  [[nodiscard]] Real factored_norm(const std::array<Real, kUnknowns>& e) const {
    Real sum = 0;
    constexpr std::size_t kMiddle = middle_block(kSegments - 1);
    for (std::size_t k = 0; k + 1 < kSegments; ++k) {
      const std::size_t inner = k < kMiddle ? k + 1 : k - 1;
      std::array<Real, 3> y{e[3 * k], e[3 * k + 1], e[3 * k + 2]};
      for (std::size_t i = 0; i < 9 && k != kMiddle; ++i) y[i / 3] += factor[k].coupling[i] * e[3 * inner + i % 3];
      // D y by back substitution on its inverse.
      const std::array<Real, 6>& d = factor[k].inverse_diagonal;
      const Real z2 = y[2] / d[5];
      const Real z1 = (y[1] - d[4] * z2) / d[3];
      const Real z0 = (y[0] - d[1] * z1 - d[2] * z2) / d[0];
      sum += z0 * z0 + z1 * z1 + z2 * z2;
    }
    return sum;
  }
};

TEST(MinJerk, WithoutConstraintsManySegmentsAreOneQuintic) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Chain chain(seed, false);
    Real total = 0;
    for (const Real duration : chain.durations) total += duration;
    const std::array<Real, 3>& s = chain.problem.start;
    const std::array<Real, 3>& g = chain.problem.goal;
    const Quintic whole =
        quintic_from_ends({s[0], s[1] * total, s[2] * total * total, g[0], g[1] * total, g[2] * total * total});
    Real t = 0;
    for (std::size_t i = 0; i < kSegments; ++i) {
      const QuinticEnds ends = segment_ends(chain.problem, i, chain.optimum);
      // In float the hold draws towards gates whose middles are metres away.
      EXPECT_NEAR(ends[0], quintic_value(whole, 0, t / total), kIsDouble ? 1e-9 : 0.2);
      t += chain.durations[i];
    }
  }
}

TEST(MinJerk, ThinGatesPinTheirJunctions) {
  const Chain chain(7, true);
  for (std::size_t k = 1; k < chain.gates.size(); k += 2) {
    EXPECT_NEAR(chain.optimum[kBlockSize * k], chain.gates[k].lo[1], kIsDouble ? 1e-12 : 1e-6);
  }
}

TEST(MinJerk, AnyStepFromTheOptimumCostsTheFactoredSquare) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const Chain chain(seed, seed % 2 == 0);
    test::Random random(seed + 1000);
    std::array<Real, kUnknowns> e{};
    std::array<Real, kUnknowns> moved = chain.optimum;
    for (std::size_t i = 0; i < kUnknowns; ++i) {
      const bool pinned = i % kBlockSize == 0 && is_pinned(chain.problem, i / kBlockSize);
      e[i] = pinned ? Real(0) : random.uniform(-1, 1);
      moved[i] += e[i];
    }
    const Real expected = chain.factored_norm(e);
    EXPECT_GT(expected, Real(0));
    EXPECT_NEAR(chain.cost(moved) - chain.cost(chain.optimum), expected,
                (kIsDouble ? Real(1e-9) : Real(1e-2)) * expected);
  }
}

TEST(MinJerk, RowsMeasureThePolynomialTheyBound) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const Chain chain(seed, seed % 2 == 0);
    test::Random random(seed + 2000);
    const std::size_t segment = random.below(kSegments);
    const Real tau = random.uniform(0, 1);
    for (int derivative = 0; derivative <= 2; ++derivative) {
      for (const Real sign : {Real(1), Real(-1)}) {
        const QpRow row = extremum_row(chain.problem, segment, derivative, tau, sign, Real(0.5));
        Real value =
            quintic_value(quintic_from_ends(segment_ends(chain.problem, segment, chain.optimum)), derivative, tau);
        for (int d = 0; d < derivative; ++d) value /= chain.durations[segment];
        EXPECT_NEAR(row_value(row, chain.optimum) - row.bound, sign * (value - Real(0.5)), kIsDouble ? 1e-8 : 2e-2);
      }
    }
  }
}

}  // namespace
}  // namespace swiftlet
