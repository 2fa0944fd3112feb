#include "swiftlet/dual_active_set.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace swiftlet {
namespace {

// Below this share of its squared length (in the metric of P^-1) the part of a new row that the active ones do not span
// is computed explicitly: the difference of squares has lost half its digits.
constexpr Real kCancellingShare = sizeof(Real) == 8 ? Real(1e-8) : Real(1e-3);
// Rounding of that part, relative to the row and to what is subtracted from it; a row with no more is dependent.
constexpr Real kRemainderNoise = std::numeric_limits<Real>::epsilon() * 64;

constexpr std::size_t packed(std::size_t row, std::size_t column) { return row * (row + 1) / 2 + column; }

std::size_t entries(const QpRow& row, std::size_t unknowns) {
  return std::min<std::size_t>(row.coefficients.size(), unknowns - kBlockSize * row.block);
}

/// x += factor * n
void add_row(const QpRow& row, Real factor, std::span<Real> x) {
  const std::size_t first = kBlockSize * row.block;
  for (std::size_t i = 0; i < entries(row, x.size()); ++i) x[first + i] += factor * row.coefficients[i];
}

Real square(Real x) { return x * x; }

void rotate(Real c, Real s, Real& left, Real& right) {
  const Real turned = c * left + s * right;
  right = c * right - s * left;
  left = turned;
}

/// D^-T x.
inline std::array<Real, kBlockSize> apply_inverse(const std::array<Real, 6>& d, const Real* x) {
  return {d[0] * x[0], d[1] * x[0] + d[3] * x[1], d[2] * x[0] + d[4] * x[1] + d[5] * x[2]};
}

/// x becomes D^-1 D^-T x.
inline void apply_inverse_square(const std::array<Real, 6>& d, Real* x) {
  const std::array<Real, kBlockSize> y = apply_inverse(d, x);
  x[0] = d[0] * y[0] + d[1] * y[1] + d[2] * y[2];
  x[1] = d[3] * y[1] + d[4] * y[2];
  x[2] = d[5] * y[2];
}

/// One step of U^-T, from block `x` to its inner neighbour.
inline void push_inwards(const std::array<Real, 9>& e, const Real* x, Real* inner) {
  // Grouped for the shortest chain of operations from x to inner.
  for (std::size_t j = 0; j < kBlockSize; ++j) {
    inner[j] = (inner[j] - e[j] * x[0]) - (e[3 + j] * x[1] + e[6 + j] * x[2]);
  }
}

/// One step of U^-1, from the inner neighbour to block `x`.
inline void pull_outwards(const std::array<Real, 9>& e, Real* x, const Real* inner) {
  for (std::size_t i = 0; i < kBlockSize; ++i) {
    x[i] = (x[i] - e[3 * i] * inner[0]) - (e[3 * i + 1] * inner[1] + e[3 * i + 2] * inner[2]);
  }
}

}  // namespace

Real row_value(const QpRow& row, std::span<const Real> x) {
  const std::size_t first = kBlockSize * row.block;
  Real value = 0;
  for (std::size_t i = 0; i < entries(row, x.size()); ++i) value += row.coefficients[i] * x[first + i];
  return value;
}

DualActiveSet::DualActiveSet(const QpSpans& spans, std::size_t block_count, std::uint32_t iteration_limit)
    : spans_(spans), block_count_(block_count), iteration_limit_(iteration_limit) {
  const std::size_t unknowns = kBlockSize * block_count;
  spans_.optimum = spans_.optimum.first(unknowns);
  spans_.solution = spans_.solution.first(unknowns);
  spans_.work = spans_.work.first(unknowns);
  std::copy(spans_.optimum.begin(), spans_.optimum.end(), spans_.solution.begin());
}

Real DualActiveSet::distance2() const {
  Real sum = 0;
  for (std::size_t j = 0; j < active_count_; ++j) {
    sum += spans_.multipliers[j] * (row_value(spans_.rows[j], spans_.optimum) - spans_.rows[j].bound);
  }
  return sum;
}

Real DualActiveSet::residual() const {
  Real largest = 0;
  for (const QpRow& row : active_rows()) largest = std::max(largest, std::fabs(row_value(row, solution()) - row.bound));
  return largest;
}

Status DualActiveSet::enforce(const QpRow& row) { return finish(append(row, 0)); }

Status DualActiveSet::merge(std::size_t first, std::size_t second, const QpRow& row) {
  const Real weight = spans_.multipliers[first] + spans_.multipliers[second];
  drop(second);
  drop(first);
  const Status status = append(row, weight);
  if (status == Status::kOk) move_from_optimum();
  return finish(status);
}

Status DualActiveSet::finish(Status status) {
  if (status == Status::kOk) status = settle();
  if (status == Status::kOk) move_by_work();
  return status;
}

Status DualActiveSet::join(const QpRow& row) {
  if (active_count_ == spans_.rows.size()) return Status::kOk;
  if (++iterations_ > iteration_limit_) return Status::kIterationLimit;
  const Result<bool> independent = row_is_independent(row);
  if (!independent.ok()) return independent.status();
  if (*independent) push(row, 0);
  return Status::kOk;
}

Status DualActiveSet::move() { return finish(Status::kOk); }

void DualActiveSet::push(const QpRow& row, Real multiplier) {
  spans_.rows[active_count_] = row;
  spans_.multipliers[active_count_++] = multiplier;
}

/// Makes `row` active with a multiplier of at least `weight`. While it depends on the active rows, weight moves from
/// them to it until one of them lets go; when none can, the rows contradict each other.
Status DualActiveSet::append(const QpRow& row, Real weight) {
  while (true) {
    if (active_count_ == spans_.rows.size() || ++iterations_ > iteration_limit_) return Status::kIterationLimit;
    const Result<bool> independent = row_is_independent(row);
    if (!independent.ok()) return independent.status();
    if (*independent) break;
    Real step = 0;
    const std::size_t blocking = blocking_row(step);
    if (blocking == active_count_) return Status::kInfeasible;
    for (std::size_t j = 0; j < active_count_; ++j) spans_.multipliers[j] -= step * spans_.direction[j];
    weight += step;
    drop(blocking);
  }
  push(row, weight);
  return Status::kOk;
}

/// Computes the new row of the Gram factor behind the active ones. Of a dependent row, leaves the combination of active
/// rows that it is in `direction`.
Result<bool> DualActiveSet::row_is_independent(const QpRow& row) {
  const BlockRange own_blocks = blocks_of(row);
  BlockRange wanted = own_blocks;
  for (const QpRow& active : active_rows()) {
    const BlockRange blocks = blocks_of(active);
    wanted = {std::min(wanted.first, blocks.first), std::max(wanted.last, blocks.last)};
  }
  std::fill(spans_.work.begin(), spans_.work.end(), Real(0));
  add_row(row, 1, spans_.work);
  solve_hessian(spans_.work, own_blocks, wanted);
  const Real own = row_value(row, spans_.work);
  for (std::size_t j = 0; j < active_count_; ++j) spans_.target[j] = row_value(spans_.rows[j], spans_.work);
  solve_gram_lower(spans_.target);
  Real rest = own;
  for (std::size_t j = 0; j < active_count_; ++j) rest -= spans_.target[j] * spans_.target[j];
  if (!std::isfinite(rest)) return Status::kNumericalTrouble;
  if (rest <= kCancellingShare * own) rest = remainder_norm2(row, own);
  if (!(rest > 0)) return false;
  Real* last = &spans_.gram_factor[packed(active_count_, 0)];
  for (std::size_t j = 0; j < active_count_; ++j) last[j] = spans_.target[j];
  last[active_count_] = std::sqrt(rest);
  return true;
}

/// Squared length of the part of a row that the active ones do not span, n - N r, made explicit and once corrected; 0
/// when it is no more than rounding. Corrects L^-1 N' P^-1 n in `target`, leaves r in `direction`.
Real DualActiveSet::remainder_norm2(const QpRow& row, Real own) {
  const BlockRange all{0, block_count_ - 1};
  subtract_combination(row);
  solve_hessian(spans_.work, all, all);
  const std::span<Real> correction = spans_.direction;
  for (std::size_t j = 0; j < active_count_; ++j) correction[j] = row_value(spans_.rows[j], spans_.work);
  solve_gram_lower(correction);
  for (std::size_t j = 0; j < active_count_; ++j) spans_.target[j] += correction[j];
  subtract_combination(row);
  Real scale2 = own;
  for (std::size_t j = 0; j < active_count_; ++j) {
    Real length2 = 0;
    for (std::size_t k = 0; k <= j; ++k) length2 += square(spans_.gram_factor[packed(j, k)]);
    scale2 += square(spans_.direction[j]) * length2;
  }
  const Real rest = inverse_norm2(spans_.work);
  return rest > square(kRemainderNoise) * scale2 ? rest : Real(0);
}

/// direction = r = L^-T target, work = n - N r.
void DualActiveSet::subtract_combination(const QpRow& row) {
  const std::span<Real> direction = spans_.direction;
  std::copy_n(spans_.target.begin(), active_count_, direction.begin());
  solve_gram_upper(direction);
  std::fill(spans_.work.begin(), spans_.work.end(), Real(0));
  add_row(row, 1, spans_.work);
  for (std::size_t j = 0; j < active_count_; ++j) add_row(spans_.rows[j], -direction[j], spans_.work);
}

/// The active row whose multiplier reaches zero first along -direction, and the step there; active_count_ for none.
std::size_t DualActiveSet::blocking_row(Real& step) const {
  std::size_t blocking = active_count_;
  for (std::size_t j = 0; j < active_count_; ++j) {
    if (!(spans_.direction[j] > 0)) continue;
    const Real limit = spans_.multipliers[j] / spans_.direction[j];
    if (blocking == active_count_ || limit < step) {
      step = limit;
      blocking = j;
    }
  }
  return blocking;
}

/// Moves the multipliers to the optimum of the active rows taken as equalities; a row whose multiplier would turn
/// negative on the way is dropped and the optimum is sought again. Leaves N times the change of multipliers in `work`.
Status DualActiveSet::settle() {
  const std::span<Real> direction = spans_.direction;
  std::fill(spans_.work.begin(), spans_.work.end(), Real(0));
  for (std::size_t j = 0; j < active_count_; ++j) {
    spans_.target[j] = row_value(spans_.rows[j], spans_.solution) - spans_.rows[j].bound;
  }
  solve_gram_lower(spans_.target);
  while (true) {
    std::copy_n(spans_.target.begin(), active_count_, direction.begin());
    solve_gram_upper(direction);
    Real step = 1;
    std::size_t blocking = active_count_;
    for (std::size_t j = 0; j < active_count_; ++j) {
      if (!std::isfinite(direction[j])) return Status::kNumericalTrouble;
      if (direction[j] >= -spans_.multipliers[j]) continue;
      const Real limit = spans_.multipliers[j] / -direction[j];
      // Among rows that block at once, the one that pulls hardest.
      if (blocking == active_count_ || limit < step || (limit == step && direction[j] < direction[blocking])) {
        step = limit;
        blocking = j;
      }
    }
    for (std::size_t j = 0; j < active_count_; ++j) {
      const Real change = step * direction[j];
      spans_.multipliers[j] += change;
      add_row(spans_.rows[j], change, spans_.work);
    }
    if (blocking == active_count_) return Status::kOk;
    if (++iterations_ > iteration_limit_) return Status::kIterationLimit;
    for (std::size_t j = 0; j < active_count_; ++j) spans_.target[j] *= 1 - step;
    drop(blocking);
  }
}

/// x = x0 - P^-1 N u.
void DualActiveSet::move_from_optimum() {
  std::fill(spans_.work.begin(), spans_.work.end(), Real(0));
  for (std::size_t j = 0; j < active_count_; ++j) add_row(spans_.rows[j], spans_.multipliers[j], spans_.work);
  std::copy(spans_.optimum.begin(), spans_.optimum.end(), spans_.solution.begin());
  move_by_work();
}

/// x -= P^-1 work.
void DualActiveSet::move_by_work() {
  const BlockRange all{0, block_count_ - 1};
  solve_hessian(spans_.work, all, all);
  for (std::size_t i = 0; i < spans_.work.size(); ++i) spans_.solution[i] -= spans_.work[i];
}

/// Removes an active row; Givens rotations of neighbouring columns restore the triangle below it, and turn `target`
/// with them.
void DualActiveSet::drop(std::size_t row) {
  const std::span<Real> L = spans_.gram_factor;
  for (std::size_t k = row; k + 1 < active_count_; ++k) {
    const Real a = L[packed(k + 1, k)];
    const Real b = L[packed(k + 1, k + 1)];
    const Real r = std::sqrt(a * a + b * b);
    const Real c = a / r;
    const Real s = b / r;
    L[packed(k + 1, k)] = r;
    rotate(c, s, spans_.target[k], spans_.target[k + 1]);
    for (std::size_t i = k + 2; i < active_count_; ++i) rotate(c, s, L[packed(i, k)], L[packed(i, k + 1)]);
  }
  for (std::size_t k = row; k + 1 < active_count_; ++k) {
    for (std::size_t j = 0; j <= k; ++j) L[packed(k, j)] = L[packed(k + 1, j)];
    spans_.rows[k] = spans_.rows[k + 1];
    spans_.multipliers[k] = spans_.multipliers[k + 1];
  }
  --active_count_;
}

void DualActiveSet::solve_gram_lower(std::span<Real> rhs) const {
  for (std::size_t i = 0; i < active_count_; ++i) {
    const Real* row = &spans_.gram_factor[packed(i, 0)];
    Real sum = rhs[i];
    for (std::size_t j = 0; j < i; ++j) sum -= row[j] * rhs[j];
    rhs[i] = sum / row[i];
  }
}

void DualActiveSet::solve_gram_upper(std::span<Real> rhs) const {
  for (std::size_t i = active_count_; i-- > 0;) {
    const Real* row = &spans_.gram_factor[packed(i, 0)];
    rhs[i] /= row[i];
    for (std::size_t j = 0; j < i; ++j) rhs[j] -= row[j] * rhs[i];
  }
}

DualActiveSet::BlockRange DualActiveSet::blocks_of(const QpRow& row) const {
  return {row.block, std::min<std::size_t>(row.block + 1, block_count_ - 1)};
}

/// rhs becomes P^-1 rhs in the blocks wanted; only the blocks given are not zero on entry. Inwards from both ends, then
/// outwards from the middle; the two halves do not wait for each other.
void DualActiveSet::solve_hessian(std::span<Real> rhs, BlockRange given, BlockRange wanted) const {
  if (block_count_ == 0) return;
  const std::span<const FactorBlock> factor = spans_.factor;
  const std::size_t middle = middle_block(block_count_);
  const auto block = [&](std::size_t k) { return &rhs[kBlockSize * k]; };
  const auto leave = [&](std::size_t k, std::size_t inner) {
    push_inwards(factor[k].coupling, block(k), block(inner));
    apply_inverse_square(factor[k].inverse_diagonal, block(k));
  };
  std::size_t left = std::min(given.first, middle);
  std::size_t right = std::max(given.last, middle);
  while (left < middle || right > middle) {
    if (left < middle) {
      leave(left, left + 1);
      ++left;
    }
    if (right > middle) {
      leave(right, right - 1);
      --right;
    }
  }
  apply_inverse_square(factor[middle].inverse_diagonal, block(middle));
  while (left > wanted.first || right < wanted.last) {
    if (left > wanted.first) {
      --left;
      pull_outwards(factor[left].coupling, block(left), block(left + 1));
    }
    if (right < wanted.last) {
      ++right;
      pull_outwards(factor[right].coupling, block(right), block(right - 1));
    }
  }
}

/// v' P^-1 v as a sum of squares; destroys v.
Real DualActiveSet::inverse_norm2(std::span<Real> vector) const {
  const std::size_t middle = middle_block(block_count_);
  const auto block = [&](std::size_t k) { return &vector[kBlockSize * k]; };
  for (std::size_t k = 0; k < middle; ++k) push_inwards(spans_.factor[k].coupling, block(k), block(k + 1));
  for (std::size_t k = block_count_; k-- > middle + 1;) {
    push_inwards(spans_.factor[k].coupling, block(k), block(k - 1));
  }
  Real norm2 = 0;
  for (std::size_t k = 0; k < block_count_; ++k) {
    for (const Real y : apply_inverse(spans_.factor[k].inverse_diagonal, block(k))) norm2 += y * y;
  }
  return norm2;
}

}  // namespace swiftlet
