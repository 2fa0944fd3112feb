#include "companion/mission.hpp"

#include <cmath>

#include "companion/climb.hpp"

namespace swiftlet::companion {
namespace {

constexpr TimeUs kStreamBefore = kSecondUs / 2;     // set-points before the mode is asked for: PX4 wants a stream
constexpr Real kLifted = Real(0.3);                 // [m] above the start: off the ground
constexpr Real kSlow = Real(0.3);                   // [m/s] of a vehicle that has arrived at its height
constexpr TimeUs kSettleTime = kSecondUs / 2;       // within half of the tube
constexpr TimeUs kSettlePatience = 5 * kSecondUs;   // then the supervisor judges the error
constexpr TimeUs kArrivalPatience = 3 * kSecondUs;  // at rest, the tube will do
constexpr Real kYawTolerance = Real(0.1);           // [rad]
constexpr TimeUs kBeforeLanding = kSecondUs;        // at rest

}  // namespace

Mission::Mission(const Settings& settings, mavlink::Link& link, Journal& journal)
    : settings_(settings),
      link_(link),
      journal_(journal),
      requests_(link, journal),
      alignment_(link, settings.takeoff.standing),
      engaged_(settings.engage_at_start) {
  alignment_.stand_at(settings.start, settings.start_yaw);
}

// ---- The operator

void Mission::engage() {
  engages_anew_ = engaged_;
  engaged_ = true;
  by_operator_ = true;
  releases_ = stopped_ = false;
}

void Mission::release() {
  engaged_ = false;
  releases_ = in_control_;
}

void Mission::stop() {
  goals_.clear();
  stopped_ = true;
}

bool Mission::land() {
  if (in_flight()) return lands_ = true;
  journal_.warn("refused to land: not in flight");
  return false;
}

bool Mission::accepts(const Vector3& position, const BoxGraphView& map) {
  Line line("goal ");
  line << position;
  if (lands_) {
    journal_.warn(line << " refused: landing");
  } else if (!map.locate(position)) {
    journal_.warn(line << " refused: goal_not_free");
  } else if (const Reach within = reach(map); !within.covers(position)) {
    journal_.warn(line << " refused: " << within.distance_to(position)
                       << " m from the start, the heading's margin allows " << within.distance << " m");
  } else {
    return true;
  }
  return false;
}

std::uint32_t Mission::add_goal(const Vector3& position, std::optional<Real> yaw, const BoxGraphView& map) {
  if (!accepts(position, map)) return 0;
  Line line("goal ");
  line << position;
  const std::uint32_t id = goals_.add(position, yaw);
  if (id == 0) {
    journal_.warn(line << " refused: too many goals");
    return 0;
  }
  stopped_ = false;
  journal_.info(line << " taken");
  return id;
}

std::uint32_t Mission::set_goal(const Vector3& position, std::optional<Real> yaw, const BoxGraphView& map) {
  if (!accepts(position, map)) return 0;
  goals_.clear();
  return add_goal(position, yaw, map);
}

MarginReport Mission::margins(const BoxGraphView& map) const {
  return margins_of(settings_, static_cast<Real>(map.header().radius), tie_);
}

Reach Mission::reach(const BoxGraphView& map) const { return {alignment_.place(), margins(map).reach}; }

// ---- What the autopilot says

/// Whether the vehicle stands where it is known to stand.
bool Mission::may_align() const {
  const bool on_ground = link_.autopilot().landed_state == mavlink::LandedState::kOnGround;
  return !lifted_ && (seen_disarmed_ || on_ground);
}

bool Mission::knows_landed_state() const { return link_.autopilot().landed_state != mavlink::LandedState::kUnknown; }

void Mission::note_arming(TimeUs now) {
  const mavlink::AutopilotState& autopilot = link_.autopilot();
  if (autopilot.restarts != boots_) alignment_.forget();
  boots_ = autopilot.restarts;
  if (!autopilot.heard) return;
  if (armed_ && !autopilot.armed) {
    const bool has_flown = phase_ == Phase::kMission || phase_ == Phase::kLanding || phase_ == Phase::kDone;
    if (has_flown && alignment_.aligned()) stand_where_landed();
    alignment_.forget();
  }
  const bool in_our_mode = autopilot.mode == mavlink::Mode::kOffboard;
  if (seen_disarmed_ && !armed_ && autopilot.armed) {
    armed_in_our_mode_ = in_our_mode;
    if (!in_our_mode) by_operator_ = false;
  }
  armed_ = autopilot.armed;
  seen_disarmed_ = seen_disarmed_ || !armed_;
  // PX4's landed state says "in air" early; in our mode, which it was armed in, nothing but us can lift it.
  const bool by_us = armed_in_our_mode_ && in_our_mode;
  const bool says_in_air = knows_landed_state() && autopilot.landed_state != mavlink::LandedState::kOnGround;
  lifted_ = armed_ && !alignment_.aligned() && (lifted_ || (says_in_air && !by_us));
  if (armed_ && may_align()) (void)alignment_.step(now);
}

/// What this flight's heading was off is part of where the next one starts, and of its heading: that is read once more
/// now, and again when the frames are tied anew.
void Mission::stand_where_landed() {
  const mavlink::VehicleState vehicle = link_.vehicle();
  const Real flown = (vehicle.position - alignment_.place()).head<2>().norm();
  tie_.error += static_cast<Real>(tie_.readings) * settings_.margins.heading_accuracy * flown;
  tie_.readings += 2;
  alignment_.stand_at(vehicle.position, mavlink::yaw_of(vehicle.attitude));
}

void Mission::shift_clock(TimeUs jump) {
  requests_.shift_clock(jump);
  alignment_.shift_clock(jump);
  for (TimeUs* since : {&ready_since_, &takeoff_since_, &settled_since_, &rests_since_}) *since += jump;
}

void Mission::observe(TimeUs now) {
  requests_.step(now);
  note_arming(now);
}

void Mission::fill(SupervisorInputs& inputs) const {
  const mavlink::Mode mode = link_.autopilot().mode;
  inputs.engage = engaged_ && !engages_anew_;
  // Control begins once the frames are tied; in the air, where they cannot be, it begins to hold.
  inputs.armed = armed_;
  inputs.standing = !alignment_.aligned() && (may_align() || !knows_landed_state());
  inputs.in_our_mode = mode == mavlink::Mode::kOffboard;
  inputs.landing = (lands_ && mode == mavlink::Mode::kLand) || (releases_ && mode == mavlink::Mode::kHold);
  inputs.stop = stopped_ || pauses_ || lands_ || releases_;
  inputs.airborne = flies();
  inputs.goal_pending = goal() != nullptr && goal()->id != planned_;
}

// ---- The sequence

bool Mission::flies() const { return (phase_ == Phase::kMission || phase_ == Phase::kLanding) && alignment_.aligned(); }

Real Mission::height(const VehicleState& estimate) const { return estimate.position.z() - alignment_.place().z(); }

bool Mission::autopilot_climbs() const {
  return climbing_ && link_.autopilot().kind == mavlink::AutopilotKind::kArduPilot;
}

const Goal* Mission::goal() const {
  const bool may_plan = phase_ == Phase::kMission && alignment_.aligned() && !lands_ && !releases_;
  return may_plan ? goals_.first() : nullptr;
}

std::optional<Real> Mission::yaw(bool at_rest) const {
  if (phase_ == Phase::kTakeoff) return alignment_.place_yaw();
  if (!at_rest) return std::nullopt;
  const Goal* here = goals_.first();
  return here != nullptr && here->id == planned_ && here->yaw ? here->yaw : hold_yaw_;
}

void Mission::advance(const MissionView& view, TrajectoryStore& store) {
  engages_anew_ = false;
  note_control(view, store);
  if (view.decision.state == FlightState::kHolding) pauses_ = false;
  if (lands_ && in_flight()) phase_ = Phase::kLanding;
  if (phase_ == Phase::kGround && view.decision.may_ask_for_control) ask_for_control(view);
  if (!in_control_) return;
  if (phase_ == Phase::kTakeoff) take_off(view, store);
  if (phase_ == Phase::kMission) fly(view, store);
  if (lands_ || releases_) give_control_back(view);
}

void Mission::note_control(const MissionView& view, TrajectoryStore& store) {
  const FlightState state = view.decision.state;
  if (state == FlightState::kReady && !ready_) ready_since_ = view.now;
  ready_ = state == FlightState::kReady;
  const bool had_control = in_control_;
  in_control_ = state == FlightState::kFlying || state == FlightState::kBraking || state == FlightState::kHolding;
  if (in_control_ && !had_control) enter_control(view, store);
  if (!in_control_ && had_control) releases_ = climbing_ = false;
  if (!in_control_ && !ready_) requests_.cancel();
  if (state == FlightState::kLanded && phase_ != Phase::kDone) {
    if (phase_ != Phase::kGround) goals_.clear();
    phase_ = Phase::kDone;
    lands_ = false;
  }
  const bool again = phase_ == Phase::kDone && (state == FlightState::kIdle || state == FlightState::kReady);
  if (again || (ready_ && !in_control_)) phase_ = Phase::kGround;
}

void Mission::enter_control(const MissionView& view, TrajectoryStore& store) {
  lands_ = false;
  planned_ = 0;
  hold_yaw_.reset();
  phase_ = Phase::kMission;
  if (!alignment_.aligned())
    return journal_.warn("found in the air: where is not known, holding; land it by hand or by word");
  if (height(view.estimate) > kLifted) return;
  const std::optional<Vector3> target = way_up(view.replanner);
  if (!target) {  // it was there when control was asked for
    lands_ = true;
    return journal_.warn("nothing is free above the start");
  }
  phase_ = Phase::kTakeoff;
  climbing_ = true;
  settled_ = false;
  reached_ = 0;
  takeoff_since_ = view.now;
  store.hold(*target, view.now);
}

/// Streams first, then the mode, then arming. In the air only the operator may have it taken from somebody.
void Mission::ask_for_control(const MissionView& view) {
  const mavlink::AutopilotState& autopilot = link_.autopilot();
  if (!autopilot.heard || view.now - ready_since_ < kStreamBefore) return;
  if (!can_start(view.replanner)) {
    engaged_ = false;
    return journal_.warn("no start: nothing is free above the start");
  }
  if (autopilot.mode != mavlink::Mode::kOffboard) {
    if (!autopilot.armed || by_operator_) requests_.ask_for_mode(mavlink::Mode::kOffboard, view.now);
  } else if (!autopilot.armed) {
    requests_.ask_to_arm(view.now);
  }
}

/// Where the climb leads, if that is free and nothing that is blocked lies on the way.
std::optional<Vector3> Mission::way_up(const Replanner& replanner) const {
  const Vector3& place = alignment_.place();
  const std::optional<Vector3> target = climb_target(replanner.map(), place, settings_.takeoff.height);
  return target && !replanner.way_blocked(place, *target) ? target : std::nullopt;
}

void Mission::take_off(const MissionView& view, TrajectoryStore& store) {
  if (climbing_) return climb(view, store);
  settle(view, store);
}

/// PX4's own take-off, with its ramp, on the position form: the height that counts is the measured one.
void Mission::climb(const MissionView& view, TrajectoryStore& store) {
  const Vector3 target = store.sample(view.now).position;
  if (autopilot_climbs() && height(view.estimate) < kLifted)
    requests_.ask_to_take_off(target.z() - alignment_.place().z(), view.now);
  if (view.now - takeoff_since_ > settings_.takeoff.patience) {
    journal_.warn("the take-off takes too long");
    lands_ = true;
  }
  if (view.replanner.way_blocked(view.estimate.position, target)) {
    journal_.warn("the way up is blocked: landing");
    lands_ = true;
    return store.hold(view.estimate.position, view.now);
  }
  const Real missing = target.z() - view.estimate.position.z();
  if (missing > settings_.takeoff.tolerance || std::fabs(view.estimate.velocity.z()) > kSlow) return;
  climbing_ = false;
  takeoff_since_ = settled_since_ = view.now;
}

/// Our own control takes over and closes in, before its error counts.
void Mission::settle(const MissionView& view, const TrajectoryStore& store) {
  const Real error = (view.estimate.position - store.sample(view.estimate.time).position).norm();
  const Real tube = tube_of(settings_.margins.tubes, settings_.form);
  if (error > tube / 2 || view.estimate.velocity.norm() > kSlow) settled_since_ = view.now;
  const bool settled = view.now - settled_since_ >= kSettleTime;
  if (settled || view.now - takeoff_since_ > kSettlePatience) phase_ = Phase::kMission;
}

void Mission::fly(const MissionView& view, const TrajectoryStore& store) {
  const bool at_rest = store.at_rest(view.now);
  if (at_rest && !rests_) rests_since_ = view.now;
  rests_ = at_rest;
  if (!at_rest) {
    hold_yaw_.reset();
    return;
  }
  reach_goal(view, store);
  const bool has_rested = view.now - rests_since_ >= kBeforeLanding;
  if (settings_.land_at_end && reached_ > 0 && goals_.size() == 0 && has_rested) lands_ = true;
}

void Mission::reach_goal(const MissionView& view, const TrajectoryStore& store) {
  const Goal* goal = goals_.first();
  if (goal == nullptr || goal->id != planned_) return;
  const Real error = (view.estimate.position - store.sample(view.now).position).norm();
  const bool waited = view.now - rests_since_ >= kArrivalPatience;
  const Real tube = tube_of(settings_.margins.tubes, settings_.form);
  if (error > (waited ? tube : settings_.arrival_tolerance)) return;
  const Real turned = goal->yaw ? std::fabs(wrap_angle(mavlink::yaw_of(view.estimate.attitude) - *goal->yaw)) : 0;
  if (turned > kYawTolerance && !waited) return;
  Line line("goal ");
  journal_.info(line << goal->position << " reached");
  hold_yaw_ = goal->yaw;
  goals_.drop_first();
  ++reached_;
  rests_since_ = view.now;
}

/// At rest the autopilot is asked for a mode of its own; when it has it, the supervisor yields.
void Mission::give_control_back(const MissionView& view) {
  if (view.decision.state != FlightState::kHolding) return;
  requests_.ask_for_mode(lands_ ? mavlink::Mode::kLand : mavlink::Mode::kHold, view.now);
}

// ---- Plans

void Mission::plan_ended(const PlanEnd& end) {
  if (end.committed) {
    planned_ = end.goal;
    return;
  }
  const bool has_plan = end.status == Status::kOk || end.status == Status::kFallback;
  const bool no_use = has_plan && (end.offer == OfferResult::kTooLong || end.hopeless || end.too_far);
  const Goal* goal = goals_.first();
  const bool is_first = goal != nullptr && goal->id == end.goal;
  if (!is_first || (has_plan && !no_use)) return;  // planned anew
  if (!end.from_rest) {
    pauses_ = true;
    return;
  }
  Line line("goal ");
  const char* why = !no_use       ? describe(end.status)
                    : end.too_far ? "its way leads farther from the start than the heading's margin allows"
                                  : describe(end.offer);
  journal_.warn(line << goal->position << " given up: " << why);
  goals_.drop_first();
}

}  // namespace swiftlet::companion
