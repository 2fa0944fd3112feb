#pragma once
#include "fly/flight.hpp"
#include "fly/setpoint_watch.hpp"

namespace swiftlet::tools {

/// Watches a flight step by step and reports on it at its end.
class FlightObserver {
 public:
  FlightObserver(const FlightRequest& request, FlightPlanner& planner);

  void note_fault(const FlightFault& fault, double t);
  /// After each step of the companion, or the turn of one that it slept through: `truth` at the same instant.
  void see(double t, const companion::Companion& companion, const RigidState& truth, const SetpointWatch& watch);

  /// After `see`: the least distance of the vehicle's centre to an obstacle so far [m], of the time when it counts.
  void see_clearance(double least);

  /// True while the distance to obstacles counts: in the air, in control, neither taking off nor landing.
  [[nodiscard]] bool measures() const { return measures_; }
  /// True when nothing more is to be expected.
  [[nodiscard]] bool finished() const;

  [[nodiscard]] FlightReport report(const companion::Companion& companion, const SetpointWatch& watch);

 private:
  void enter(companion::Phase phase);
  void see_phase(const companion::Telemetry& telemetry);
  void see_events(const companion::Companion& companion);
  void see_plan(const companion::Telemetry& telemetry);
  void see_tracking(const companion::Telemetry& telemetry, const RigidState& truth);
  void see_setpoint(const companion::Telemetry& telemetry, const SetpointWatch& watch);
  void answer_fault(const FlightEvent& event);
  void settle_faults(const companion::Telemetry& telemetry);
  void keep_sample(const companion::Telemetry& telemetry, const RigidState& truth, const SetpointWatch& watch);
  void name_outcome(const companion::Telemetry& telemetry);
  void note(EventKind kind, std::string what) { report_.record.events.push_back({t_, kind, std::move(what)}); }
  [[nodiscard]] double patience() const;

  const FlightRequest& request_;
  FlightPlanner& planner_;
  FlightReport report_;
  double t_ = 0;

  companion::Phase phase_ = companion::Phase::kGround;
  FlightState state_ = FlightState::kIdle;
  FlightState flown_state_ = FlightState::kIdle;  // the last one before it was landing or down
  double changed_at_ = 0;                         // [s] the last time that anything moved on
  bool measures_ = false;
  bool begun_ = false;  // the take-off has ended
  bool ended_ = false;  // the landing has begun, or control was lost
  std::uint32_t events_seen_ = 0;
  std::string transition_;  // the newest, as the companion's own note of it reads
  std::string lost_goal_;   // the newest note of a goal that was refused or given up
  std::uint32_t notes_seen_ = 0;
  std::uint32_t plan_ = 0;
  Reason fault_ = Reason::kNone;  // latest
  double answer_until_ = 0;       // [s] the newest fault may be answered so long
  double sum_of_squares_ = 0;
  double estimate_squares_ = 0;
  std::size_t tracked_ = 0;
  std::uint64_t bytes_in_ = 0;  // when the take-off ended
  std::uint64_t bytes_out_ = 0;
};

}  // namespace swiftlet::tools
