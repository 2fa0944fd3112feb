#include "swiftlet/blocked_space.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

bool overlap(const IntBox& a, const IntBox& b) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (a.lo[axis] >= b.hi[axis] || b.lo[axis] >= a.hi[axis]) return false;
  }
  return true;
}

std::uint64_t volume(const IntBox& box) {
  std::uint64_t product = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) product *= static_cast<std::uint64_t>(box.hi[axis] - box.lo[axis]);
  return product;
}

bool is_proper(const Box& box) {
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (!(box.lo[axis] <= box.hi[axis] && std::isfinite(box.lo[axis]) && std::isfinite(box.hi[axis]))) return false;
  }
  return true;
}

/// Smallest box around a piece of a segment: the Bernstein points of its Taylor polynomial.
Box hull_of(const Segment& segment, Real t, Real h) {
  constexpr std::array<std::array<Real, 6>, 6> kShares{{{1, 0, 0, 0, 0, 0},
                                                        {1, Real(1) / 5, 0, 0, 0, 0},
                                                        {1, Real(2) / 5, Real(1) / 10, 0, 0, 0},
                                                        {1, Real(3) / 5, Real(3) / 10, Real(1) / 10, 0, 0},
                                                        {1, Real(4) / 5, Real(6) / 10, Real(4) / 10, Real(1) / 5, 0},
                                                        {1, 1, 1, 1, 1, 1}}};
  const Sample at = sample_segment(segment, t);
  Box hull{at.position, at.position};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<Eigen::Index>(axis);
    const std::array<Real, kQuinticTerms>& c = segment.coefficients[axis];
    const Real h2 = h * h;
    const std::array<Real, 6> q{at.position[row],
                                at.velocity[row] * h,
                                at.acceleration[row] * h2 / 2,
                                at.jerk[row] * h2 * h / 6,
                                (5 * c[5] * t + c[4]) * h2 * h2,
                                c[5] * h2 * h2 * h};
    for (const std::array<Real, 6>& shares : kShares) {
      Real point = 0;
      for (std::size_t j = 0; j < q.size(); ++j) point += shares[j] * q[j];
      hull.lo[row] = std::min(hull.lo[row], point);
      hull.hi[row] = std::max(hull.hi[row], point);
    }
  }
  return hull;
}

// What the certificate allows a trajectory to be outside its boxes [m].
constexpr Real kTolerance = sizeof(Real) == 8 ? Real(1e-6) : Real(1e-3);
constexpr std::size_t kDepth = 12;  // bisections: the hulls of the last pieces are as good as the tolerance

/// False for a hull that is no number.
bool apart(const Box& a, const Box& b) {
  return (a.lo.array() >= b.hi.array()).any() || (a.hi.array() <= b.lo.array()).any();
}

/// False only when the segment is proven to stay out of the box from local time `first` on.
bool enters(const Segment& segment, Real first, const Box& box) {
  struct Piece {
    Real t;
    Real h;
    std::size_t depth;
  };
  std::array<Piece, kDepth + 2> stack{};
  stack[0] = {first, segment.duration - first, 0};
  std::size_t count = 1;
  while (count > 0) {
    const Piece piece = stack[--count];
    if (apart(hull_of(segment, piece.t, piece.h), box)) continue;
    if (piece.depth == kDepth) return true;
    const Real half = piece.h / 2;
    stack[count++] = {piece.t + half, half, piece.depth + 1};
    stack[count++] = {piece.t, half, piece.depth + 1};
  }
  return false;
}

}  // namespace

/// Outward to whole units, clipped to the map; what lies off the map becomes a box without volume.
IntBox BlockedSpace::inflated(const Box& obstacle) const {
  const BlobHeader& header = map_.header();
  IntBox box{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<Eigen::Index>(axis);
    const double size = header.size[axis];
    const double lo = (static_cast<double>(obstacle.lo[row]) - header.radius - header.origin[axis]) / map_.unit();
    const double hi = (static_cast<double>(obstacle.hi[row]) + header.radius - header.origin[axis]) / map_.unit();
    box.lo[axis] = static_cast<std::uint16_t>(std::clamp(std::floor(lo), 0.0, size));
    box.hi[axis] = static_cast<std::uint16_t>(std::clamp(std::ceil(hi), 0.0, size));
  }
  return box;
}

Status BlockedSpace::add(std::uint32_t id, const Box& obstacle) {
  if (!is_proper(obstacle)) return Status::kBadRequest;
  std::size_t index = 0;
  while (index < box_count_ && spans_.boxes[index].id != id) ++index;
  const bool is_new = index == box_count_;
  if (is_new && box_count_ == spans_.boxes.size()) return Status::kBufferTooSmall;
  const BlockedBox before = spans_.boxes[index];
  spans_.boxes[index] = {id, inflated(obstacle)};
  box_count_ += is_new ? 1 : 0;
  if (rebuild()) return Status::kOk;
  box_count_ -= is_new ? 1 : 0;
  spans_.boxes[index] = before;
  (void)rebuild();  // fitted before
  return Status::kBufferTooSmall;
}

bool BlockedSpace::remove(std::uint32_t id) {
  std::size_t index = 0;
  while (index < box_count_ && spans_.boxes[index].id != id) ++index;
  if (index == box_count_) return false;
  for (; index + 1 < box_count_; ++index) spans_.boxes[index] = spans_.boxes[index + 1];
  --box_count_;
  // Fewer obstacles cut no more cells, but may leave more pieces; a cell whose pieces do not fit stays blocked whole.
  (void)rebuild();
  return true;
}

bool BlockedSpace::rebuild() {
  piece_count_ = 0;
  if (!collect_cells()) return false;
  for (CutCell& cell : spans_.cells.first(cut_count_)) {
    if (!cut_cell(cell)) return false;
  }
  return true;
}

/// The cells that meet a blocked box, ascending.
bool BlockedSpace::collect_cells() {
  cut_count_ = 0;
  for (const BlockedBox& blocked : boxes()) {
    const std::size_t found = map_.cells_in(blocked.box, spans_.found);
    if (found > spans_.found.size()) return false;
    for (const CellIndex cell : spans_.found.first(found)) {
      const auto value = static_cast<std::uint32_t>(cell);
      std::size_t at = cut_count_;
      while (at > 0 && spans_.cells[at - 1].cell >= value) --at;
      if (at < cut_count_ && spans_.cells[at].cell == value) continue;
      if (cut_count_ == spans_.cells.size()) return false;
      for (std::size_t k = cut_count_++; k > at; --k) spans_.cells[k] = spans_.cells[k - 1];
      spans_.cells[at] = {value, 0, 0};
    }
  }
  return true;
}

/// Appends what the blocked boxes leave of a cell.
bool BlockedSpace::cut_cell(CutCell& cell) {
  if (piece_count_ == spans_.pieces.size()) return false;
  cell.first = static_cast<std::uint32_t>(piece_count_);
  spans_.pieces[piece_count_++] = {map_.cell(static_cast<CellIndex>(cell.cell)), cell.cell};
  for (const BlockedBox& blocked : boxes()) {
    for (std::size_t k = cell.first; k < piece_count_;) {
      if (!overlap(spans_.pieces[k].box, blocked.box)) {
        ++k;
      } else if (!cut_piece(k, blocked.box)) {
        return false;
      }
    }
  }
  cell.count = static_cast<std::uint32_t>(piece_count_) - cell.first;
  return true;
}

/// Replaces a piece by up to six boxes around the hole; the last piece takes its place.
bool BlockedSpace::cut_piece(std::size_t index, const IntBox& hole) {
  CutPiece rest = spans_.pieces[index];
  spans_.pieces[index] = spans_.pieces[--piece_count_];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const bool below : {true, false}) {
      CutPiece slab = rest;
      (below ? slab.box.hi : slab.box.lo)[axis] = below ? hole.lo[axis] : hole.hi[axis];
      const bool is_left = below ? hole.lo[axis] > rest.box.lo[axis] : hole.hi[axis] < rest.box.hi[axis];
      if (!is_left) continue;
      if (piece_count_ == spans_.pieces.size()) return false;
      spans_.pieces[piece_count_++] = slab;
      (below ? rest.box.lo : rest.box.hi)[axis] = below ? hole.lo[axis] : hole.hi[axis];
    }
  }
  return true;
}

const CutCell* BlockedSpace::cut(CellIndex cell) const {
  const auto value = static_cast<std::uint32_t>(cell);
  const std::span<const CutCell> cells = spans_.cells.first(cut_count_);
  const auto at =
      std::lower_bound(cells.begin(), cells.end(), value, [](const CutCell& a, std::uint32_t b) { return a.cell < b; });
  return at != cells.end() && at->cell == value ? &*at : nullptr;
}

IntBox BlockedSpace::cut_back(IntBox extent, const IntBox& keep) const {
  for (const BlockedBox& blocked : boxes()) {
    if (!overlap(extent, blocked.box)) continue;
    IntBox best = keep;
    std::uint64_t best_volume = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      IntBox above = extent;
      above.lo[axis] = blocked.box.hi[axis];
      IntBox below = extent;
      below.hi[axis] = blocked.box.lo[axis];
      for (const IntBox& part : {above, below}) {
        if (!contains(part, keep) || volume(part) <= best_volume) continue;
        best = part;
        best_volume = volume(part);
      }
    }
    extent = best;
  }
  return extent;
}

bool BlockedSpace::meets(const IntBox& box) const {
  for (const BlockedBox& blocked : boxes()) {
    if (overlap(box, blocked.box)) return true;
  }
  return false;
}

bool BlockedSpace::meets(std::span<const Segment> segments, Real from) const {
  for (const Segment& segment : segments) {
    const Real first = std::max(from, Real(0));
    from -= segment.duration;
    if (!(first < segment.duration)) continue;
    for (const BlockedBox& blocked : boxes()) {
      if (!overlap(blocked.box, blocked.box)) continue;  // off the map
      Box box = map_.to_world(blocked.box);
      box.lo.array() += kTolerance;
      box.hi.array() -= kTolerance;
      if (enters(segment, first, box)) return true;
    }
  }
  return false;
}

}  // namespace swiftlet
