#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "swiftlet/status.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// Strictly convex QP over a chain of K blocks of three unknowns,
///   minimise 1/2 (x - x0)' P (x - x0)   subject to   n_j' x <= b_j,
/// where P is block tridiagonal and each row touches one block or two neighbouring ones. Rows arrive one by one, as the
/// caller finds them violated; nothing here knows of flight.
inline constexpr std::size_t kBlockSize = 3;

/// Block k of the factor P = U' D' D U: U is unit block triangular from both ends of the chain towards its middle
/// block, with `coupling` (row-major) the block that multiplies the neighbour of x_k on the way there (none at the
/// middle); D is block diagonal and upper triangular, kept as its inverse (row-major: 00 01 02 11 12 22). In a
/// substitution only the couplings wait for each other, one 3 x 3 product a block, and the two halves run side by side.
struct FactorBlock {
  std::array<Real, 6> inverse_diagonal;
  std::array<Real, 9> coupling;
};

/// The block of a chain of `block_count` where both halves of the factor meet.
constexpr std::size_t middle_block(std::size_t block_count) { return block_count / 2; }

/// What the caller wants to find again in an active row; the solver only carries it.
struct QpLabel {
  std::uint32_t kind = 0;
  Real where = 0;
};

/// n' x <= bound; coefficients of blocks `block` and `block + 1` (zero where that block does not exist).
struct QpRow {
  std::array<Real, 2 * kBlockSize> coefficients{};
  Real bound = 0;
  std::uint32_t block = 0;
  QpLabel label;
};

/// Memory of one solve of up to K blocks and Q rows active at once.
struct QpSpans {
  std::span<FactorBlock> factor;  ///< K
  std::span<Real> optimum;        ///< 3 K: x0, the unconstrained optimum
  std::span<Real> solution;       ///< 3 K
  std::span<Real> work;           ///< 3 K
  std::span<QpRow> rows;          ///< Q
  std::span<Real> multipliers;    ///< Q
  std::span<Real> target;         ///< Q
  std::span<Real> direction;      ///< Q
  std::span<Real> gram_factor;    ///< Q (Q + 1) / 2
};

/// Dual active-set method (Goldfarb and Idnani) on the structure above. It starts at x0 with no active row and keeps
/// every multiplier non-negative; each enforced row strictly increases the dual objective. The Cholesky factor of
/// N' P^-1 N is updated, never rebuilt, and a row that the active ones nearly span gets its place in it from an
/// explicit remainder. Steps start from the rows' distances at the current point, so each corrects the rounding of
/// those before it. Cost of one row: two banded substitutions, O(K), and O(q^2) for q active rows.
class DualActiveSet {
 public:
  /// `spans.factor` and `spans.optimum` hold P and x0 for `block_count` blocks. At most `iteration_limit` rows are
  /// added or dropped in the life of this object.
  DualActiveSet(const QpSpans& spans, std::size_t block_count, std::uint32_t iteration_limit);

  /// Moves to the optimum of the active rows and `row`, dropping rows that no longer press. On an error the solution is
  /// the one from before. Errors:
  ///   kInfeasible        no step reduces the violation: `row` contradicts the active rows (a Farkas certificate)
  ///   kIterationLimit    the limit, or the capacity for active rows, is used up
  ///   kNumericalTrouble  a non-finite number came up
  Status enforce(const QpRow& row);

  /// The same, with `row` in place of two active rows, first < second, whose multipliers it inherits.
  Status merge(std::size_t first, std::size_t second, const QpRow& row);

  /// Several rows at once: `join` each, then `move`. A row that depends on the active ones, or for which there is no
  /// room, is left out, and `move` drops those that do not press; whatever is still violated can be enforced later.
  /// Errors as of enforce, but never kInfeasible.
  Status join(const QpRow& row);
  Status move();

  [[nodiscard]] std::span<const Real> solution() const { return spans_.solution.first(kBlockSize * block_count_); }
  [[nodiscard]] std::size_t active_count() const { return active_count_; }
  [[nodiscard]] std::span<const QpRow> active_rows() const { return spans_.rows.first(active_count_); }
  [[nodiscard]] std::span<const Real> multipliers() const { return spans_.multipliers.first(active_count_); }
  [[nodiscard]] std::uint32_t iterations() const { return iterations_; }
  /// (x - x0)' P (x - x0), twice what the active rows cost; it never falls from one enforced row to the next.
  [[nodiscard]] Real distance2() const;
  /// Largest distance of an active row from its bound: what rounding has left of the optimality conditions, the
  /// multipliers being non-negative and the gradient balanced by construction.
  [[nodiscard]] Real residual() const;

 private:
  Status append(const QpRow& row, Real weight);
  void push(const QpRow& row, Real multiplier);
  Status finish(Status appended);
  Status settle();
  Result<bool> row_is_independent(const QpRow& row);
  Real remainder_norm2(const QpRow& row, Real own);
  void subtract_combination(const QpRow& row);
  [[nodiscard]] std::size_t blocking_row(Real& step) const;
  void drop(std::size_t row);
  void move_from_optimum();
  void move_by_work();
  void solve_gram_lower(std::span<Real> rhs) const;
  void solve_gram_upper(std::span<Real> rhs) const;
  /// Blocks of a chain, the last one included.
  struct BlockRange {
    std::size_t first;
    std::size_t last;
  };
  [[nodiscard]] BlockRange blocks_of(const QpRow& row) const;
  void solve_hessian(std::span<Real> rhs, BlockRange given, BlockRange wanted) const;
  [[nodiscard]] Real inverse_norm2(std::span<Real> vector) const;

  QpSpans spans_;
  std::size_t block_count_;
  std::size_t active_count_ = 0;
  std::uint32_t iterations_ = 0;
  std::uint32_t iteration_limit_;
};

/// n' x of one row.
Real row_value(const QpRow& row, std::span<const Real> x);

}  // namespace swiftlet
