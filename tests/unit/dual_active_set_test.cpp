#include "swiftlet/dual_active_set.hpp"

#include <algorithm>
#include <cmath>

#include "harness/random_corridor.hpp"
#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr bool kIsDouble = sizeof(Real) == 8;
constexpr std::size_t kBlocks = 4;
constexpr std::size_t kUnknowns = kBlockSize * kBlocks;
constexpr std::size_t kRows = 20;

/// A well-conditioned random factor and optimum, with room for `kCapacity` active rows.
template <std::size_t kCapacity>
struct Fixture {
  std::array<FactorBlock, kBlocks> factor{};
  std::array<Real, kUnknowns> optimum{};
  std::array<Real, kUnknowns> solution{};
  std::array<Real, kUnknowns> work{};
  std::array<QpRow, kCapacity> rows{};
  std::array<Real, kCapacity> multipliers{};
  std::array<Real, kCapacity> target{};
  std::array<Real, kCapacity> direction{};
  std::array<Real, kCapacity*(kCapacity + 1) / 2> gram{};

  explicit Fixture(std::uint64_t seed) {
    test::Random random(seed);
    for (FactorBlock& block : factor) {
      for (Real& value : block.inverse_diagonal) value = random.uniform(Real(-0.4), Real(0.4));
      for (const std::size_t i : {0, 3, 5}) block.inverse_diagonal[i] = random.uniform(Real(0.5), 1);
      for (Real& value : block.coupling) value = random.uniform(Real(-0.4), Real(0.4));
    }
    for (Real& value : optimum) value = random.uniform(-1, 1);
  }
  QpSpans spans() { return {factor, optimum, solution, work, rows, multipliers, target, direction, gram}; }

  /// The neighbour of block k towards the middle; k itself at the middle.
  static std::size_t inner(std::size_t k) {
    constexpr std::size_t kMiddle = middle_block(kBlocks);
    return k < kMiddle ? k + 1 : k > kMiddle ? k - 1 : k;
  }

  /// P (x - x0) = U' D' D U (x - x0).
  [[nodiscard]] std::array<Real, kUnknowns> gradient(std::span<const Real> x) const {
    std::array<Real, kUnknowns> e{};
    for (std::size_t i = 0; i < kUnknowns; ++i) e[i] = x[i] - optimum[i];
    std::array<Real, kUnknowns> y = e;
    for (std::size_t k = 0; k < kBlocks; ++k) {  // U
      if (inner(k) == k) continue;
      for (std::size_t i = 0; i < 9; ++i) y[3 * k + i / 3] += factor[k].coupling[i] * e[3 * inner(k) + i % 3];
    }
    for (std::size_t k = 0; k < kBlocks; ++k) {  // D' D, by solving with the inverse twice
      const std::array<Real, 6>& d = factor[k].inverse_diagonal;
      Real* z = &y[3 * k];
      z[2] /= d[5];
      z[1] = (z[1] - d[4] * z[2]) / d[3];
      z[0] = (z[0] - d[1] * z[1] - d[2] * z[2]) / d[0];
      z[0] /= d[0];
      z[1] = (z[1] - d[1] * z[0]) / d[3];
      z[2] = (z[2] - d[2] * z[0] - d[4] * z[1]) / d[5];
    }
    std::array<Real, kUnknowns> g = y;
    for (std::size_t k = 0; k < kBlocks; ++k) {  // U'
      if (inner(k) == k) continue;
      for (std::size_t i = 0; i < 9; ++i) g[3 * inner(k) + i % 3] += factor[k].coupling[i] * y[3 * k + i / 3];
    }
    return g;
  }
};

QpRow random_row(test::Random& random) {
  QpRow row;
  row.block = static_cast<std::uint32_t>(random.below(kBlocks));
  const std::size_t entries = row.block + 1 < kBlocks ? 6 : 3;
  for (std::size_t i = 0; i < entries; ++i) row.coefficients[i] = random.uniform(-1, 1);
  row.bound = random.uniform(Real(-0.3), 1);
  return row;
}

enum class Next : std::uint8_t { kMostViolated, kFirstViolated };

/// Enforces a violated row until none is.
Status solve_all(DualActiveSet& solver, std::span<const QpRow> rows, Next next = Next::kMostViolated) {
  for (int step = 0; step < 500; ++step) {
    std::size_t chosen = rows.size();
    Real excess = kIsDouble ? Real(1e-10) : Real(1e-3);
    for (std::size_t j = 0; j < rows.size(); ++j) {
      const Real violation = row_value(rows[j], solver.solution()) - rows[j].bound;
      if (violation <= excess) continue;
      excess = violation;
      chosen = j;
      if (next == Next::kFirstViolated) break;
    }
    if (chosen == rows.size()) return Status::kOk;
    if (const Status status = solver.enforce(rows[chosen]); status != Status::kOk) return status;
  }
  return Status::kIterationLimit;
}

TEST(DualActiveSet, SolutionsMeetTheKktConditions) {
  int solved = 0;
  int constrained = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Fixture<kRows> fixture(seed);
    test::Random random(seed + 5000);
    std::array<QpRow, kRows> rows;
    for (QpRow& row : rows) row = random_row(random);
    DualActiveSet solver(fixture.spans(), kBlocks, 1000);
    const Status status = solve_all(solver, rows);
    if (status == Status::kInfeasible) continue;
    ASSERT_EQ(status, Status::kOk);
    ++solved;
    constrained += solver.active_count() > 0 ? 1 : 0;
    EXPECT_LE(solver.residual(), kIsDouble ? 1e-9 : 1e-3);
    std::array<Real, kUnknowns> residual = fixture.gradient(solver.solution());
    Real pull = 1;
    for (const Real multiplier : solver.multipliers()) pull = std::max(pull, multiplier);
    for (std::size_t j = 0; j < solver.active_count(); ++j) {
      const QpRow& row = solver.active_rows()[j];
      EXPECT_GE(solver.multipliers()[j], Real(0));
      EXPECT_NEAR(row_value(row, solver.solution()), row.bound, kIsDouble ? 1e-9 : 1e-3);
      const std::size_t first = kBlockSize * row.block;
      for (std::size_t i = 0; i < row.coefficients.size() && first + i < kUnknowns; ++i) {
        residual[first + i] += solver.multipliers()[j] * row.coefficients[i];
      }
    }
    for (const Real value : residual) EXPECT_NEAR(value / pull, 0, kIsDouble ? 1e-8 : 2e-2);
  }
  EXPECT_GT(solved, 150);
  EXPECT_GT(constrained, 100);
}

TEST(DualActiveSet, TheOrderOfTheRowsChangesNeitherTheStatusNorTheOptimum) {
  int infeasible = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Fixture<kRows> one(seed);
    Fixture<kRows> other(seed);
    test::Random random(seed + 5000);
    std::array<QpRow, kRows> rows;
    for (QpRow& row : rows) row = random_row(random);
    DualActiveSet worst_first(one.spans(), kBlocks, 1000);
    DualActiveSet in_turn(other.spans(), kBlocks, 1000);
    const Status status = solve_all(worst_first, rows);
    ASSERT_EQ(solve_all(in_turn, rows, Next::kFirstViolated), status);
    infeasible += status == Status::kInfeasible ? 1 : 0;
    for (std::size_t i = 0; status == Status::kOk && i < kUnknowns; ++i) {
      const Real size = std::max(Real(1), std::fabs(in_turn.solution()[i]));
      EXPECT_NEAR(worst_first.solution()[i] / size, in_turn.solution()[i] / size, kIsDouble ? 1e-8 : 2e-2);
    }
  }
  EXPECT_GT(infeasible, 5);
}

TEST(DualActiveSet, RowsThatContradictEachOtherAreInfeasible) {
  Fixture<4> fixture(1);
  DualActiveSet solver(fixture.spans(), kBlocks, 100);
  QpRow above;
  above.block = 1;
  above.coefficients[0] = 1;
  above.bound = -2;
  QpRow below = above;
  below.coefficients[0] = -1;
  below.bound = 1;  // x >= -1 against x <= -2
  EXPECT_EQ(solver.enforce(above), Status::kOk);
  EXPECT_EQ(solver.enforce(below), Status::kInfeasible);
}

TEST(DualActiveSet, ARowThatNoUnknownCanHelpIsInfeasible) {
  Fixture<4> fixture(2);
  DualActiveSet solver(fixture.spans(), kBlocks, 100);
  QpRow row;
  row.bound = -1;  // 0 <= -1
  EXPECT_EQ(solver.enforce(row), Status::kInfeasible);
}

TEST(DualActiveSet, AChainWithoutBlocksTouchesNoMemory) {
  std::array<QpRow, 2> rows{};
  std::array<Real, 2> of_rows{};
  std::array<Real, 3> gram{};
  DualActiveSet solver({{}, {}, {}, {}, rows, of_rows, of_rows, of_rows, gram}, 0, 100);
  QpRow row;
  row.bound = -1;
  EXPECT_EQ(solver.enforce(row), Status::kInfeasible);
}

TEST(DualActiveSet, ATighterParallelRowReplacesTheLooserOne) {
  Fixture<4> fixture(3);
  DualActiveSet solver(fixture.spans(), kBlocks, 100);
  QpRow row;
  row.coefficients[1] = 1;
  row.bound = fixture.optimum[1] - 1;
  EXPECT_EQ(solver.enforce(row), Status::kOk);
  row.bound -= 1;
  EXPECT_EQ(solver.enforce(row), Status::kOk);
  EXPECT_EQ(solver.active_count(), std::size_t{1});
  EXPECT_NEAR(solver.solution()[1], fixture.optimum[1] - 2, kIsDouble ? 1e-12 : 1e-5);
}

TEST(DualActiveSet, MergingTwoRowsKeepsTheOthersAndTheOptimality) {
  Fixture<6> fixture(8);
  DualActiveSet solver(fixture.spans(), kBlocks, 100);
  const auto row_at = [&](Real tilt) {
    QpRow row;
    row.block = 1;
    row.coefficients = {1, tilt, 0, 0, 0, 0};
    row.bound = fixture.optimum[3] + tilt * fixture.optimum[4] - 1;
    return row;
  };
  QpRow other;
  other.block = 3;
  other.coefficients[2] = -1;
  other.bound = -fixture.optimum[11] - 1;
  ASSERT_EQ(solver.enforce(row_at(Real(-0.3))), Status::kOk);
  ASSERT_EQ(solver.enforce(other), Status::kOk);
  ASSERT_EQ(solver.enforce(row_at(Real(0.9))), Status::kOk);
  ASSERT_EQ(solver.active_count(), std::size_t{3});
  ASSERT_EQ(solver.merge(0, 2, row_at(0)), Status::kOk);
  ASSERT_EQ(solver.active_count(), std::size_t{2});
  std::array<Real, kUnknowns> merged{};
  std::copy(solver.solution().begin(), solver.solution().end(), merged.begin());
  Fixture<6> fresh(8);
  DualActiveSet direct(fresh.spans(), kBlocks, 100);
  ASSERT_EQ(direct.enforce(other), Status::kOk);
  ASSERT_EQ(direct.enforce(row_at(0)), Status::kOk);
  for (std::size_t i = 0; i < kUnknowns; ++i) EXPECT_NEAR(merged[i], direct.solution()[i], kIsDouble ? 1e-10 : 1e-3);
}

TEST(DualActiveSet, StartingFromTheRowsOfAnEarlierSolveEndsWhereItEnded) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Fixture<kRows> cold(seed);
    test::Random random(seed + 5000);
    std::array<QpRow, kRows> rows;
    for (QpRow& row : rows) row = random_row(random);
    DualActiveSet first(cold.spans(), kBlocks, 1000);
    if (solve_all(first, rows) != Status::kOk) continue;
    Fixture<kRows> warm(seed);
    DualActiveSet second(warm.spans(), kBlocks, 1000);
    for (const QpRow& row : first.active_rows()) ASSERT_EQ(second.join(row), Status::kOk);
    ASSERT_EQ(second.move(), Status::kOk);
    ASSERT_EQ(solve_all(second, rows), Status::kOk);
    for (std::size_t i = 0; i < kUnknowns; ++i) {
      EXPECT_NEAR(second.solution()[i], first.solution()[i], kIsDouble ? 1e-8 : 2e-2);
    }
  }
}

TEST(DualActiveSet, FullCapacityAndSpentIterationsAreReportedNotOverrun) {
  Fixture<2> fixture(4);
  DualActiveSet solver(fixture.spans(), kBlocks, 100);
  const auto row_on = [&](std::size_t unknown) {
    QpRow row;
    row.block = static_cast<std::uint32_t>(unknown / 3);
    row.coefficients[unknown % 3] = 1;
    row.bound = fixture.optimum[unknown] - 1;
    return row;
  };
  EXPECT_EQ(solver.enforce(row_on(0)), Status::kOk);
  EXPECT_EQ(solver.enforce(row_on(11)), Status::kOk);
  EXPECT_EQ(solver.enforce(row_on(5)), Status::kIterationLimit);
  Fixture<2> other(5);
  DualActiveSet spent(other.spans(), kBlocks, 0);
  EXPECT_EQ(spent.enforce(row_on(0)), Status::kIterationLimit);
}

TEST(DualActiveSet, NotANumberIsNumericalTrouble) {
  Fixture<2> fixture(6);
  DualActiveSet solver(fixture.spans(), kBlocks, 100);
  QpRow row;
  row.coefficients[0] = std::numeric_limits<Real>::quiet_NaN();
  EXPECT_EQ(solver.enforce(row), Status::kNumericalTrouble);
}

}  // namespace
}  // namespace swiftlet
