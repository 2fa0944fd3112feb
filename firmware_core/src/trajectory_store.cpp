#include "swiftlet/trajectory_store.hpp"

#include <algorithm>

namespace swiftlet {
namespace {

constexpr bool kIsDouble = sizeof(Real) == 8;
// The certificate's limits for a jump at a junction [m, m/s, m/s^2]: a splice is one.
constexpr std::array<Real, 3> kJumpLimits = kIsDouble ? std::array<Real, 3>{Real(1e-6), Real(1e-5), Real(1e-4)}
                                                      : std::array<Real, 3>{Real(1e-4), Real(1e-3), Real(1e-2)};

/// False for NaN, which Eigen's maxCoeff would pass over.
bool is_close(const Vector3& a, const Vector3& b, Real limit) { return ((a - b).array().abs() <= limit).all(); }

bool starts_in(const State& state, const Segment& first) {
  const Sample sample = sample_segment(first, 0);
  return is_close(sample.position, state.position, kJumpLimits[0]) &&
         is_close(sample.velocity, state.velocity, kJumpLimits[1]) &&
         is_close(sample.acceleration, state.acceleration, kJumpLimits[2]);
}

bool ends_at_rest(const Segment& last) {
  const Sample sample = sample_segment(last, last.duration);
  return is_close(sample.velocity, Vector3::Zero(), kJumpLimits[1]) &&
         is_close(sample.acceleration, Vector3::Zero(), kJumpLimits[2]);
}

Sample rest_at(const Vector3& position) { return {position, Vector3::Zero(), Vector3::Zero(), Vector3::Zero()}; }

}  // namespace

const char* describe(OfferResult result) {
  switch (result) {
    case OfferResult::kAccepted:
      return "accepted";
    case OfferResult::kLate:
      return "too late: the start of the plan has passed";
    case OfferResult::kSuperseded:
      return "the reference has changed since the plan was begun";
    case OfferResult::kNotCertified:
      return "its certificate does not pass";
    case OfferResult::kTooLong:
      return "more segments than the store holds, or none";
    case OfferResult::kDiscontinuous:
      return "it does not start in the state that was asked for, or does not end at rest";
  }
  return "unknown result";
}

void TrajectoryStore::hold(const Vector3& position, TimeUs now) {
  committed_ = {};
  committed_.start = now;
  committed_.offset = position;
  committed_.used = true;
  candidate_ = {};
  splice_open_ = false;
}

/// A candidate whose time has come is the committed one.
void TrajectoryStore::promote(TimeUs now) {
  if (!candidate_.used || now < candidate_.start) return;
  committed_ = candidate_;
  candidate_ = {};
}

Splice TrajectoryStore::begin(TimeUs now, TimeUs latency) {
  promote(now);
  if (!committed_.used || candidate_.used) return {};
  if (++splice_id_ == 0) ++splice_id_;
  splice_open_ = true;
  const TimeUs start = now + std::max<TimeUs>(latency, 0);
  const Sample at_start = sample(start);
  return {start, {at_start.position, at_start.velocity, at_start.acceleration}, splice_id_};
}

OfferResult TrajectoryStore::offer(const PlanOffer& plan, const Splice& splice, TimeUs now) {
  if (!splice_open_ || splice.id != splice_id_) return OfferResult::kSuperseded;
  splice_open_ = false;
  if (now > splice.start) return OfferResult::kLate;
  if (!plan.certificate.pass) return OfferResult::kNotCertified;
  const std::size_t free_slot = 1 - committed_.index;
  const std::span<Segment> slot = spans_.slots[free_slot];
  if (plan.segments.empty() || plan.segments.size() > slot.size()) return OfferResult::kTooLong;
  if (!starts_in(splice.state, plan.segments.front()) || !ends_at_rest(plan.segments.back())) {
    return OfferResult::kDiscontinuous;
  }
  std::copy(plan.segments.begin(), plan.segments.end(), slot.begin());
  candidate_ = {};
  candidate_.index = free_slot;
  candidate_.count = plan.segments.size();
  candidate_.start = splice.start;
  candidate_.limits = plan.limits;
  candidate_.used = true;
  promote(now);
  return OfferResult::kAccepted;
}

const TrajectoryStore::Slot& TrajectoryStore::slot_at(TimeUs time) const {
  return candidate_.used && time >= candidate_.start ? candidate_ : committed_;
}

PathTime TrajectoryStore::path_time_of(const Slot& slot, TimeUs time) {
  if (slot.braking && time >= slot.brake_start) return path_time(slot.brake, to_seconds(time - slot.brake_start));
  return {to_seconds(time - slot.start), 1, 0, 0};
}

Sample TrajectoryStore::sample(TimeUs time) const {
  const Slot& slot = slot_at(time);
  if (slot.count == 0) return rest_at(slot.offset);
  const std::span<const Segment> segments = segments_of(slot);
  const PathTime at = path_time_of(slot, time);
  Sample on_path = sample_trajectory(segments, at.s);
  on_path.position += slot.offset;
  // Past the end only the position counts: what an end state may differ from rest must not be extrapolated.
  if (at.s >= total_duration(segments)) return rest_at(on_path.position);
  return slowed(on_path, at);
}

void TrajectoryStore::brake(TimeUs now) {
  promote(now);
  candidate_ = {};
  splice_open_ = false;
  if (committed_.braking || committed_.count == 0) return;
  committed_.brake = find_brake(segments_of(committed_), std::max(path_time_at(now), Real(0)), committed_.limits);
  committed_.brake_start = now;
  committed_.braking = true;
}

bool TrajectoryStore::at_rest(TimeUs time) const {
  const Slot& slot = slot_at(time);
  if (candidate_.used && &slot != &candidate_) return false;
  if (slot.count == 0) return slot.used;
  const PathTime at = path_time_of(slot, time);
  return at.rate == 0 || at.s >= total_duration(segments_of(slot));
}

void TrajectoryStore::shift_clock(TimeUs jump) {
  for (Slot* slot : {&committed_, &candidate_}) {
    slot->start += jump;
    slot->brake_start += jump;
  }
  splice_open_ = false;
}

void TrajectoryStore::shift_position(const Vector3& jump) {
  committed_.offset += jump;
  candidate_.offset += jump;
  splice_open_ = false;
}

std::span<const Segment> TrajectoryStore::segments(TimeUs time) const { return segments_of(slot_at(time)); }

Real TrajectoryStore::path_time_at(TimeUs time) const { return path_time_of(slot_at(time), time).s; }

}  // namespace swiftlet
