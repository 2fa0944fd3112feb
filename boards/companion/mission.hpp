#pragma once
#include <cstdint>
#include <optional>

#include "companion/frame_alignment.hpp"
#include "companion/goals.hpp"
#include "companion/journal.hpp"
#include "companion/replanner.hpp"
#include "companion/requests.hpp"
#include "companion/settings.hpp"
#include "companion/telemetry.hpp"
#include "swiftlet/supervisor.hpp"
#include "swiftlet/trajectory_store.hpp"

namespace swiftlet::companion {

/// What the mission looks at once the supervisor has decided.
struct MissionView {
  TimeUs now = 0;
  Decision decision;
  const Replanner& replanner;
  bool has_estimate = false;
  VehicleState estimate;  ///< frame W
};

/// The order of a flight: mode and arming, alignment of the frames, take-off, goals, landing. The supervisor may
/// interrupt it at any time; the pilot even more so.
class Mission {
 public:
  Mission(const Settings& settings, mavlink::Link& link, Journal& journal);

  // The operator's words.
  void engage();
  void release();
  void stop();
  bool land();  ///< False: not in flight.
  /// Whether something, if it is not in the air, keeps it from climbing at its start.
  [[nodiscard]] bool can_start(const Replanner& replanner) const { return armed_ || way_up(replanner).has_value(); }
  /// Goals that are not free are refused; so are goals for which there is no room. The goal's id, 0 when refused.
  std::uint32_t add_goal(const Vector3& position, std::optional<Real> yaw, const BoxGraphView& map);
  std::uint32_t set_goal(const Vector3& position, std::optional<Real> yaw, const BoxGraphView& map);
  /// The reference no longer leads where it should: what is wanted is planned anew.
  void plan_anew() { planned_ = 0; }

  void shift_clock(TimeUs jump);

  // Once a step, in this order.
  void observe(TimeUs now);
  void fill(SupervisorInputs& inputs) const;
  void advance(const MissionView& view, TrajectoryStore& store);

  // What follows for steering and planning.
  [[nodiscard]] Phase phase() const { return phase_; }
  /// Where to plan to; nullptr: nowhere.
  [[nodiscard]] const Goal* goal() const;
  [[nodiscard]] bool position_only() const { return phase_ == Phase::kGround || climbing_ || !alignment_.aligned(); }
  [[nodiscard]] bool flies() const;  ///< off the ground, by measured height
  /// ArduPilot climbs by itself: set-points would end that.
  [[nodiscard]] bool autopilot_climbs() const;
  /// The yaw to be held; nothing in motion.
  [[nodiscard]] std::optional<Real> yaw(bool at_rest) const;
  void plan_ended(const PlanEnd& end);
  /// What a map's radius covers, after the flights so far.
  [[nodiscard]] MarginReport margins(const BoxGraphView& map) const;
  /// How far the margins let it go in a map.
  [[nodiscard]] Reach reach(const BoxGraphView& map) const;

  [[nodiscard]] bool aligned() const { return alignment_.aligned(); }
  /// Whether the goal of that id waits or is flown to.
  [[nodiscard]] bool has_goal(std::uint32_t id) const { return goals_.contains(id); }
  [[nodiscard]] std::uint32_t goals_reached() const { return reached_; }
  [[nodiscard]] std::uint32_t goals_waiting() const { return goals_.size(); }

 private:
  [[nodiscard]] bool in_flight() const { return phase_ == Phase::kTakeoff || phase_ == Phase::kMission; }
  [[nodiscard]] Real height(const VehicleState& estimate) const;
  [[nodiscard]] bool may_align() const;
  [[nodiscard]] bool knows_landed_state() const;
  bool accepts(const Vector3& position, const BoxGraphView& map);
  void note_arming(TimeUs now);
  void stand_where_landed();
  void note_control(const MissionView& view, TrajectoryStore& store);
  void enter_control(const MissionView& view, TrajectoryStore& store);
  void ask_for_control(const MissionView& view);
  [[nodiscard]] std::optional<Vector3> way_up(const Replanner& replanner) const;
  void take_off(const MissionView& view, TrajectoryStore& store);
  void climb(const MissionView& view, TrajectoryStore& store);
  void settle(const MissionView& view, const TrajectoryStore& store);
  void fly(const MissionView& view, const TrajectoryStore& store);
  void reach_goal(const MissionView& view, const TrajectoryStore& store);
  void give_control_back(const MissionView& view);

  const Settings& settings_;
  mavlink::Link& link_;
  Journal& journal_;
  Requests requests_;
  FrameAlignment alignment_;
  Tie tie_;
  Goals goals_;

  Phase phase_ = Phase::kGround;
  bool engaged_ = false;
  bool engages_anew_ = false;  // was engaged when engaged: off for a step
  bool by_operator_ = false;   // not by the settings, and not before somebody else armed the vehicle
  bool stopped_ = false;
  bool pauses_ = false;  // to plan from rest
  bool lands_ = false;
  bool releases_ = false;

  bool in_control_ = false;
  bool ready_ = false;
  TimeUs ready_since_ = 0;

  bool armed_ = false;
  bool seen_disarmed_ = false;  // so it stood on the ground when it was armed
  bool armed_in_our_mode_ = false;
  bool lifted_ = false;  // in the air when the frames were not aligned yet
  std::uint32_t boots_ = 0;

  bool climbing_ = false;
  bool settled_ = false;
  TimeUs takeoff_since_ = 0;
  TimeUs settled_since_ = 0;

  std::uint32_t planned_ = 0;  // goal that the reference leads to
  std::uint32_t reached_ = 0;
  bool rests_ = false;
  TimeUs rests_since_ = 0;
  std::optional<Real> hold_yaw_;
};

}  // namespace swiftlet::companion
