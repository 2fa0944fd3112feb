#include <Eigen/LU>
#include <vector>

#include "harness/random_corridor.hpp"
#include "swiftlet/knot_spline.hpp"
#include "swiftlet/trajectory.hpp"
#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr Real kExact = Real(1e-7);  // some rows nearly depend on each other
using Dense = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic>;
using DenseVector = Eigen::Matrix<double, Eigen::Dynamic, 1>;

/// Random knots, and rows on some spans; the same problem is solved densely, from the cost of the polynomials alone.
struct Chain {
  std::vector<Knot> knots;
  std::vector<KnotSpan> spans;
  std::vector<KnotRow> rows;
  std::vector<Real> states;
  std::vector<KnotCoupling> coupling;
  std::array<CarriedRows, 2> carried;
  KnotSpline spline;

  /// `most_rows`: on each span of which an end is free.
  Chain(std::uint64_t seed, std::size_t count, std::size_t most_rows) {
    test::Random random(seed);
    for (std::size_t k = 0; k < count; ++k) {
      const bool held = most_rows == 0 || random.below(3) > 0;
      knots.push_back({held ? random.uniform(-2, 2) : Real(0), static_cast<std::uint32_t>(k), held});
    }
    for (std::size_t k = 0; k <= count; ++k) {
      const Real T = random.uniform(Real(0.4), 2);
      KnotSpan span{T, 1 / T, static_cast<std::uint32_t>(rows.size()), 0};
      const std::size_t wanted =
          k > 0 && k < count ? random.below(most_rows + 1) : random.below(std::min<std::size_t>(most_rows, 1) + 1);
      for (; span.row_count < wanted; ++span.row_count) rows.push_back(row(random, T));
      spans.push_back(span);
    }
    states.resize(kBlockSize * count);
    coupling.resize(count);
    spline = {{0, random.uniform(-1, 1), random.uniform(-1, 1)},
              {1, random.uniform(-1, 1), 0},
              knots,
              spans,
              rows,
              states,
              coupling,
              carried};
  }
  Chain(const Chain&) = delete;
  Chain& operator=(const Chain&) = delete;

  /// Position, velocity or acceleration somewhere inside.
  static KnotRow row(test::Random& random, Real T) {
    KnotRow row;
    const int derivative = static_cast<int>(random.below(3));
    const QuinticEnds basis = quintic_basis(derivative, random.uniform(Real(0.2), Real(0.8)));
    for (std::size_t i = 0; i < basis.size(); ++i) {
      Real unit = 1;
      for (std::size_t d = 0; d < i % kBlockSize; ++d) unit *= T;
      row.n[i] = basis[i] * unit;
    }
    row.bound = random.uniform(-1, 1);
    return row;
  }

  /// The states as a dense solve moves them: unknowns in order, held positions left out.
  [[nodiscard]] std::vector<Real*> unknowns() {
    std::vector<Real*> result;
    for (std::size_t k = 0; k < knots.size(); ++k) {
      for (std::size_t i = knots[k].held ? 1 : 0; i < kBlockSize; ++i) result.push_back(&states[kBlockSize * k + i]);
    }
    return result;
  }

  /// Half the integral of squared jerk, from the emitted polynomials.
  [[nodiscard]] double half_cost() const {
    double sum = 0;
    for (std::size_t k = 0; k < spans.size(); ++k) {
      const Quintic c = quintic_from_ends(span_ends(spline, k));
      Segment segment;
      segment.duration = spans[k].duration;
      Real unit = 1;
      for (std::size_t j = 0; j < c.size(); ++j, unit *= segment.duration) segment.coefficients[0][j] = c[j] / unit;
      sum += static_cast<double>(jerk_cost(std::span(&segment, 1), 0)) / 2;
    }
    return sum;
  }

  [[nodiscard]] double excess(const KnotRow& row, std::size_t span) const {
    double value = -row.bound;
    for (std::size_t i = 0; i < row.n.size(); ++i) {
      const bool left = i < kBlockSize;
      const Real* state = left ? (span == 0 ? spline.start.data() : &states[kBlockSize * (span - 1)])
                               : (span == knots.size() ? spline.goal.data() : &states[kBlockSize * span]);
      value += row.n[i] * state[i % kBlockSize];
    }
    return value;
  }

  [[nodiscard]] std::size_t span_of(std::size_t row) const {
    std::size_t span = 0;
    while (spans[span].first_row + spans[span].row_count <= row) ++span;
    return span;
  }
};

/// The KKT system by differences of the quadratic cost and the linear rows, which are exact but for rounding.
void solve_densely(Chain& chain, std::vector<double>& x, std::vector<double>& multipliers) {
  const std::vector<Real*> unknowns = chain.unknowns();
  const auto n = static_cast<Eigen::Index>(unknowns.size());
  const auto m = static_cast<Eigen::Index>(chain.rows.size());
  for (Real* unknown : unknowns) *unknown = 0;
  for (std::size_t k = 0; k < chain.knots.size(); ++k) {
    if (chain.knots[k].held) chain.states[kBlockSize * k] = chain.knots[k].position;
  }
  Dense kkt = Dense::Zero(n + m, n + m);
  DenseVector right = DenseVector::Zero(n + m);
  const double at_zero = chain.half_cost();
  std::vector<double> single(unknowns.size());
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    *unknowns[i] = 1;
    single[i] = chain.half_cost();
    *unknowns[i] = 0;
  }
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    for (std::size_t j = 0; j < unknowns.size(); ++j) {
      *unknowns[i] += 1;
      *unknowns[j] += 1;
      kkt(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          chain.half_cost() - single[i] - single[j] + at_zero;
      *unknowns[i] = 0;
      *unknowns[j] = 0;
    }
    const auto at = static_cast<Eigen::Index>(i);
    right[at] = -(single[i] - at_zero - kkt(at, at) / 2);
  }
  for (std::size_t r = 0; r < chain.rows.size(); ++r) {
    const std::size_t span = chain.span_of(r);
    const auto at = n + static_cast<Eigen::Index>(r);
    const double constant = chain.excess(chain.rows[r], span);
    right[at] = -constant;
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      *unknowns[i] = 1;
      kkt(at, static_cast<Eigen::Index>(i)) = kkt(static_cast<Eigen::Index>(i), at) =
          chain.excess(chain.rows[r], span) - constant;
      *unknowns[i] = 0;
    }
  }
  const DenseVector solution = kkt.fullPivLu().solve(right);
  x.assign(solution.data(), solution.data() + n);
  multipliers.assign(solution.data() + n, solution.data() + n + m);
}

TEST(KnotSpline, AgreesWithADenseSolve) {
  if (sizeof(Real) != 8) GTEST_SKIP() << "the dense problem is taken from differences of the cost, too coarse in float";
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Chain chain(seed, 1 + seed % 9, seed % 3);
    std::vector<double> x;
    std::vector<double> multipliers;
    solve_densely(chain, x, multipliers);
    if (!solve_knot_spline(chain.spline)) continue;  // random rows may depend on each other; counted below
    const std::vector<Real*> unknowns = chain.unknowns();
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      EXPECT_NEAR(*unknowns[i], x[i], kExact * (1 + std::fabs(x[i])));
    }
    for (std::size_t r = 0; r < chain.rows.size(); ++r) {
      EXPECT_NEAR(chain.rows[r].multiplier, multipliers[r], 100 * kExact * (1 + std::fabs(multipliers[r])));
    }
  }
}

TEST(KnotSpline, NearlyAllRandomRowsAreIndependent) {
  int solved = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Chain chain(seed, 1 + seed % 9, seed % 3);
    solved += solve_knot_spline(chain.spline) ? 1 : 0;
  }
  EXPECT_GE(solved, 270);
}

TEST(KnotSpline, RefusesRowsThatDependOnEachOther) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Chain chain(seed, 5, 0);
    test::Random random(seed);
    chain.knots[2].held = false;
    chain.rows = {Chain::row(random, chain.spans[2].duration)};
    chain.rows.push_back(chain.rows[0]);
    chain.rows[1].bound += 1;
    chain.spline.rows = chain.rows;
    for (std::size_t k = 0; k < chain.spans.size(); ++k) {
      chain.spans[k].first_row = k <= 2 ? 0 : 2;
      chain.spans[k].row_count = k == 2 ? 2 : 0;
    }
    EXPECT_FALSE(solve_knot_spline(chain.spline));
  }
}

TEST(KnotSpline, WithoutAKnotNoRowCanHold) {
  Chain chain(1, 0, 0);
  EXPECT_TRUE(solve_knot_spline(chain.spline));
  test::Random random(1);
  chain.rows = {Chain::row(random, 1)};
  chain.spline.rows = chain.rows;
  EXPECT_FALSE(solve_knot_spline(chain.spline));
}

}  // namespace
}  // namespace swiftlet
