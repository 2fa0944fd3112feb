#include "swiftlet/dual_active_set.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace swiftlet {
namespace {

// A new row counts as a combination of the active ones when less than this share of its squared length (in the metric
// of P^-1) is its own.
constexpr Real kDependentShare = std::numeric_limits<Real>::epsilon() * 512;

constexpr std::size_t packed(std::size_t row, std::size_t column) { return row * (row + 1) / 2 + column; }

std::size_t entries(const QpRow& row, std::size_t unknowns) {
  return std::min<std::size_t>(row.coefficients.size(), unknowns - kBlockSize * row.block);
}

/// x += factor * n
void add_row(const QpRow& row, Real factor, std::span<Real> x) {
  const std::size_t first = kBlockSize * row.block;
  for (std::size_t i = 0; i < entries(row, x.size()); ++i) x[first + i] += factor * row.coefficients[i];
}

/// x becomes D^-1 D^-T x.
inline void apply_inverse_square(const std::array<Real, 6>& d, Real* x) {
  const Real y0 = d[0] * x[0];
  const Real y1 = d[1] * x[0] + d[3] * x[1];
  const Real y2 = d[2] * x[0] + d[4] * x[1] + d[5] * x[2];
  x[0] = d[0] * y0 + d[1] * y1 + d[2] * y2;
  x[1] = d[3] * y1 + d[4] * y2;
  x[2] = d[5] * y2;
}

/// One step of U^-T, from block `x` to its inner neighbour, and of D^-1 D^-T on x, which is done then.
inline void push_inwards(const FactorBlock& block, Real* x, Real* inner) {
  const std::array<Real, 9>& e = block.coupling;
  // Grouped for the shortest chain of operations from x to inner.
  for (std::size_t j = 0; j < kBlockSize; ++j) {
    inner[j] = (inner[j] - e[j] * x[0]) - (e[3 + j] * x[1] + e[6 + j] * x[2]);
  }
  apply_inverse_square(block.inverse_diagonal, x);
}

/// One step of U^-1, from the inner neighbour to block `x`.
inline void pull_outwards(const FactorBlock& block, Real* x, const Real* inner) {
  const std::array<Real, 9>& e = block.coupling;
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
  return finish(append(row, weight));
}

Status DualActiveSet::finish(Status status) {
  if (status == Status::kOk) status = settle();
  if (status == Status::kOk) update_solution();
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
  const std::span<Real> direction = spans_.target;
  while (true) {
    if (active_count_ == spans_.rows.size() || ++iterations_ > iteration_limit_) return Status::kIterationLimit;
    const Result<bool> independent = row_is_independent(row);
    if (!independent.ok()) return independent.status();
    if (*independent) break;
    solve_gram_upper(direction);
    Real step = 0;
    const std::size_t blocking = blocking_row(direction, step);
    if (blocking == active_count_) return Status::kInfeasible;
    for (std::size_t j = 0; j < active_count_; ++j) spans_.multipliers[j] -= step * direction[j];
    weight += step;
    drop(blocking);
  }
  push(row, weight);
  return Status::kOk;
}

/// Computes the new row of the Gram factor behind the active ones, and leaves L^-1 N' P^-1 n in `target`.
Result<bool> DualActiveSet::row_is_independent(const QpRow& row) {
  std::fill(spans_.work.begin(), spans_.work.end(), Real(0));
  add_row(row, 1, spans_.work);
  solve_hessian(spans_.work, row.block, std::min<std::size_t>(row.block + 1, block_count_ - 1));
  const Real own = row_value(row, spans_.work);
  for (std::size_t j = 0; j < active_count_; ++j) spans_.target[j] = row_value(spans_.rows[j], spans_.work);
  solve_gram_lower(spans_.target);
  Real rest = own;
  for (std::size_t j = 0; j < active_count_; ++j) {
    spans_.gram_factor[packed(active_count_, j)] = spans_.target[j];
    rest -= spans_.target[j] * spans_.target[j];
  }
  if (!std::isfinite(rest)) return Status::kNumericalTrouble;
  if (rest <= kDependentShare * own) return false;
  spans_.gram_factor[packed(active_count_, active_count_)] = std::sqrt(rest);
  return true;
}

/// The active row whose multiplier reaches zero first along -direction, and the step there; active_count_ for none.
std::size_t DualActiveSet::blocking_row(std::span<const Real> direction, Real& step) const {
  std::size_t blocking = active_count_;
  for (std::size_t j = 0; j < active_count_; ++j) {
    if (!(direction[j] > 0)) continue;
    const Real limit = spans_.multipliers[j] / direction[j];
    if (blocking == active_count_ || limit < step) {
      step = limit;
      blocking = j;
    }
  }
  return blocking;
}

/// Moves the multipliers to the optimum of the active rows taken as equalities; a row whose multiplier would turn
/// negative on the way is dropped and the optimum is sought again.
Status DualActiveSet::settle() {
  while (true) {
    const std::span<Real> target = spans_.target;
    for (std::size_t j = 0; j < active_count_; ++j) {
      target[j] = row_value(spans_.rows[j], spans_.optimum) - spans_.rows[j].bound;
    }
    solve_gram_lower(target);
    solve_gram_upper(target);
    Real step = 1;
    std::size_t blocking = active_count_;
    for (std::size_t j = 0; j < active_count_; ++j) {
      if (!std::isfinite(target[j])) return Status::kNumericalTrouble;
      if (target[j] >= 0) continue;
      const Real limit = spans_.multipliers[j] / (spans_.multipliers[j] - target[j]);
      // Among rows that block at once, the one that pulls hardest.
      if (blocking == active_count_ || limit < step || (limit == step && target[j] < target[blocking])) {
        step = limit;
        blocking = j;
      }
    }
    for (std::size_t j = 0; j < active_count_; ++j) {
      spans_.multipliers[j] += step * (target[j] - spans_.multipliers[j]);
    }
    if (blocking == active_count_) return Status::kOk;
    if (++iterations_ > iteration_limit_) return Status::kIterationLimit;
    drop(blocking);
  }
}

/// x = x0 - P^-1 N u.
void DualActiveSet::update_solution() {
  std::fill(spans_.work.begin(), spans_.work.end(), Real(0));
  for (std::size_t j = 0; j < active_count_; ++j) add_row(spans_.rows[j], spans_.multipliers[j], spans_.work);
  solve_hessian(spans_.work, 0, block_count_ - 1);
  for (std::size_t i = 0; i < spans_.work.size(); ++i) spans_.solution[i] = spans_.optimum[i] - spans_.work[i];
}

/// Removes an active row; Givens rotations of neighbouring columns restore the triangle below it.
void DualActiveSet::drop(std::size_t row) {
  const std::span<Real> L = spans_.gram_factor;
  for (std::size_t k = row; k + 1 < active_count_; ++k) {
    const Real a = L[packed(k + 1, k)];
    const Real b = L[packed(k + 1, k + 1)];
    const Real r = std::sqrt(a * a + b * b);
    const Real c = a / r;
    const Real s = b / r;
    L[packed(k + 1, k)] = r;
    for (std::size_t i = k + 2; i < active_count_; ++i) {
      const Real left = L[packed(i, k)];
      const Real right = L[packed(i, k + 1)];
      L[packed(i, k)] = c * left + s * right;
      L[packed(i, k + 1)] = c * right - s * left;
    }
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

/// rhs becomes P^-1 rhs; only blocks `first` to `last` of rhs are not zero on entry. Inwards from both ends, then
/// outwards from the middle; the two halves do not wait for each other.
void DualActiveSet::solve_hessian(std::span<Real> rhs, std::size_t first, std::size_t last) const {
  const std::span<const FactorBlock> factor = spans_.factor;
  const std::size_t middle = middle_block(block_count_);
  const auto block = [&](std::size_t k) { return &rhs[kBlockSize * k]; };
  std::size_t left = std::min(first, middle);
  std::size_t right = std::max(last, middle);
  while (left < middle || right > middle) {
    if (left < middle) {
      push_inwards(factor[left], block(left), block(left + 1));
      ++left;
    }
    if (right > middle) {
      push_inwards(factor[right], block(right), block(right - 1));
      --right;
    }
  }
  apply_inverse_square(factor[middle].inverse_diagonal, block(middle));
  for (std::size_t distance = 1; distance <= middle; ++distance) {  // the left half is never the shorter one
    const std::size_t k = middle - distance;
    pull_outwards(factor[k], block(k), block(k + 1));
    if (middle + distance < block_count_) {
      pull_outwards(factor[middle + distance], block(middle + distance), block(middle + distance - 1));
    }
  }
}

}  // namespace swiftlet
