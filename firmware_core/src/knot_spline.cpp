#include "swiftlet/knot_spline.hpp"

#include <cmath>

namespace swiftlet {
namespace {

using Vector = std::array<Real, kBlockSize>;
using Block = std::array<Vector, kBlockSize>;
using Triangle = std::array<Real, 6>;  // symmetric, 00 01 02 11 12 22

// A row whose own part is less than this share of its squared length, in the metric of the inverse cost, depends on
// those before it.
constexpr Real kDependentShare = sizeof(Real) == 8 ? Real(1e-10) : Real(1e-4);

Real dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vector multiply(const Block& m, const Vector& x) { return {dot(m[0], x), dot(m[1], x), dot(m[2], x)}; }

/// From which end of the chain the elimination comes.
enum class Side : std::uint8_t { kLeft, kRight };

/// Half the jerk cost of a span as a quadratic form in the states (p, v, a) of its outer and inner end: entries of
/// [outer-outer, outer-inner; ., inner-inner]. Reversing time turns the sign of the odd powers, of v, alone.
struct Stiffness {
  Stiffness(Real rate, Side side) {
    const Real rate2 = rate * rate;
    const Real sign = side == Side::kLeft ? Real(1) : Real(-1);
    aa = rate;
    va = sign * rate2;
    vv = rate2 * rate;
    pv = va * rate2;
    pp = rate2 * vv;
  }
  [[nodiscard]] Triangle outer() const { return {720 * pp, 360 * pv, 60 * vv, 192 * vv, 36 * va, 9 * aa}; }
  [[nodiscard]] Triangle inner() const { return {720 * pp, -360 * pv, 60 * vv, 192 * vv, -36 * va, 9 * aa}; }
  [[nodiscard]] Block outer_inner() const {
    return {{{-720 * pp, 360 * pv, -60 * vv}, {-360 * pv, 168 * vv, -24 * va}, {-60 * vv, 24 * va, -3 * aa}}};
  }
  Real pp, pv, vv, va, aa;
};

/// What the knots eliminated so far leave of the problem at the next one: minimise 1/2 x' S x - r' x.
struct Front {
  Triangle s{};
  Vector r{};
};

Real held_position(const Knot& knot) { return knot.held ? knot.position : Real(0); }

/// The front behind an end of the trajectory, whose state is a constant.
Front end_front(const Stiffness& k, const Vector& end, const Knot& inner) {
  const Real rise = held_position(inner) - end[0];
  return {k.inner(),
          {-720 * k.pp * rise + 360 * k.pv * end[1] + 60 * k.vv * end[2],
           360 * k.pv * rise - 168 * k.vv * end[1] - 24 * k.va * end[2],
           -60 * k.vv * rise + 24 * k.va * end[1] + 3 * k.aa * end[2]}};
}

/// Eliminates a held knot without rows on either side: two unknowns.
template <bool kInnerHeld>
inline void eliminate_held(const Stiffness& k, Real outer, Real inner, Front& front, KnotCoupling& coupling, Real* c) {
  const Real rise = inner - outer;
  const Real s11 = front.s[3] + 192 * k.vv;
  const Real s12 = front.s[4] + 36 * k.va;
  const Real s22 = front.s[5] + 9 * k.aa;
  const Real scale = 1 / (s11 * s22 - s12 * s12);
  const Real t11 = s22 * scale;
  const Real t12 = -s12 * scale;
  const Real t22 = s11 * scale;
  const Real b10 = -360 * k.pv;
  const Real b11 = 168 * k.vv;
  const Real b12 = -24 * k.va;
  const Real b20 = -60 * k.vv;
  const Real b21 = 24 * k.va;
  const Real b22 = -3 * k.aa;
  const Real r1 = front.r[1] - b10 * rise;
  const Real r2 = front.r[2] - b20 * rise;
  const Real e11 = t11 * b11 + t12 * b21;
  const Real e12 = t11 * b12 + t12 * b22;
  const Real e21 = t12 * b11 + t22 * b21;
  const Real e22 = t12 * b12 + t22 * b22;
  c[0] = outer;
  c[1] = t11 * r1 + t12 * r2;
  c[2] = t12 * r1 + t22 * r2;
  front.s[3] = 192 * k.vv - (b11 * e11 + b21 * e21);
  front.s[4] = -36 * k.va - (b11 * e12 + b21 * e22);
  front.s[5] = 9 * k.aa - (b12 * e12 + b22 * e22);
  front.r[1] = -b10 * rise - (b11 * c[1] + b21 * c[2]);
  front.r[2] = b20 * rise - (b12 * c[1] + b22 * c[2]);
  if constexpr (kInnerHeld) {
    coupling = {0, 0, 0, 0, e11, e12, 0, e21, e22};
  } else {
    const Real e10 = t11 * b10 + t12 * b20;
    const Real e20 = t12 * b10 + t22 * b20;
    coupling = {0, 0, 0, e10, e11, e12, e20, e21, e22};
    front.s[0] = 720 * k.pp - (b10 * e10 + b20 * e20);
    front.s[1] = -360 * k.pv - (b10 * e11 + b20 * e21);
    front.s[2] = 60 * k.vv - (b10 * e12 + b20 * e22);
    front.r[0] = -720 * k.pp * rise - (b10 * c[1] + b20 * c[2]);
  }
}

/// Inverse of S over the unknowns of a knot, zero for a held position. False when rounding has left S indefinite.
bool invert(const Triangle& s, bool held, Block& inverse) {
  const Real d0 = held ? Real(0) : 1 / s[0];
  const Real l01 = s[1] * d0;
  const Real l02 = s[2] * d0;
  const Real d1 = 1 / (s[3] - l01 * s[1]);
  const Real c12 = s[4] - l01 * s[2];
  const Real l12 = c12 * d1;
  const Real d2 = 1 / (s[5] - l02 * s[2] - l12 * c12);
  if (!(d0 >= 0 && d1 > 0 && d2 > 0)) return false;
  // S = L D L', X = L^-1: S^-1 = X' D^-1 X.
  const Real x02 = l01 * l12 - l02;
  const Real t22 = d2;
  const Real t12 = -l12 * d2;
  const Real t02 = x02 * d2;
  const Real t11 = d1 + l12 * l12 * d2;
  const Real t01 = -l01 * d1 - x02 * l12 * d2;
  const Real t00 = d0 + l01 * l01 * d1 + x02 * x02 * d2;
  inverse = {{{t00, t01, t02}, {t01, t11, t12}, {t02, t12, t22}}};
  return true;
}

using RowValues = std::array<Real, CarriedRows::kMost>;

/// L D^-1 L' = W + N T N' of the rows carried to a knot, L unit lower; n and b are L^-1 N T and L^-1 b.
struct RowFactor {
  std::array<RowValues, CarriedRows::kMost> l;
  RowValues d;
  std::array<Vector, CarriedRows::kMost> n;
  RowValues b;
};

/// False when the rows depend on each other.
bool factor_rows(const CarriedRows& rows, const Block& t, RowFactor& f) {
  for (std::size_t i = 0; i < rows.count; ++i) {
    const Vector y = multiply(t, rows.n[i]);
    const Real length2 = rows.w[i][i] + dot(rows.n[i], y);
    Real own = length2;
    f.n[i] = y;
    f.b[i] = rows.b[i];
    RowValues c;
    for (std::size_t j = 0; j < i; ++j) {
      c[j] = rows.w[i][j] + dot(rows.n[j], y);
      for (std::size_t k = 0; k < j; ++k) c[j] -= c[k] * f.l[j][k];
      f.l[i][j] = c[j] * f.d[j];
      own -= c[j] * f.l[i][j];
      for (std::size_t k = 0; k < kBlockSize; ++k) f.n[i][k] -= f.l[i][j] * f.n[j][k];
      f.b[i] -= f.l[i][j] * f.b[j];
    }
    if (!(own > kDependentShare * (rows.length2[i] + length2))) return false;
    f.d[i] = 1 / own;
  }
  return true;
}

/// x becomes L^-T x.
void solve_upper(const RowFactor& f, std::size_t count, RowValues& x) {
  for (std::size_t i = count; i-- > 0;) {
    for (std::size_t j = 0; j < i; ++j) x[j] -= f.l[i][j] * x[i];
  }
}

/// One knot on its way out: its problem 1/2 x' S x - r' x + x' B y, y the inner neighbour, with the rows carried to it.
struct Elimination {
  Block inverse;  // S^-1
  RowFactor rows;
  Block projected_inverse;  // the same where the carried rows hold
  Vector x;                 // optimum for y = 0

  bool run(const Triangle& s, const Vector& r, bool held, const CarriedRows& carried) {
    if (!invert(s, held, inverse) || !factor_rows(carried, inverse, rows)) return false;
    projected_inverse = inverse;
    for (std::size_t i = 0; i < carried.count; ++i) {
      const Vector& n = rows.n[i];
      for (std::size_t a = 0; a < kBlockSize; ++a) {
        const Real scaled = rows.d[i] * n[a];
        for (std::size_t b = 0; b < kBlockSize; ++b) projected_inverse[a][b] -= scaled * n[b];
      }
    }
    x = multiply(projected_inverse, r);
    for (std::size_t i = 0; i < carried.count; ++i) {
      const Real step = rows.d[i] * rows.b[i];
      for (std::size_t a = 0; a < kBlockSize; ++a) x[a] += step * rows.n[i][a];
    }
    return true;
  }
};

/// What the carried rows' multipliers take from a load `v` on the knot: L^-T D n v.
RowValues row_response(const Elimination& knot, std::size_t count, const Vector& v) {
  RowValues response;
  for (std::size_t i = 0; i < count; ++i) response[i] = knot.rows.d[i] * dot(knot.rows.n[i], v);
  solve_upper(knot.rows, count, response);
  return response;
}

/// Their multipliers for y = 0: L^-T D (n r - b).
RowValues row_multipliers(const Elimination& knot, std::size_t count, const Vector& r) {
  RowValues multipliers;
  for (std::size_t i = 0; i < count; ++i) {
    multipliers[i] = knot.rows.d[i] * (dot(knot.rows.n[i], r) - knot.rows.b[i]);
  }
  solve_upper(knot.rows, count, multipliers);
  return multipliers;
}

/// One half of the chain while it is eliminated, from its end inwards.
class HalfChain {
 public:
  HalfChain(const KnotSpline& spline, Side side)
      : spline_(spline), side_(side), carried_(spline.carried_rows[side == Side::kLeft ? 0 : 1]) {
    const std::size_t at = side == Side::kLeft ? 0 : spline.knots.size();
    const KnotSpan& span = spline.spans[at];
    const Knot& inner = spline.knots[side == Side::kLeft ? 0 : at - 1];
    const Vector& end = side == Side::kLeft ? spline.start : spline.goal;
    front_ = end_front(Stiffness(span.rate, side), end, inner);
    carried_.count = 0;
    for (std::size_t i = 0; i < span.row_count; ++i) {
      const KnotRow& row = spline.rows[span.first_row + i];
      carry(span.first_row + i, inner_part(row), row.bound - dot(outer_part(row), end), 0, inner);
      for (std::size_t j = 0; j <= i; ++j) carried_.w[i][j] = carried_.w[j][i] = 0;
    }
  }

  /// Takes out knot `outer`, across `span` from knot `inner`. False when rows depend on each other.
  bool eliminate(std::size_t outer, const KnotSpan& span, std::size_t inner) {
    const Stiffness stiffness(span.rate, side_);
    const Knot& from = spline_.knots[outer];
    const Knot& to = spline_.knots[inner];
    KnotCoupling& coupling = spline_.coupling[outer];
    Real* x = &spline_.states[kBlockSize * outer];
    if (carried_.count > 0 || span.row_count > 0 || !from.held) {
      return eliminate_with_rows(stiffness, outer, span, to);
    }
    if (to.held) {
      eliminate_held<true>(stiffness, from.position, to.position, front_, coupling, x);
    } else {
      eliminate_held<false>(stiffness, from.position, 0, front_, coupling, x);
    }
    return true;
  }

  /// Solves the knot where this half meets the other.
  bool meet(const HalfChain& other, std::size_t middle) {
    for (std::size_t i = 0; i < front_.s.size(); ++i) front_.s[i] += other.front_.s[i];
    for (std::size_t i = 0; i < kBlockSize; ++i) front_.r[i] += other.front_.r[i];
    const std::size_t own = carried_.count;
    for (std::size_t i = 0; i < other.carried_.count; ++i) {
      const std::size_t at = carried_.count++;
      carried_.row[at] = other.carried_.row[i];
      carried_.n[at] = other.carried_.n[i];
      carried_.b[at] = other.carried_.b[i];
      carried_.length2[at] = other.carried_.length2[i];
      for (std::size_t j = 0; j < own; ++j) carried_.w[at][j] = 0;
      for (std::size_t j = 0; j <= i; ++j) carried_.w[at][own + j] = other.carried_.w[i][j];
    }
    const Knot& knot = spline_.knots[middle];
    Real* x = &spline_.states[kBlockSize * middle];
    if (knot.held && carried_.count == 0) {
      const Real scale = 1 / (front_.s[3] * front_.s[5] - front_.s[4] * front_.s[4]);
      x[0] = knot.position;
      x[1] = scale * (front_.s[5] * front_.r[1] - front_.s[4] * front_.r[2]);
      x[2] = scale * (front_.s[3] * front_.r[2] - front_.s[4] * front_.r[1]);
      return true;
    }
    Elimination elimination;
    if (!elimination.run(front_.s, front_.r, knot.held, carried_)) return false;
    for (std::size_t i = 0; i < kBlockSize; ++i) x[i] = elimination.x[i];
    if (knot.held) x[0] = knot.position;
    const auto multipliers = row_multipliers(elimination, carried_.count, front_.r);
    for (std::size_t i = 0; i < carried_.count; ++i) spline_.rows[carried_.row[i]].multiplier = multipliers[i];
    return true;
  }

 private:
  [[nodiscard]] std::size_t outer_at() const { return side_ == Side::kLeft ? 0 : kBlockSize; }
  [[nodiscard]] Vector part(const KnotRow& row, std::size_t at) const {
    return {row.n[at], row.n[at + 1], row.n[at + 2]};
  }
  [[nodiscard]] Vector outer_part(const KnotRow& row) const { return part(row, outer_at()); }
  [[nodiscard]] Vector inner_part(const KnotRow& row) const { return part(row, kBlockSize - outer_at()); }

  void carry(std::size_t row, Vector n, Real b, Real length2, const Knot& to) {
    if (to.held) {
      b -= n[0] * to.position;
      n[0] = 0;
    }
    const std::size_t at = carried_.count++;
    carried_.row[at] = row;
    carried_.n[at] = n;
    carried_.b[at] = b;
    carried_.length2[at] = length2;
  }

  bool eliminate_with_rows(const Stiffness& k, std::size_t outer, const KnotSpan& span, const Knot& to) {
    const Knot& from = spline_.knots[outer];
    const Real rise = held_position(to) - held_position(from);
    Triangle s = k.outer();
    Block b = k.outer_inner();
    Vector r{front_.r[0] - b[0][0] * rise, front_.r[1] - b[1][0] * rise, front_.r[2] - b[2][0] * rise};
    for (std::size_t i = 0; i < s.size(); ++i) s[i] += front_.s[i];
    const Vector at_rise{b[0][0], -b[1][0], b[2][0]};  // of the inner state's rows, by the symmetry of time
    if (from.held) {
      b[0] = {};
      r[0] = 0;
    }
    if (to.held) b[0][0] = b[1][0] = b[2][0] = 0;
    Elimination knot;
    if (!knot.run(s, r, from.held, carried_)) return false;
    write_responses(knot, b, r);
    const Block e = couple(knot, b, outer);
    if (from.held) spline_.states[kBlockSize * outer] = from.position;
    front_.s = k.inner();
    front_.r = {at_rise[0] * rise, at_rise[1] * rise, at_rise[2] * rise};
    pass_on(knot, b, e);
    carry_over(knot, e, span, from, to);
    return true;
  }

  /// E = S^-1 B; x and E are kept for the way back.
  Block couple(const Elimination& knot, const Block& b, std::size_t outer) {
    Block e{};
    for (std::size_t i = 0; i < kBlockSize; ++i) {
      for (std::size_t j = 0; j < kBlockSize; ++j) {
        for (std::size_t m = 0; m < kBlockSize; ++m) e[i][j] += knot.projected_inverse[i][m] * b[m][j];
        spline_.coupling[outer][kBlockSize * i + j] = e[i][j];
      }
      spline_.states[kBlockSize * outer + i] = knot.x[i];
    }
    return e;
  }

  /// What the knot leaves of its span at the inner one: - B' E and - B' x.
  void pass_on(const Elimination& knot, const Block& b, const Block& e) {
    std::size_t entry = 0;
    for (std::size_t i = 0; i < kBlockSize; ++i) {
      for (std::size_t j = i; j < kBlockSize; ++j, ++entry) {
        for (std::size_t m = 0; m < kBlockSize; ++m) front_.s[entry] -= b[m][i] * e[m][j];
      }
      for (std::size_t m = 0; m < kBlockSize; ++m) front_.r[i] -= b[m][i] * knot.x[m];
    }
  }

  /// What the carried rows' multipliers will follow once the inner neighbour is known.
  void write_responses(const Elimination& knot, const Block& b, const Vector& r) {
    if (carried_.count == 0) return;
    const auto alone = row_multipliers(knot, carried_.count, r);
    for (std::size_t i = 0; i < carried_.count; ++i) spline_.rows[carried_.row[i]].multiplier_alone = alone[i];
    for (std::size_t j = 0; j < kBlockSize; ++j) {
      const auto by_state = row_response(knot, carried_.count, {b[0][j], b[1][j], b[2][j]});
      for (std::size_t i = 0; i < carried_.count; ++i) spline_.rows[carried_.row[i]].by_state[j] = by_state[i];
    }
  }

  /// The rows of the span, once the outer state is expressed by the inner one, take the place of those carried so far.
  void carry_over(const Elimination& knot, const Block& e, const KnotSpan& span, const Knot& from, const Knot& to) {
    const std::size_t before_count = carried_.count;
    const std::array<std::size_t, CarriedRows::kMost> before = carried_.row;
    carried_.count = 0;
    for (std::size_t i = 0; i < span.row_count; ++i) {
      KnotRow& row = spline_.rows[span.first_row + i];
      Vector outer = outer_part(row);
      Real b = row.bound;
      if (from.held) {
        b -= outer[0] * from.position;
        outer[0] = 0;
      }
      Vector n = inner_part(row);
      for (std::size_t j = 0; j < kBlockSize; ++j) {
        n[j] -= outer[0] * e[0][j] + outer[1] * e[1][j] + outer[2] * e[2][j];
      }
      row.follows = multiply(knot.projected_inverse, outer);
      const Real length2 = dot(outer, multiply(knot.inverse, outer));
      carry(span.first_row + i, n, b - dot(outer, knot.x), length2, to);
      for (std::size_t j = 0; j <= i; ++j) {
        carried_.w[i][j] = carried_.w[j][i] = dot(outer, spline_.rows[span.first_row + j].follows);
      }
      const auto by_row = row_response(knot, before_count, outer);
      for (std::size_t j = 0; j < before_count; ++j) spline_.rows[before[j]].by_row[i] = by_row[j];
    }
  }

  const KnotSpline& spline_;
  Side side_;
  CarriedRows& carried_;
  Front front_;
};

/// The way back: the state of a knot and the multipliers of the span on its outer side, the inner neighbour's state and
/// the multipliers of the span between them being known.
void settle_knot(const KnotSpline& spline, std::size_t outer, const KnotSpan& outside, const KnotSpan& between,
                 std::size_t inner) {
  Real* x = &spline.states[kBlockSize * outer];
  const Real* y = &spline.states[kBlockSize * inner];
  const KnotCoupling& e = spline.coupling[outer];
  for (std::size_t i = 0; i < kBlockSize; ++i) {
    x[i] -= e[3 * i] * y[0] + e[3 * i + 1] * y[1] + e[3 * i + 2] * y[2];
    for (const KnotRow& row : spline.rows.subspan(between.first_row, between.row_count)) {
      x[i] -= row.follows[i] * row.multiplier;
    }
  }
  for (KnotRow& row : spline.rows.subspan(outside.first_row, outside.row_count)) {
    row.multiplier = row.multiplier_alone - (row.by_state[0] * y[0] + row.by_state[1] * y[1] + row.by_state[2] * y[2]);
    for (std::size_t i = 0; i < between.row_count; ++i) {
      row.multiplier -= row.by_row[i] * spline.rows[between.first_row + i].multiplier;
    }
  }
}

}  // namespace

bool solve_knot_spline(const KnotSpline& spline) {
  const std::size_t count = spline.knots.size();
  if (count == 0) return spline.rows.empty();
  const std::size_t middle = middle_block(count);
  HalfChain left(spline, Side::kLeft);
  HalfChain right(spline, Side::kRight);
  // In step, so that a processor may work on both halves at once; the left one is never the shorter.
  for (std::size_t k = 0; k < middle; ++k) {
    if (!left.eliminate(k, spline.spans[k + 1], k + 1)) return false;
    const std::size_t r = count - 1 - k;
    if (r > middle && !right.eliminate(r, spline.spans[r], r - 1)) return false;
  }
  if (!left.meet(right, middle)) return false;
  for (std::size_t distance = 1; distance <= middle; ++distance) {
    const std::size_t l = middle - distance;
    settle_knot(spline, l, spline.spans[l], spline.spans[l + 1], l + 1);
    const std::size_t r = middle + distance;
    if (r < count) settle_knot(spline, r, spline.spans[r + 1], spline.spans[r], r - 1);
  }
  return true;
}

}  // namespace swiftlet
