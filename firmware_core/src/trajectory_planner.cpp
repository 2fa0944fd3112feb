#include "swiftlet/trajectory_planner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "swiftlet/stop_at_gates.hpp"
#include "swiftlet/time_allocation.hpp"

namespace swiftlet {
namespace {

// No segment starts shorter than this share of the mean: where the taut path touches two gates in one point its profile
// gives no time at all, and the cost grows with T^-5.
constexpr Real kShortestShare = Real(0.05);
constexpr Real kShortestDuration = Real(1e-3);  // [s]
constexpr Real kShortestFirst = Real(1e-6);     // [s] of a segment whose gate is right ahead of the motion
constexpr Real kHair = 1 + Real(sizeof(Real) == 8 ? 1e-6 : 1e-4);  // later than full speed would be there
// Longest leg without a knot, in units of the way to the speed limit and back.
constexpr Real kLongestLeg = 2;
constexpr Real kStretchStep = Real(1.25);
constexpr int kStretchSteps = 20;
// Stretches tried from motion. Feasibility is not monotone in time there: too slow a segment overshoots.
constexpr std::array<Real, 8> kMovingStretches{1, Real(1.25), Real(0.8), Real(1.6), 2, Real(0.6), 3, 5};
// Continuation from looser limits, see tighten_limits.
constexpr std::size_t kKnottedLegs = 4;
constexpr Real kLoosest = 40;
/// With what weight of time (share of the usual one) limits are tightened, from what stretch of the profile, and
/// whether with more knots.
struct Tightening {
  Real weight;
  Real stretch;
  bool knots;
};
constexpr std::array<Tightening, 10> kWays{{{Real(0.001), 1, false},
                                            {Real(0.1), 1, false},
                                            {1, 1, false},
                                            {Real(0.001), Real(1.5), false},
                                            {Real(0.001), 1, true},
                                            {Real(0.1), 1, true},
                                            {Real(0.001), Real(1.5), true},
                                            {Real(0.01), Real(0.75), true},
                                            {Real(0.01), Real(2.5), true},
                                            {Real(0.02), 1, true}}};
// The last way without more knots and the first with them are tried from scattered durations as well: of 29 starts of
// 60,000 that the ways alone lose, all but one are found within 40 of each.
constexpr std::size_t kFirstScattered = 3;
constexpr std::size_t kLastScattered = 4;
constexpr std::size_t kScatters = 40;
constexpr std::size_t kMostHeld = 2;
// A Kronecker sequence fills the unit cube evenly; its steps are the inverse powers of the root of x^5 = x + 1.
constexpr std::array<Real, 4> kScatterSteps{Real(0.8566749), Real(0.7338919), Real(0.6287067), Real(0.5385973)};
constexpr int kTightenings = 24;
constexpr Real kTighteningGain = Real(1e-3);
constexpr Real kTighteningStep = Real(1.5);
constexpr std::uint64_t kTighteningTrials = 24;
// Jerk cost that a second is worth, in units of a^3 over the path's length: more flies faster, less smoother. Free of
// the speed limit, so that raising that limit does not change what is sought.
constexpr Real kTimeWeight = 70;
constexpr Real kShortestLength = Real(0.01);  // [m] in that unit
// Of a step of the refinement, for each segment, for another one to follow: a step's work grows with them.
constexpr Real kLeastGain = Real(9e-5);
constexpr int kSlowDowns = 4;
// No ramp is asked to be shorter than this share of the mean leg, nor of the way where it has few legs: much steeper
// ones gain next to no time, and a search that trades smoothness for them stops anywhere.
constexpr Real kRampOfLeg = Real(0.4);
constexpr Real kRampOfWay = Real(0.05);
// The first allocation takes no leg for faster than its length lets it become, in units of sqrt(a times its length):
// a speed limit out of reach then changes nothing.
constexpr Real kReachedSpeed = Real(0.8367);  // sqrt(0.7)

bool is_at_rest(const State& state) { return state.velocity.isZero(0) && state.acceleration.isZero(0); }

Real sum(std::span<const Real> values) {
  Real total = 0;
  for (const Real value : values) total += value;
  return total;
}

/// Per-axis limits that keep the bound of a norm by themselves and leave room for the value that a start already has.
Vector3 split_norm(const DerivativeBound& bound, const Vector3& start) {
  const Real inside = 1 - Real(sizeof(Real) == 8 ? 1e-9 : 1e-5);
  const Real spare = std::max(bound.norm * bound.norm - start.squaredNorm(), Real(0)) / 3;
  Vector3 limits;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    limits[axis] = std::min(bound.axis, inside * std::sqrt(start[axis] * start[axis] + spare));
  }
  return limits;
}

/// When a motion from `v` [m/s] at constant `a` [m/s^2] has come `distance` [m] far; infinity where it never does.
Real time_to(Real distance, Real v, Real a) {
  const Real square = v * v + 2 * a * distance;
  if (square < 0 || (v == 0 && !(a > 0))) return kUnlimited;
  return 2 * distance / (v + std::sqrt(square));
}

/// Why a solve that ended with `status` left the plan to its fallback.
FallbackReason reason_for_fallback(Status status) {
  switch (status) {
    case Status::kIterationLimit:
      return FallbackReason::kIterations;
    case Status::kInfeasible:
      return FallbackReason::kStopAtGates;
    default:
      return FallbackReason::kNumerics;  // kOk: solved, but its certificate did not pass
  }
}

}  // namespace

const FittedTrajectory& TrajectoryPlanner::fit(const KnottedCorridor& corridor, std::size_t count,
                                               const TrajectoryRequest& request) {
  fitted_ = {};
  fitted_.box_count = count;
  corridor_ = corridor;
  request_ = request;
  brake_count_ = 0;
  spans_.refinement.warm.count = {};
  if (!is_usable(request.limits)) return fitted_;
  bounds_ = motion_bounds(request.limits);
  const bool from_rest = is_from_rest();
  fitted_.qp_v_max = from_rest ? Vector3::Constant(bounds_.v.axis) : split_norm(bounds_.v, request.start.velocity);
  fitted_.qp_a_max = from_rest ? Vector3::Constant(bounds_.a.axis) : split_norm(bounds_.a, request.start.acceleration);
  if (!ends_keep_limits()) {
    fitted_.status = Status::kInfeasible;
    return fitted_;
  }
  find_ramps();
  if (from_rest) keep_ramps();
  add_knots();
  // The answer that always exists, before anything that could run out (design: section 6).
  if (from_rest) {
    stop_at_every_gate();
  } else {
    plan_braking();
  }
  const Status status = optimise();
  fitted_.status = status == Status::kOk ? status : fall_back(status);
  return fitted_;
}

bool TrajectoryPlanner::is_from_rest() const { return is_at_rest(request_.start) && is_at_rest(request_.goal); }

std::uint64_t TrajectoryPlanner::work_left() const {
  const std::uint64_t deadline = request_.budget.deadline;
  return deadline > fitted_.report.work ? deadline - fitted_.report.work : 0;
}

TrajectoryProblem TrajectoryPlanner::problem(const SolveEffort& effort) const {
  TrajectoryProblem posed{corridor_.boxes.first(count()),
                          corridor_.gates.first(count() - 1),
                          durations(),
                          request_.start,
                          request_.goal,
                          fitted_.qp_v_max,
                          fitted_.qp_a_max,
                          Margins{},
                          effort};
  // What is left for each of the three axes.
  const std::uint64_t steps = work_left() / (3 * count());
  if (steps < posed.effort.most_steps) posed.effort.most_steps = static_cast<std::uint32_t>(steps);
  return posed;
}

Real TrajectoryPlanner::path_length() const {
  Real length = 0;
  for (std::size_t i = 0; i < count(); ++i) length += (corridor_.points[i + 1] - corridor_.points[i]).norm();
  return length;
}

/// Jerk cost that a second is worth [m^2/s^6].
Real TrajectoryPlanner::time_weight() const {
  const Real a = std::min(fitted_.qp_a_max.maxCoeff(), ramp_acceleration_);
  return kTimeWeight * a * a * a / std::max(path_length(), kShortestLength);
}

/// A start or goal state beyond a limit is no matter of times.
bool TrajectoryPlanner::ends_keep_limits() {
  for (const State* end : {&request_.start, &request_.goal}) {
    const auto check = [&](const Vector3& value, const DerivativeBound& bound, BoundKind kind) {
      Eigen::Index axis = 0;
      const Real largest = value.cwiseAbs().maxCoeff(&axis);
      const Real excess = std::max(largest - bound.axis, value.norm() - bound.norm);
      if (excess <= kFeasibility) return true;
      fitted_.report.blocking = {end == &request_.start ? 0 : static_cast<std::uint32_t>(count() - 1),
                                 static_cast<std::uint8_t>(axis), kind, excess, 0};
      return false;
    };
    if (!check(end->velocity, bounds_.v, BoundKind::kVelocity)) return false;
    if (!check(end->acceleration, bounds_.a, BoundKind::kAcceleration)) return false;
  }
  return true;
}

/// The acceleration with which the speed limit is reached over a way that is short against the legs. Free of the limit
/// of acceleration, so that raising that scales the same plan.
void TrajectoryPlanner::find_ramps() {
  const Real length = path_length();
  const Real shortest = std::min(kRampOfLeg * length / static_cast<Real>(count()), kRampOfWay * length);  // [m]
  ramp_acceleration_ = bounds_.v.axis * bounds_.v.axis / std::max(shortest, std::numeric_limits<Real>::min());
}

/// From rest nothing needs a harder one.
void TrajectoryPlanner::keep_ramps() {
  if (ramp_acceleration_ >= bounds_.a.axis) return;
  bounds_.a.axis = ramp_acceleration_;
  fitted_.qp_a_max = Vector3::Constant(bounds_.a.axis);
}

/// Interior knots where one quintic would be too stiff for its leg.
void TrajectoryPlanner::add_knots() {
  longest_leg_ = 0;
  for (std::size_t i = 0; i < count(); ++i) {
    longest_leg_ = std::max(longest_leg_, (corridor_.points[i + 1] - corridor_.points[i]).norm());
  }
  const Real ramps = fitted_.qp_v_max[0] * fitted_.qp_v_max[0] / fitted_.qp_a_max[0];  // [m] to the limit and back
  fitted_.box_count = insert_knots(corridor_, count(), kLongestLeg * ramps);
}

void TrajectoryPlanner::plan_braking() {
  const Real j_max = std::min(bounds_.j.axis, bounds_.j.norm * Real(0.57735));
  braking_ = brake_within(corridor_.boxes[0], request_.start, fitted_.qp_v_max, fitted_.qp_a_max, j_max);
}

/// Repeats the first box for the pieces of the braking.
bool TrajectoryPlanner::add_braking() {
  const std::size_t pieces = braking_.count;
  if (pieces == 0 || !repeat_first_box(corridor_, count(), pieces)) return false;
  for (std::size_t i = 0; i < pieces; ++i) {
    corridor_.points[i + 1] = sample_segment(braking_.pieces[i], braking_.pieces[i].duration).position;
  }
  fitted_.box_count += pieces;
  brake_count_ = pieces;
  spans_.refinement.warm.count = {};
  return true;
}

/// The braking, if any, then straight legs from gate to gate; one that passes knots is split at them, from the back so
/// that nothing is overwritten.
void TrajectoryPlanner::stop_at_every_gate() {
  const std::span<const IntBox> boxes = corridor_.int_boxes.first(count());
  std::size_t legs = 0;
  spans_.stop_points[0] = corridor_.points[brake_count_];
  for (std::size_t i = brake_count_; i < count(); ++i) {
    if (i + 1 < count() && is_knot(boxes, i)) continue;
    spans_.stop_points[++legs] = corridor_.points[i + 1];
  }
  const std::span<Segment> segments = spans_.segments.subspan(brake_count_);
  stop_at_gates(spans_.stop_points.first(legs + 1), bounds_, segments);
  for (std::size_t end = count(); end > brake_count_;) {
    std::size_t first = end - 1;
    while (first > brake_count_ && is_knot(boxes, first - 1)) --first;
    split_segment(segments[--legs], spans_.segments.subspan(first, end - first));
    end = first;
  }
  std::copy_n(braking_.pieces.begin(), brake_count_, spans_.segments.begin());
  for (std::size_t i = 0; i < count(); ++i) spans_.stop_durations[i] = spans_.segments[i].duration;
}

/// Segment durations along the taut path; junctions that coincide get a share of the mean.
Status TrajectoryPlanner::allocate_profile() {
  const std::span<Real> profile = spans_.profile.first(count());
  const std::span<const Vector3> points = corridor_.points.first(count() + 1);
  SpeedLimits limits{fitted_.qp_v_max.minCoeff(), fitted_.qp_a_max.minCoeff()};
  const Real reached = kReachedSpeed * std::sqrt(limits.a_max * longest_leg_);
  if (is_from_rest() && reached > 0) limits.v_max = std::min(limits.v_max, reached);
  std::size_t far = 1;
  while (far + 1 < points.size() && (points[far] - points[0]).isZero(0)) ++far;
  const Vector3 leg = points[far] - points[0];
  const Real length = leg.norm();
  const Real along = length > 0 ? request_.start.velocity.dot(leg) / length : Real(0);
  const Status status = allocate_durations(points, limits, profile, std::clamp(along, Real(0), limits.v_max));
  if (status != Status::kOk) return status;
  const Real shortest = std::max(kShortestShare * sum(profile) / static_cast<Real>(count()), kShortestDuration);
  for (Real& duration : profile) duration = std::max(duration, shortest);
  // From motion the first gate may be close ahead.
  if (!is_at_rest(request_.start)) fit_first_box(profile);
  return Status::kOk;
}

/// From motion the first gate may be so near that the time to it is all but given: when it is reached at the start's
/// own acceleration, and by when the box is left however hard the vehicle brakes.
void TrajectoryPlanner::fit_first_box(std::span<Real> times) const {
  std::size_t inside = 1;
  while (inside < times.size() && is_knot(corridor_.int_boxes, inside - 1)) ++inside;
  const Box& box = corridor_.boxes[0];
  const Box& gate = inside < times.size() ? corridor_.gates[inside - 1] : box;
  Real arrival = 0;
  Real latest = kUnlimited;
  Real stopping = 0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Real direction = request_.start.velocity[axis] < 0 ? Real(-1) : Real(1);
    const Real p = request_.start.position[axis];
    const Real v = std::fabs(request_.start.velocity[axis]);
    const Real a = direction * request_.start.acceleration[axis];
    const Real ahead = direction > 0 ? gate.lo[axis] - p : p - gate.hi[axis];
    const Real behind = direction > 0 ? p - gate.hi[axis] : gate.lo[axis] - p;
    if (ahead > 0) arrival = std::max({arrival, time_to(ahead, v, a), kHair * ahead / fitted_.qp_v_max[axis]});
    if (behind > 0) arrival = kUnlimited;
    const Real room = (direction > 0 ? box.hi[axis] - p : p - box.lo[axis]) + kFeasibility;
    latest = std::min(latest, time_to(room, v, -fitted_.qp_a_max[axis]));
    stopping = std::max(stopping, v / fitted_.qp_a_max[axis]);
  }
  const std::span<Real> first = times.first(inside);
  const Real total = sum(first);
  const Real wanted = std::min(arrival > 0 && arrival < stopping / 2 ? arrival : total, latest);
  for (Real& time : first) time = std::max(time * wanted / total, kShortestFirst);
}

/// A rough solve with the durations as they stand, which tells whether they can be flown.
Status TrajectoryPlanner::try_durations() {
  if (work_left() == 0) return Status::kIterationLimit;
  const std::uint64_t work = fitted_.report.work;
  const std::uint32_t iterations = fitted_.report.qp_iterations;
  const Status status =
      generate_trajectory(problem(kTrialEffort), spans_.trajectory, spans_.segments.first(count()), fitted_.report,
                          &spans_.refinement.warm, spans_.refinement.gradient.first(count()));
  fitted_.report.work += work;
  fitted_.report.qp_iterations += iterations;
  return status;
}

/// Stretches the profile until the QP can follow it, each segment at most to its stopping time: at full stretch every
/// segment has that time, which is always feasible.
Status TrajectoryPlanner::stretch_from_rest() {
  Status status = Status::kOk;
  Real stretch = 1;
  for (int step = 0; step < kStretchSteps; ++step, stretch *= kStretchStep) {
    for (std::size_t i = 0; i < count(); ++i) {
      const Real longest = std::max(spans_.stop_durations[i], spans_.profile[i]);
      spans_.durations[i] = std::min(stretch * spans_.profile[i], longest);
    }
    status = try_durations();
    if (status == Status::kOk || work_left() == 0) return status;
  }
  return status;
}

/// Durations from the profile, the later segments stretched in full and the first ones, within the time that stopping
/// takes, only in part: they have to fit the motion.
void TrajectoryPlanner::stretch_profile(Real stretch) {
  const Real stopping = (request_.start.velocity.cwiseAbs().array() / fitted_.qp_a_max.array()).maxCoeff();
  Real elapsed = 0;
  for (std::size_t i = 0; i < count(); ++i) {
    const Real middle = elapsed + spans_.profile[i] / 2;
    const Real share = middle < stopping ? middle / stopping : Real(1);
    spans_.durations[i] = spans_.profile[i] * (1 + (stretch - 1) * share * share);
    elapsed += spans_.profile[i];
  }
  fit_first_box(durations());
}

/// Stretches the profile both ways until the QP can follow it.
Status TrajectoryPlanner::stretch_from_motion() {
  Status status = Status::kOk;
  for (const Real stretch : kMovingStretches) {
    stretch_profile(stretch);
    status = try_durations();
    if (status == Status::kOk || work_left() == 0) return status;
  }
  return status;
}

/// Looks for durations by way of looser limits: where those can be met, the refinement (whose gradient holds the active
/// limits' multipliers) moves towards durations that can do with tighter ones. The motion may give the first durations
/// so narrowly that no step of all at once is feasible: `held` of them then stay.
Status TrajectoryPlanner::tighten_limits(Real weight, std::size_t held) {
  const Vector3 v_max = fitted_.qp_v_max;
  const Vector3 a_max = fitted_.qp_a_max;
  const auto loosen = [&](Real factor) {
    fitted_.qp_v_max = std::sqrt(factor) * v_max;
    fitted_.qp_a_max = factor * a_max;
  };
  Real works = 0;  // the tightest factor that does
  Real factor = 2;
  Status status = Status::kInfeasible;
  for (int step = 0; step < kTightenings && work_left() > 0; ++step) {
    loosen(factor);
    status = try_durations();
    if (status != Status::kOk) {
      if (works == 0) {
        if (factor >= kLoosest) break;
        factor *= 3;
      } else {
        if (factor > Real(0.995) * works) break;
        factor = std::sqrt(factor * works);
      }
      continue;
    }
    works = factor;
    if (factor <= 1) break;
    const std::uint64_t refinement = kTighteningTrials * count() * (kWorkOfSetUp + count());
    TrajectoryReport report;
    const Status refined =
        refine_durations(problem(kTrialEffort),
                         {.time_weight = weight * time_weight(),
                          .work = refinement,
                          .least_gain = kTighteningGain,
                          .largest_step = kTighteningStep,
                          .held = held},
                         spans_.trajectory, spans_.refinement, durations(), spans_.segments.first(count()), report);
    fitted_.report.work += report.work;
    fitted_.report.qp_iterations += report.qp_iterations;
    if (refined != Status::kOk) break;
    factor = std::max(Real(1), factor * Real(0.7));
  }
  fitted_.qp_v_max = v_max;
  fitted_.qp_a_max = a_max;
  return works == 1 ? Status::kOk : Status::kInfeasible;
}

/// Times and QP: profile, stretch, refinement.
Status TrajectoryPlanner::optimise() {
  Status status = allocate_profile();
  if (status != Status::kOk) return status;
  const Real profile_total = sum(spans_.profile.first(count()));
  status = is_from_rest() ? complete(stretch_from_rest()) : optimise_from_motion();
  fitted_.report.time_scale = sum(durations()) / profile_total;
  return status;
}

/// One way after the other to find durations, until one leads to a certified trajectory.
Status TrajectoryPlanner::optimise_from_motion() {
  Status status = complete(stretch_from_motion());
  while (status != Status::kOk && work_left() > 0) {
    if (braking_.count > 0 && is_at_rest(request_.goal)) return optimise_braking();
    if (!drop_first_box()) break;
    plan_braking();
    status = allocate_profile();
    if (status == Status::kOk) status = complete(stretch_from_motion());
  }
  return status == Status::kOk || !corridor_has_room() ? status : optimise_by_tightening();
}

/// Every way to tighten limits, the scattered ones included.
Status TrajectoryPlanner::optimise_by_tightening() {
  Status status = Status::kInfeasible;
  for (std::size_t i = 0; i < kWays.size() && status != Status::kOk && work_left() > 0; ++i) {
    if (kWays[i].knots) fitted_.box_count = insert_knots(corridor_, count(), 0, kKnottedLegs);
    const std::size_t scatters = i >= kFirstScattered && i <= kLastScattered ? kScatters : 0;
    for (std::size_t k = 0; k <= scatters && status != Status::kOk && work_left() > 0; ++k) {
      spans_.refinement.warm.count = {};
      status = allocate_profile();
      if (status != Status::kOk) return status;
      stretch_profile(kWays[i].stretch);
      const std::size_t held = k % (kMostHeld + 1);
      if (k > 0) scatter_durations(k, held);
      status = complete(tighten_limits(kWays[i].weight, held));
    }
  }
  return status;
}

/// The first durations, but for those held, times factors that fill their range evenly from one scatter to the next.
void TrajectoryPlanner::scatter_durations(std::size_t scatter, std::size_t held) {
  for (std::size_t i = held; i < std::min(kScatterSteps.size(), count()); ++i) {
    const Real turns = Real(0.5) + static_cast<Real>(scatter) * kScatterSteps[i];
    const Real u = turns - std::floor(turns);
    // The motion all but decides how long the first box takes.
    spans_.durations[i] *= i == 0 ? Real(0.7) + Real(0.7) * u : (Real(0.4) + u) / (Real(1.4) - u);
  }
}

/// From the braking and the stops after it: they are within the QP's reach at their own durations.
Status TrajectoryPlanner::optimise_braking() {
  if (!add_braking()) return Status::kCorridorCapacity;
  stop_at_every_gate();
  std::copy_n(spans_.stop_durations.begin(), count(), spans_.durations.begin());
  return complete(try_durations());
}

/// Whether every axis has the room to stop, at full level from now, within the boxes of the corridor taken together.
bool TrajectoryPlanner::corridor_has_room() const {
  Box hull = corridor_.boxes[0];
  for (const Box& box : corridor_.boxes.first(count())) hull = {hull.lo.cwiseMin(box.lo), hull.hi.cwiseMax(box.hi)};
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Real v = request_.start.velocity[axis];
    const Real stop = request_.start.position[axis] + v * std::fabs(v) / (2 * fitted_.qp_a_max[axis]);
    if (stop < hull.lo[axis] - kFeasibility || stop > hull.hi[axis] + kFeasibility) return false;
  }
  return true;
}

/// A start about to leave its box may lie in the next one already.
bool TrajectoryPlanner::drop_first_box() {
  if (count() < 2) return false;
  const Box& next = corridor_.boxes[1];
  const Vector3& p = request_.start.position;
  if ((p.array() < next.lo.array()).any() || (p.array() > next.hi.array()).any()) return false;
  const auto shift = [&](auto span, std::size_t elements) {
    for (std::size_t i = 0; i + 1 < elements; ++i) span[i] = span[i + 1];
  };
  shift(corridor_.int_boxes, count());
  shift(corridor_.boxes, count());
  shift(corridor_.gates, count() - 1);
  shift(corridor_.points, count() + 1);
  corridor_.points[0] = p;
  --fitted_.box_count;
  spans_.refinement.warm.count = {};
  return true;
}

/// From durations that a rough solve has found feasible to a certified trajectory. Where the refined ones fail, by a
/// hair or by the solver's cap on its steps, the ones from before are taken.
Status TrajectoryPlanner::complete(Status found) {
  if (found != Status::kOk) return found;
  const std::span<Real> before = spans_.profile.first(count());
  std::copy_n(spans_.durations.begin(), count(), before.begin());
  const Vector3 v_max = fitted_.qp_v_max;
  const Vector3 a_max = fitted_.qp_a_max;
  for (const bool refined : {true, false}) {
    Status status = refine(refined ? request_.budget.refinement : 0);
    if (status == Status::kOk && bounds_.exceed_axes()) status = slow_down_to_bounds();
    if (status == Status::kOk && certify_segments()) return status;
    if (!refined || work_left() == 0) return status == Status::kOk ? Status::kNumericalTrouble : status;
    std::copy_n(before.begin(), count(), spans_.durations.begin());
    fitted_.qp_v_max = v_max;
    fitted_.qp_a_max = a_max;
  }
  return Status::kNumericalTrouble;
}

Status TrajectoryPlanner::refine(std::uint64_t work) {
  // The exact solve at the end takes more than a trial did.
  const std::uint64_t reserve = std::uint64_t{12} * count() * (kWorkOfSetUp + count());
  const std::uint64_t left = work_left() > reserve ? work_left() - reserve : 0;
  return refine_durations(problem({}),
                          {time_weight(), std::min(work, left), is_from_rest() ? bounds_ : MotionBounds{},
                           kLeastGain * static_cast<Real>(count()), request_.budget.deadline},
                          spans_.trajectory, spans_.refinement, durations(), spans_.segments.first(count()),
                          fitted_.report);
}

/// Bounds of norms and jerk, which the QP does not know. From rest a trajectory slowed down by s keeps limits divided
/// by s and s^2: the QP with these limits and the longer durations has it for its solution. From motion only segments
/// that exceed a bound get longer.
Status TrajectoryPlanner::slow_down_to_bounds() {
  const bool from_rest = is_from_rest();
  Status status = Status::kOk;
  for (int round = 0; round < kSlowDowns && status == Status::kOk && !certify_segments(); ++round) {
    const Certificate& proof = fitted_.certificate;
    Real whole = std::max(
        {proof.max_speed_norm / bounds_.v.norm, std::sqrt(proof.max_acceleration_norm / bounds_.a.norm),
         cube_root(proof.max_jerk_norm / bounds_.j.norm), cube_root(proof.max_jerk.maxCoeff() / bounds_.j.axis)});
    whole = std::max(whole, Real(1)) * (1 + Real(sizeof(Real) == 8 ? 1e-7 : 1e-4));
    for (std::size_t i = 0; i < count(); ++i) {
      spans_.durations[i] *= from_rest ? whole : std::max(Real(1), slow_down(spans_.segments[i], bounds_));
    }
    // With the limits as they are the optimum may do better than the slower trajectory, but need not keep the bounds.
    if (from_rest && round > 0) {
      fitted_.qp_v_max /= whole;
      fitted_.qp_a_max /= whole * whole;
    }
    TrajectoryReport report;
    status = refine_durations(problem({}), {1, 0, {}}, spans_.trajectory, spans_.refinement, durations(),
                              spans_.segments.first(count()), report);
    report.work += fitted_.report.work;
    report.qp_iterations += fitted_.report.qp_iterations;
    fitted_.report = report;
  }
  return status;
}

/// Certifies the segments against the request and, when they pass, makes them the answer.
bool TrajectoryPlanner::certify_segments() {
  const std::span<const Segment> segments = spans_.segments.first(count());
  CertificateRequest request = certificate_request(request_.limits);
  request.boxes = corridor_.boxes.first(count());
  request.gates = corridor_.gates.first(count() - 1);
  request.start = request_.start;
  request.goal = request_.goal;
  fitted_.certificate = certify(segments, request);
  if (fitted_.certificate.pass) fitted_.segments = segments;
  return fitted_.certificate.pass;
}

/// The answer that needs no solver, after an optimum that was not found.
Status TrajectoryPlanner::fall_back(Status optimised) {
  fitted_.report.fallback_reason = work_left() == 0 ? FallbackReason::kDeadline : reason_for_fallback(optimised);
  if (!is_from_rest()) {
    const bool can_brake = braking_.count > 0 && is_at_rest(request_.goal);
    if (!can_brake) {
      if (braking_.missing > 0) {
        fitted_.report.blocking = {0, static_cast<std::uint8_t>(braking_.axis), BoundKind::kPosition, braking_.missing,
                                   0};
      }
      return Status::kInfeasible;
    }
    if (brake_count_ == 0 && !add_braking()) return Status::kCorridorCapacity;
  }
  stop_at_every_gate();
  return certify_segments() ? Status::kFallback : Status::kNumericalTrouble;
}

}  // namespace swiftlet
