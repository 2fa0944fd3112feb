#include "companion/replanner.hpp"

#include <algorithm>

namespace swiftlet::companion {
namespace {

// [m] by which the state that a splice asks for may lie outside the map's free space: the store's limit for a jump.
constexpr Real kSnap = sizeof(Real) == 8 ? Real(1e-6) : Real(1e-4);

// From rest, each plan in a row that came late is followed by one that is given twice as long.
constexpr std::uint32_t kMostDoublings = 6;

bool is_certified(const Plan& plan) { return plan.status == Status::kOk || plan.status == Status::kFallback; }

/// What a brake must keep. A limit of jerk on each axis has no equal there: the plan's own jerk stands for it.
BrakeLimits brake_limits(const FlightLimits& limits, const Certificate& certificate) {
  const MotionBounds bounds = motion_bounds(limits);
  BrakeLimits kept;
  kept.a_max.setConstant(bounds.a.axis);
  kept.acceleration_norm_max = bounds.a.norm;
  kept.jerk_norm_max = bounds.j.norm;
  if (bounds.j.axis < kUnlimited) {
    kept.jerk_norm_max = std::min(kept.jerk_norm_max, std::max(bounds.j.axis, certificate.max_jerk_norm));
  }
  return kept;
}

}  // namespace

Replanner::Replanner(const Settings& settings, const BoxGraphView& map, const Memory& memory, PlanWorker& worker)
    : settings_(settings),
      worker_(worker),
      map_(map),
      limits_(settings.limits),
      blocked_spans_(memory.blocked),
      box_spans_(memory.boxes),
      seen_(map, memory.blocked[0]),
      searched_(map, memory.blocked[1]) {}

// ---- The map

void Replanner::keep(std::uint32_t id, const Box& obstacle) {
  std::size_t k = 0;
  while (k < obstacle_count_ && obstacles_[k].id != id) ++k;
  obstacles_[k] = {id, obstacle};  // the space holds no more boxes than this list
  if (k == obstacle_count_) ++obstacle_count_;
}

Status Replanner::block(std::uint32_t id, const Box& obstacle) {
  const Status status = seen_.add(id, obstacle);
  if (status != Status::kOk) return status;
  keep(id, obstacle);
  searched_is_old_ = true;
  return status;
}

bool Replanner::unblock(std::uint32_t id) {
  if (!seen_.remove(id)) return false;
  std::size_t k = 0;
  while (obstacles_[k].id != id) ++k;
  obstacles_[k] = obstacles_[--obstacle_count_];
  searched_is_old_ = true;
  return true;
}

Status Replanner::replace_map(const BoxGraphView& map) {
  map_ = map;
  seen_ = BlockedSpace(map, blocked_spans_[0]);
  searched_is_old_ = true;
  Status worst = Status::kOk;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < obstacle_count_; ++k) {
    const Status status = seen_.add(obstacles_[k].id, obstacles_[k].box);
    if (status == Status::kOk) {
      obstacles_[kept++] = obstacles_[k];
    } else {
      worst = status;
    }
  }
  obstacle_count_ = kept;
  return worst;
}

/// The space that plans are made in follows the one that the flight sees; no plan is under way.
void Replanner::bring_up_to_date() {
  if (!searched_is_old_) return;
  searched_is_old_ = false;
  searched_ = BlockedSpace(map_, blocked_spans_[1]);
  for (std::size_t k = 0; k < obstacle_count_; ++k) {
    (void)searched_.add(obstacles_[k].id, obstacles_[k].box);  // what fitted there fits here, in the same order or not;
                                                               // a plan that meets one that did not is discarded
  }
}

void Replanner::set_limits(Real v_max, Real a_max) {
  limits_.v_max = v_max;
  limits_.a_max = a_max;
}

/// The store takes no splice from before a jump, so that of a plan under way is of no use any more.
void Replanner::shift_clock(TimeUs jump) {
  trigger_ += jump;
  committed_.start += jump;
}

bool Replanner::path_blocked(const TrajectoryStore& store, TimeUs now) const {
  if (seen_.boxes().empty()) return false;
  const TimeUs from = std::max(now, committed_.start);  // what is left of the old plan before a new one is short
  const std::span<const Segment> segments = store.segments(from);
  return !segments.empty() && !store.at_rest(from) && seen_.meets(segments, store.path_time_at(from));
}

bool Replanner::way_blocked(const Vector3& from, const Vector3& to) const {
  Segment way;
  way.duration = 1;
  for (int axis = 0; axis < 3; ++axis) {
    way.coefficients[static_cast<std::size_t>(axis)] = {from[axis], to[axis] - from[axis]};
  }
  return seen_.meets({&way, 1}, 0);
}

// ---- Plans

PlanRequest Replanner::request_for(const Goal& goal, const State& start) const {
  PlanRequest request;
  request.start = start;
  request.goal.position = goal.position;
  request.v_max = limits_.v_max;
  request.a_max = limits_.a_max;
  request.j_max = limits_.j_max;
  request.norm = limits_.norm;
  request.vehicle = limits_.vehicle;
  request.corridor = settings_.planning.corridor;
  request.search = settings_.planning.search;
  request.budget = settings_.planning.budget;
  request.snap_distance = kSnap;
  return request;
}

bool Replanner::begin(const Goal& goal, TimeUs trigger, const Reach& reach, TrajectoryStore& store, TimeUs now) {
  const std::uint32_t doublings = store.at_rest(now) ? std::min(late_in_row_, kMostDoublings) : 0;
  splice_ = store.begin(now, settings_.planning.latency << doublings);
  if (splice_.id == 0) return false;
  bring_up_to_date();
  goal_ = goal;
  reach_ = reach;
  trigger_ = trigger;
  planned_limits_ = limits_;
  planned_map_ = map_crc();
  under_way_ = true;
  worker_.start({searched_.view(), request_for(goal, splice_.state)});
  return true;
}

OfferResult Replanner::offer(const Plan& plan, TrajectoryStore& store, TimeUs now) {
  if (planned_map_ != map_crc() || seen_.meets(plan.segments, 0)) return OfferResult::kSuperseded;
  if (plan.boxes.size() > box_spans_[0].size()) return OfferResult::kTooLong;
  return store.offer({plan.segments, plan.certificate, brake_limits(planned_limits_, plan.certificate)}, splice_, now);
}

void Replanner::commit(const Plan& plan, const TrajectoryStore& store, TimeUs now) {
  box_slot_ = 1 - box_slot_;
  const std::span<Box> boxes = box_spans_[box_slot_].first(plan.boxes.size());
  std::copy(plan.boxes.begin(), plan.boxes.end(), boxes.begin());
  ++committed_.id;
  committed_.start = splice_.start;
  committed_.from = plan.start;
  committed_.goal = plan.goal;
  committed_.segments = store.segments(splice_.start);
  committed_.boxes = boxes;
  committed_.certificate = plan.certificate;
  committed_.status = plan.status;
  committed_.map_crc = planned_map_;
  committed_.latency = now - trigger_;
}

std::optional<PlanEnd> Replanner::poll(bool wanted, TrajectoryStore& store, TimeUs now) {
  if (!worker_.done()) return std::nullopt;
  under_way_ = false;
  const Plan& plan = worker_.result();
  PlanEnd end;
  end.status = plan.status;
  end.goal = goal_.id;
  end.from_rest = splice_.state.velocity.squaredNorm() == 0 && splice_.state.acceleration.squaredNorm() == 0;
  if (!is_certified(plan)) return end;
  end.too_far = planned_map_ == map_crc() && !reach_.covers(plan.segments);
  end.offer = wanted && !end.too_far ? offer(plan, store, now) : OfferResult::kSuperseded;
  end.committed = end.offer == OfferResult::kAccepted;
  const bool is_late = end.offer == OfferResult::kLate;
  late_ += is_late ? 1 : 0;
  late_in_row_ = is_late ? late_in_row_ + 1 : end.committed ? 0 : late_in_row_;
  end.hopeless = is_late && end.from_rest && late_in_row_ > kMostDoublings;
  if (end.committed) {
    commit(plan, store, now);
  } else {
    ++discarded_;
  }
  return end;
}

}  // namespace swiftlet::companion
