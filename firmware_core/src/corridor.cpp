#include "swiftlet/corridor.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/assert.hpp"
#include "swiftlet/window_relaxation.hpp"

namespace swiftlet {
namespace {

using Matrix3 = Eigen::Matrix<Real, 3, 3>;

// ----------------------------------------------------------------------------------------------------- the taut path

// A leg is smoothed over kSmoothing times the barrier's strength: the stiffer legs then stay curved long enough for the
// tensions to settle while the barrier shrinks. Measured on random chains: 4 takes half as many steps again, 1 stalls.
constexpr Real kSmoothing = 10;
constexpr Real kFirstBarrier = Real(0.1);  // of the mean leg
constexpr Real kShrink = Real(0.3);        // of the barrier after a good step
constexpr Real kToBoundary = Real(0.98);   // share of the way to a face that a step may take
constexpr Real kFirstInset = Real(0.1);    // of a gate's width, by which the first points stay off its faces

bool is_thin(const Box& gate, Eigen::Index axis) { return !(gate.lo[axis] < gate.hi[axis]); }

struct Leg {
  Leg(const Vector3& from, const Vector3& to, Real smoothing)
      : span(to - from), length(std::sqrt(span.squaredNorm() + smoothing * smoothing)), direction(span / length) {}

  /// Second derivative of the smoothed length, with one of its two directions replaced by the tension: far from the
  /// optimum this keeps a leg stiff that has to collapse or to turn.
  [[nodiscard]] Matrix3 stiffness(const Vector3& tension) const {
    Matrix3 h;
    for (Eigen::Index row = 0; row < 3; ++row) {
      for (Eigen::Index column = 0; column <= row; ++column) {
        const Real turn = (tension[row] * direction[column] + tension[column] * direction[row]) / 2;
        h(row, column) = h(column, row) = ((row == column ? 1 : 0) - turn) / length;
      }
    }
    return h;
  }

  Vector3 span;
  Real length;
  Vector3 direction;
};

/// Solves a x = b for a symmetric positive definite 3 x 3 matrix by its L D L^T factors; b is overwritten.
class Factor3 {
 public:
  explicit Factor3(const Matrix3& a) {
    d0_ = 1 / a(0, 0);
    l10_ = a(1, 0) * d0_;
    l20_ = a(2, 0) * d0_;
    d1_ = 1 / (a(1, 1) - l10_ * a(1, 0));
    const Real a21 = a(2, 1) - l20_ * a(1, 0);
    l21_ = a21 * d1_;
    d2_ = 1 / (a(2, 2) - l20_ * a(2, 0) - l21_ * a21);
  }
  template <typename Column>
  void solve(Column&& b) const {
    b[1] -= l10_ * b[0];
    b[2] -= l20_ * b[0] + l21_ * b[1];
    b[2] *= d2_;
    b[1] = b[1] * d1_ - l21_ * b[2];
    b[0] = b[0] * d0_ - l10_ * b[1] - l20_ * b[2];
  }

 private:
  Real d0_, d1_, d2_, l10_, l20_, l21_;
};

class TautPath {
 public:
  TautPath(std::span<const Box> gates, std::span<Vector3> points, std::span<TautNode> nodes)
      : gates_(gates), points_(points), nodes_(nodes), legs_(points.size() - 1) {}

  /// Forward and back through the gates, each point the nearest one to its neighbour: straight where that is possible.
  void lay() {
    for (std::size_t i = 1; i < legs_; ++i) points_[i] = nearest(gate(i), points_[i - 1]);
    for (std::size_t i = legs_ - 1; i > 0; --i) points_[i] = nearest(gate(i), (points_[i] + points_[i + 1]) / 2);
  }

  /// Moves the points off the faces and starts tensions and multipliers.
  void loosen(Real barrier) {
    barrier_ = barrier;
    for (std::size_t i = 1; i < legs_; ++i) {
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        if (is_thin(gate(i), axis)) continue;
        const Real lo = gate(i).lo[axis];
        const Real hi = gate(i).hi[axis];
        const Real inset = std::min(kFirstInset * (hi - lo), barrier_);
        Real& x = points_[i][axis];
        x = std::clamp(x, lo + inset, hi - inset);
        nodes_[i].push_lo[axis] = std::min(Real(1), barrier_ / (x - lo));
        nodes_[i].push_hi[axis] = std::min(Real(1), barrier_ / (hi - x));
      }
    }
    for (std::size_t i = 0; i < legs_; ++i) nodes_[i].tension = leg(i).direction;
  }

  [[nodiscard]] Real length() const {
    Real sum = 0;
    for (std::size_t i = 0; i < legs_; ++i) sum += (points_[i + 1] - points_[i]).norm();
    return sum;
  }

  /// For tensions u in the unit ball, |d| >= u.d on each leg; summed by parts, the least of the right-hand side over
  /// all points of the gates bounds the length of every polyline. Relative to the start, for the sake of digits.
  [[nodiscard]] Real lower_bound() const {
    const Vector3& start = points_[0];
    Real bound = nodes_[legs_ - 1].tension.dot(points_[legs_] - start);
    for (std::size_t i = 1; i < legs_; ++i) {
      const Vector3 pull = nodes_[i - 1].tension - nodes_[i].tension;
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const Real face = pull[axis] > 0 ? gate(i).lo[axis] : gate(i).hi[axis];
        bound += pull[axis] * (face - start[axis]);
      }
    }
    return bound;
  }

  /// One Newton step towards the central path; returns the shorter of the primal and the dual step length.
  Real advance() {
    eliminate();
    substitute();
    const StepLengths lengths = step_lengths();
    apply(lengths);
    return std::min(lengths.primal, lengths.dual);
  }

  /// Aims at a gap smaller than the present one; each leg and face contributes one barrier's worth to it.
  void set_barrier(Real gap, Real step_length) {
    const Real shrink = step_length > Real(0.9) ? kShrink : step_length > Real(0.5) ? 2 * kShrink : Real(1);
    barrier_ = std::min(barrier_, shrink * gap / static_cast<Real>(6 * legs_));
  }

 private:
  struct StepLengths {
    Real primal = 1;
    Real dual = 1;
  };

  /// Slack of a junction to the two faces of its gate on one axis, and the step of its multipliers.
  struct Faces {
    Faces(const Box& gate, const Vector3& point, const TautNode& node, Real barrier, Eigen::Index axis)
        : lo(point[axis] - gate.lo[axis]),
          hi(gate.hi[axis] - point[axis]),
          step(node.step[axis]),
          push_lo_step((barrier - node.push_lo[axis] * step) / lo - node.push_lo[axis]),
          push_hi_step((barrier + node.push_hi[axis] * step) / hi - node.push_hi[axis]) {}
    Real lo, hi, step, push_lo_step, push_hi_step;
  };

  [[nodiscard]] const Box& gate(std::size_t junction) const { return gates_[junction - 1]; }
  [[nodiscard]] Leg leg(std::size_t i) const { return {points_[i], points_[i + 1], kSmoothing * barrier_}; }
  [[nodiscard]] Faces faces(std::size_t i, Eigen::Index axis) const {
    return {gate(i), points_[i], nodes_[i], barrier_, axis};
  }
  static Vector3 nearest(const Box& gate, const Vector3& point) { return point.cwiseMax(gate.lo).cwiseMin(gate.hi); }

  /// Forward sweep of the block-tridiagonal system: step_i = nodes_i.step + nodes_i.carry * step_{i+1}.
  void eliminate() {
    Leg before = leg(0);
    Matrix3 stiffness_before = before.stiffness(nodes_[0].tension);
    for (std::size_t i = 1; i < legs_; ++i) {
      TautNode& node = nodes_[i];
      const Leg after = leg(i);
      const Matrix3 stiffness_after = after.stiffness(node.tension);
      Matrix3 a = stiffness_before + stiffness_after;
      node.step = after.direction - before.direction;
      node.carry = stiffness_after;
      if (i > 1) {
        a -= stiffness_before.lazyProduct(nodes_[i - 1].carry);
        node.step += stiffness_before.lazyProduct(nodes_[i - 1].step);
      }
      add_faces(i, a);
      const Factor3 factor(a);
      factor.solve(node.step);
      for (Eigen::Index column = 0; column < 3; ++column) factor.solve(node.carry.col(column));
      before = after;
      stiffness_before = stiffness_after;
    }
  }

  /// The barrier of the gate's faces; on a thin axis the junction does not move at all.
  void add_faces(std::size_t i, Matrix3& a) {
    TautNode& node = nodes_[i];
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (is_thin(gate(i), axis)) {
        a.row(axis).setZero();
        a.col(axis).setZero();
        a(axis, axis) = 1;
        node.step[axis] = 0;
        node.carry.row(axis).setZero();
        continue;
      }
      const Real lo = points_[i][axis] - gate(i).lo[axis];
      const Real hi = gate(i).hi[axis] - points_[i][axis];
      a(axis, axis) += node.push_lo[axis] / lo + node.push_hi[axis] / hi;
      node.step[axis] += barrier_ / lo - barrier_ / hi;
    }
  }

  void substitute() {
    nodes_[0].step.setZero();
    nodes_[legs_].step.setZero();
    for (std::size_t i = legs_ - 1; i > 0; --i) nodes_[i].step += nodes_[i].carry.lazyProduct(nodes_[i + 1].step);
  }

  [[nodiscard]] StepLengths step_lengths() const {
    StepLengths lengths;
    const auto limit = [](Real& length, Real value, Real step) {
      if (step < 0) length = std::min(length, -kToBoundary * value / step);
    };
    for (std::size_t i = 1; i < legs_; ++i) {
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        if (is_thin(gate(i), axis)) continue;
        const Faces at = faces(i, axis);
        limit(lengths.primal, at.lo, at.step);
        limit(lengths.primal, at.hi, -at.step);
        limit(lengths.dual, nodes_[i].push_lo[axis], at.push_lo_step);
        limit(lengths.dual, nodes_[i].push_hi[axis], at.push_hi_step);
      }
    }
    return lengths;
  }

  void apply(const StepLengths& lengths) {
    for (std::size_t i = 0; i < legs_; ++i) {
      Vector3& tension = nodes_[i].tension;
      const Leg here = leg(i);
      const Vector3 change = nodes_[i + 1].step - nodes_[i].step;
      const Vector3 turned = (change - tension * here.direction.dot(change)) / here.length;
      tension += lengths.dual * (here.direction - tension + turned);
      const Real norm = tension.norm();
      if (norm > 1) tension /= norm;
    }
    for (std::size_t i = 1; i < legs_; ++i) {
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        if (is_thin(gate(i), axis)) continue;
        const Faces at = faces(i, axis);
        nodes_[i].push_lo[axis] += lengths.dual * at.push_lo_step;
        nodes_[i].push_hi[axis] += lengths.dual * at.push_hi_step;
      }
    }
    for (std::size_t i = 1; i < legs_; ++i) points_[i] += lengths.primal * nodes_[i].step;
  }

  std::span<const Box> gates_;
  std::span<Vector3> points_;
  std::span<TautNode> nodes_;
  std::size_t legs_;
  Real barrier_ = 0;
};

// --------------------------------------------------------------------------------------------------------- the boxes

// Share of the path's length by which it may have to give way when boxes are dropped. Measured on four scans: a third
// fewer boxes than without slack, and paths 0.1 % longer at the median, 0.4 % at most.
constexpr Real kCoverSlack = Real(0.005);

/// The extents of all cells, or, when they are too many, from each on to the last one that shares a passage with it.
Status chain_extents(const BoxGraphView& graph, std::span<const CellIndex> cells, std::span<IntBox> boxes,
                     std::size_t& box_count) {
  const bool thin_out = cells.size() > boxes.size();
  std::size_t here = 0;
  boxes[0] = graph.extent(cells[0]);
  box_count = 1;
  while (here + 1 < cells.size()) {
    if (box_count == boxes.size()) return Status::kCorridorCapacity;
    std::size_t next = thin_out ? cells.size() - 1 : here + 1;
    IntBox box = graph.extent(cells[next]);
    while (next > here + 1 && !is_passage(intersection(boxes[box_count - 1], box))) box = graph.extent(cells[--next]);
    if (!(box == boxes[box_count - 1])) boxes[box_count++] = box;
    here = next;
  }
  return Status::kOk;
}

bool contains(const Box& box, const Vector3& point) {
  return (point.array() >= box.lo.array()).all() && (point.array() <= box.hi.array()).all();
}

/// Which share of the leg from `inside` to `outside` lies in the box.
Real share_inside(const Box& box, const Vector3& inside, const Vector3& outside) {
  Real share = 1;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Real step = outside[axis] - inside[axis];
    const Real room = (step > 0 ? box.hi : box.lo)[axis] - inside[axis];
    if (step != 0) share = std::min(share, room / step);
  }
  return std::max(share, Real(0));
}

/// The stretch of a polyline that lies in a box, leg and share of the leg: 2.25 is a quarter into the leg from point 2.
struct Stretch {
  Real begin;
  Real end;
};

/// As far as the path stays in `box` before and after leg `leg`, which lies in it.
Stretch stretch_inside(const Box& box, std::span<const Vector3> points, std::size_t leg) {
  std::size_t first = leg;
  while (first > 0 && contains(box, points[first - 1])) --first;
  std::size_t last = leg + 1;
  while (last + 1 < points.size() && contains(box, points[last + 1])) ++last;
  Stretch stretch{static_cast<Real>(first), static_cast<Real>(last)};
  if (first > 0) stretch.begin -= share_inside(box, points[first], points[first - 1]);
  if (last + 1 < points.size()) stretch.end += share_inside(box, points[last], points[last + 1]);
  return stretch;
}

/// Of a chain of boxes with leg i of `points` in box i, keeps in place those that cover the path going forward, each
/// time the one that reaches furthest of those that begin before the last one ends. Returns how many.
///   slack  [m] by which the path may pass outside a box that still counts as covering it
std::size_t cover_path(std::span<IntBox> int_boxes, std::span<const Box> boxes, std::span<const Vector3> points,
                       Real slack, std::span<TautNode> scratch) {
  const std::size_t count = int_boxes.size();
  const Real goal_leg = static_cast<Real>(count) - Real(0.5);
  for (std::size_t i = 0; i < count; ++i) {
    const Box wide{boxes[i].lo.array() - slack, boxes[i].hi.array() + slack};
    const Stretch stretch = stretch_inside(wide, points, i);
    // The last box has to hold the goal itself: slack does not count there.
    const Real end = contains(boxes[i], points[count]) ? stretch.end : std::min(stretch.end, goal_leg);
    scratch[i].step = {stretch.begin, end, 0};
  }
  std::size_t kept = 1;
  std::size_t here = 0;
  IntBox box = int_boxes[0];
  while (scratch[here].step[1] < static_cast<Real>(count)) {
    std::size_t next = here + 1;  // shares a passage, whatever the others do; the last box ends at `count`
    for (std::size_t i = here + 2; i < count; ++i) {
      const bool begins_in_time = scratch[i].step[0] < scratch[here].step[1];
      const bool reaches_further = scratch[i].step[1] > scratch[next].step[1];
      if (begins_in_time && reaches_further && is_passage(intersection(box, int_boxes[i]))) next = i;
    }
    here = next;
    box = int_boxes[here];  // not yet overwritten: kept <= here
    int_boxes[kept++] = box;
  }
  return kept;
}

/// Boxes and gates in frame W, and the taut path through them.
TautReport fit_path(const BoxGraphView& graph, const Vector3& start, const Vector3& goal, std::size_t count,
                    const CorridorSpans& spans) {
  for (std::size_t i = 0; i < count; ++i) spans.boxes[i] = graph.to_world(spans.int_boxes[i]);
  for (std::size_t i = 0; i + 1 < count; ++i) {
    spans.gates[i] = graph.to_world(intersection(spans.int_boxes[i], spans.int_boxes[i + 1]));
  }
  return pull_taut(start, goal, spans.gates.first(count - 1), spans.points, spans.nodes);
}

}  // namespace

Status build_corridor(const BoxGraphView& graph, const Vector3& start, const Vector3& goal,
                      std::span<const CellIndex> cells, CorridorKind kind, bool relax, const CorridorSpans& spans,
                      CorridorReport& report) {
  SWIFTLET_ASSERT(!cells.empty() && spans.boxes.size() >= spans.int_boxes.size() &&
                  spans.gates.size() + 1 >= spans.int_boxes.size() && spans.points.size() > spans.int_boxes.size() &&
                  spans.nodes.size() > spans.int_boxes.size());
  report = {};
  if (spans.int_boxes.empty()) return Status::kCorridorCapacity;
  std::size_t count = 0;
  if (kind == CorridorKind::kExtents) {
    const Status status = chain_extents(graph, cells, spans.int_boxes, count);
    if (status != Status::kOk) return status;
    const Real slack = kCoverSlack * fit_path(graph, start, goal, count, spans).length;
    count = cover_path(spans.int_boxes.first(count), spans.boxes, spans.points.first(count + 1), slack, spans.nodes);
  } else {
    if (spans.int_boxes.size() < cells.size()) return Status::kCorridorCapacity;
    for (const CellIndex cell : cells) spans.int_boxes[count++] = graph.cell(cell);
    if (relax) relax_windows(spans.int_boxes.first(count), {});
  }
  report.taut = fit_path(graph, start, goal, count, spans);
  report.box_count = count;
  return Status::kOk;
}

TautReport pull_taut(const Vector3& start, const Vector3& goal, std::span<const Box> gates, std::span<Vector3> points,
                     std::span<TautNode> nodes) {
  SWIFTLET_ASSERT(points.size() >= gates.size() + 2 && nodes.size() >= gates.size() + 2);
  const std::size_t point_count = gates.size() + 2;
  points[0] = start;
  points[point_count - 1] = goal;
  TautPath path(gates, points.first(point_count), nodes.first(point_count));
  path.lay();

  TautReport report{path.length(), (goal - start).norm(), 0};
  const auto is_proven = [&report] { return report.length - report.lower_bound <= kTautGap * report.length; };
  if (is_proven()) return report;
  path.loosen(kFirstBarrier * report.length / static_cast<Real>(point_count - 1));
  while (!is_proven() && report.steps < kTautSteps) {
    const Real step_length = path.advance();
    report.length = path.length();
    report.lower_bound = path.lower_bound();
    path.set_barrier(std::max(report.length - report.lower_bound, Real(0)), step_length);
    ++report.steps;
  }
  return report;
}

}  // namespace swiftlet
