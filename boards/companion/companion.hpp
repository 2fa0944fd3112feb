#pragma once
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "companion/flight_log.hpp"
#include "companion/journal.hpp"
#include "companion/mission.hpp"
#include "companion/plan_worker.hpp"
#include "companion/replanner.hpp"
#include "companion/settings.hpp"
#include "companion/steering.hpp"
#include "companion/storage.hpp"
#include "companion/telemetry.hpp"
#include "companion/word.hpp"
#include "swiftlet/box_graph_view.hpp"
#include "swiftlet/hal/uart.hpp"
#include "swiftlet/mavlink/link.hpp"
#include "swiftlet/supervisor.hpp"

/// The flight application: the same on every board, in the simulator's loop and in a replay. docs/flight.md describes
/// it.
namespace swiftlet::companion {

/// What a companion works with; all of it outlives the companion.
struct Devices {
  hal::Uart& autopilot;
  PlanWorker& planner;
  FlightLog* log = nullptr;  ///< may be absent; begun before the companion is made
};

/// Flies from goal to goal. A deterministic function of what enters: the time of each step, what the devices answered,
/// and the operator's words. No heap, no clock, no threads.
class Companion {
 public:
  static constexpr std::uint32_t kNotes = Journal::kNotes;
  static constexpr std::size_t kMostWords = 16;  ///< of the operator, in one step

  /// `map` outlives the companion, as do the devices and the memory.
  Companion(const Settings& settings, const BoxGraphView& map, const Memory& memory, const Devices& devices);
  Companion(const Companion&) = delete;
  Companion& operator=(const Companion&) = delete;

  /// One step of the flight, to be made at a steady 100 Hz.
  void step(std::chrono::microseconds now);

  // The operator's words; they take effect in the next step, in order. False when they are refused at once: numbers
  // that are not finite or beyond all reason, or no room.
  bool add_goal(const Vector3& position, std::optional<Real> yaw = {});  ///< [m] frame W; flown after those before it
  bool set_goal(const Vector3& position, std::optional<Real> yaw = {});  ///< flown to now, instead of all others
  bool engage(bool on);  ///< on: take off and fly, or take control anew; off: fall silent, the autopilot decides
  bool stop();           ///< brake, hold, forget all goals
  bool land();           ///< brake, then land where it is
  bool block(std::uint32_t id, const Box& obstacle);  ///< [m] frame W; keep out of it and the map's radius around
  bool unblock(std::uint32_t id);
  bool set_limits(Real v_max, Real a_max);  ///< [m/s] [m/s^2]; replans what is under way
  bool tell(const Word& word);              ///< any of the above

  /// Another map from the next step on: the vehicle stops and plans anew. False, nothing having changed, when its
  /// radius does not cover the margins. Both maps outlive the companion. `file`: where it came from, for the log.
  bool replace_map(const BoxGraphView& map, std::string_view file = {});

  [[nodiscard]] const Telemetry& telemetry() const { return telemetry_; }
  [[nodiscard]] const Settings& settings() const { return settings_; }

  /// The supervisor's transitions; the newest Supervisor::kEvents are kept.
  [[nodiscard]] std::uint32_t event_count() const { return supervisor_.event_count(); }
  [[nodiscard]] const FlightEvent& event(std::uint32_t n) const { return supervisor_.event(n); }

  /// Lines for people; the newest kNotes are kept, note(n) for note_count() - kNotes <= n < note_count().
  [[nodiscard]] std::uint32_t note_count() const { return journal_.count(); }
  [[nodiscard]] const Note& note(std::uint32_t n) const { return journal_.note(n); }
  [[nodiscard]] const Journal& journal() const { return journal_; }

 private:
  using Microseconds = std::chrono::microseconds;
  enum ParameterIndex : std::size_t { kSpeed, kAcceleration, kMapRadius, kRequiredRadius, kParameterCount };

  static mavlink::LinkConfig link_config(const Settings& settings, std::span<mavlink::Parameter> parameters);
  static std::array<mavlink::Parameter, kParameterCount> make_parameters(const Settings& settings);
  static SupervisorSettings supervisor_settings(const Settings& settings);

  void shift_clock(Microseconds jump);

  // The stages of a step, in their order.
  void receive(Microseconds now);
  void take_goal();
  void take_commands();
  mavlink::CommandResult carry_out(const mavlink::ReceivedCommand& command);
  bool engage_at_once();
  void take_texts();
  void take_parameters();
  void ask_for_parameters();
  void take_answers();
  void take_hover_thrust(float share);
  void check_loss_time(float seconds);
  void obey();
  void carry_out(const Word& word);
  Decision decide();
  void follow(const Decision& decision);
  void steer(const Decision& decision);
  void plan(const Decision& decision);
  void end_plan();
  void report(const Decision& decision);

  void read_estimate();
  void note_events();
  void log_notes();
  void log_step();
  void check_map(const BoxGraphView& map);
  void change_limits(Real v_max, Real a_max);
  void block_box(const Word& word);
  [[nodiscard]] TimeUs last_message() const;
  [[nodiscard]] TimeUs link_delay() const;

  Settings settings_;
  std::array<mavlink::Parameter, kParameterCount> parameters_;
  FlightLog* log_;
  RecordedUart uart_;
  mavlink::Link link_;
  Journal journal_;
  Supervisor supervisor_;
  TrajectoryStore store_;
  Replanner replanner_;
  Mission mission_;
  Steering steering_;
  mavlink::Ring<Word, kMostWords> words_;

  TimeUs now_ = 0;
  VehicleState estimate_;  // frame W
  bool has_estimate_ = false;
  bool new_estimate_ = false;
  bool estimate_refused_ = false;
  std::uint32_t estimates_ = 0;
  std::uint32_t refused_estimates_ = 0;
  TimeUs last_setpoint_ = 0;
  bool wants_plan_ = false;
  TimeUs plan_wanted_since_ = 0;
  std::optional<mavlink::Goal> link_goal_;  // the latest that was news
  std::uint32_t link_goal_id_ = 0;          // 0: it was refused
  TimeUs stream_until_ = 0;                 // before it a repetition is no news
  std::uint32_t parameter_changes_ = 0;
  std::optional<std::uint32_t> asked_boot_;  // of the autopilot, in which it was asked for its parameters
  std::uint32_t noted_events_ = 0;
  std::uint32_t logged_notes_ = 0;
  Telemetry telemetry_;
};

}  // namespace swiftlet::companion
