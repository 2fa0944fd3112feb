#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "swiftlet/flight_time.hpp"
#include "swiftlet/types.hpp"
#include "swiftlet/vehicle_state.hpp"

namespace swiftlet {

enum class FlightState : std::uint8_t {
  kIdle,     ///< not engaged, or something is missing; nothing is sent
  kReady,    ///< engaged and healthy: the present position is streamed, control may be asked for
  kFlying,   ///< in control, the reference moves
  kBraking,  ///< in control, the reference slows down along its path
  kHolding,  ///< in control, the reference rests (also before a take-off)
  kYielded,  ///< control is the pilot's or the autopilot's; nothing is sent until engaged anew
  kLanded,   ///< disarmed after having been in control, or after a yield
};

/// Why a state was entered, or what keeps it from being left.
enum class Reason : std::uint8_t {
  kNone,
  // Progress.
  kEngaged,
  kReleased,
  kControlGained,
  kPlanStarted,
  kArrived,
  kStopped,
  kStopRequested,
  kLandingRequested,
  kDisarmed,
  // Faults.
  kLinkLost,
  kOdometryStale,
  kOdometryInvalid,
  kPositionJump,
  kAutopilotRestart,
  kPilotTookOver,
  kSetpointStarved,
  kClockJump,
  kMapReplaced,
  kStorageFull,
  kTrackingError,
  kDeadlineMisses,
  kPathBlocked,
  kMarginsTooSmall,
};

/// English phrases for people and logs.
const char* describe(FlightState state);
const char* describe(Reason reason);

struct SupervisorSettings {
  TimeUs odometry_age_max = 200'000;      ///< brake
  TimeUs link_age_max = 1'000'000;        ///< no message of any kind: yield
  TimeUs setpoint_age_max = 250'000;      ///< brake; PX4 itself drops out after a second
  TimeUs setpoint_age_yield = 900'000;    ///< yield: the autopilot is about to take over, or has
  TimeUs clock_gap_max = 1'000'000;       ///< a longer gap between steps is a jump of the clock
  TimeUs blocked_patience = 100'000;      ///< a blocked path may be replanned this long before the brake
  std::uint32_t deadline_misses_max = 3;  ///< in a row: brake
  Real tracking_tube = Real(0.15);        ///< [m] brake beyond it: the margin ledger's share
  Real position_jump = Real(0.3);         ///< [m] beyond what velocity explains: a jump of the estimate
  bool storage_needed = true;             ///< a full storage forbids a start
};

/// Everything that a step looks at. Times are instants of the same clock as `now`.
struct SupervisorInputs {
  TimeUs now = 0;
  TimeUs last_message = 0;  ///< newest valid message of any kind from the autopilot
  bool has_odometry = false;
  VehicleState odometry;                         ///< newest received, whatever its numbers
  Vector3 reference_position = Vector3::Zero();  ///< [m] of the reference at odometry.time
  bool reference_at_rest = true;                 ///< of the reference at `now`
  TimeUs last_setpoint = 0;                      ///< newest set-point that the line has taken
  std::uint32_t autopilot_boots = 0;             ///< changes when the autopilot restarts
  bool armed = false;
  bool standing = false;      ///< armed, but control cannot begin yet: the frames are being tied
  bool in_our_mode = false;   ///< the autopilot reports the mode that flies our set-points
  bool airborne = false;      ///< by measured height; the tracking error counts only then
  bool engage = false;        ///< the operator wants the companion to fly; after a yield it must go off and on
  bool stop = false;          ///< the operator wants a stop
  bool landing = false;       ///< the mode in force is one that the companion itself asked for, to land or to let go
  bool goal_pending = false;  ///< there is a goal that the reference does not lead to
  std::uint32_t deadline_misses = 0;  ///< in a row
  std::uint32_t map_id = 0;           ///< CRC-32 of the map in use
  std::uint32_t plan_map_id = 0;      ///< of the map that the reference was planned in; map_id without a plan
  bool path_blocked = false;          ///< the rest of the reference meets something new
  bool storage_full = false;
  bool margins_covered = true;  ///< check_margins
};

/// What may be sent.
enum class Setpoints : std::uint8_t {
  kNone,      ///< nothing: silence hands over
  kPosition,  ///< the position form alone: measurements are not to be trusted, the autopilot closes the loop
  kAnyForm,   ///< the form in use
};

/// What to do now, in this order: shifts, hold, brake, set-points, plans.
struct Decision {
  FlightState state = FlightState::kIdle;
  Reason reason = Reason::kNone;  ///< of the state; in idle: what keeps it from ready
  Setpoints setpoints = Setpoints::kNone;
  TimeUs clock_shift = 0;  ///< TrajectoryStore::shift_clock, when not 0; forget the predictor's commands
  Vector3 position_shift = Vector3::Zero();  ///< TrajectoryStore::shift_position, when not 0
  bool hold_here = false;                    ///< TrajectoryStore::hold at the measured position
  bool brake = false;                        ///< TrajectoryStore::brake
  bool may_plan = false;                     ///< a plan begun now may be flown
  bool replan = false;                       ///< ... and is wanted
  bool may_ask_for_control = false;          ///< mode and arming commands are allowed
};

/// One line of the flight's history.
struct FlightEvent {
  TimeUs time = 0;
  FlightState from = FlightState::kIdle;
  FlightState to = FlightState::kIdle;  ///< equal to `from` for what is only noted
  Reason reason = Reason::kNone;
};

/// Watches ages and limits and decides who flies and whether (docs/flight.md tabulates fault, detection time and
/// reaction). It reads no clock and touches nothing: the same inputs give the same decisions, so a flight can be
/// replayed. The pilot always wins: any mode change is a yield, and so is the loss of a mode or an arming that was
/// granted before control began; after a yield nothing is sent or asked for until the operator engages anew.
class Supervisor {
 public:
  static constexpr std::size_t kEvents = 64;

  explicit Supervisor(const SupervisorSettings& settings) : settings_(settings) {}

  /// By how much the clock has jumped if this step is made at `now`; 0: not at all. For timers of the caller's.
  [[nodiscard]] TimeUs clock_jump(TimeUs now) const;

  /// To be called at a steady rate; reactions are as quick as that.
  Decision step(const SupervisorInputs& inputs);

  [[nodiscard]] FlightState state() const { return state_; }

  /// Events ever noted; the newest kEvents of them are kept, event(n) for event_count() - kEvents <= n < event_count().
  [[nodiscard]] std::uint32_t event_count() const { return event_count_; }
  [[nodiscard]] const FlightEvent& event(std::uint32_t n) const { return events_[n % kEvents]; }

 private:
  [[nodiscard]] bool in_control() const;
  [[nodiscard]] TimeUs age(TimeUs stamp, TimeUs now) const;
  void note_clock(TimeUs now, Decision& decision);
  void note_odometry(const SupervisorInputs& inputs, Decision& decision);
  void note_storage(const SupervisorInputs& inputs);
  void note_operator(const SupervisorInputs& inputs);
  [[nodiscard]] Reason odometry_fault(TimeUs now) const;
  [[nodiscard]] Reason start_fault(const SupervisorInputs& inputs) const;
  [[nodiscard]] Reason taken_back(const SupervisorInputs& inputs) const;
  [[nodiscard]] Reason yield_fault(const SupervisorInputs& inputs) const;
  [[nodiscard]] Reason tracking_fault(const SupervisorInputs& inputs, const Decision& decision) const;
  [[nodiscard]] Reason brake_fault(const SupervisorInputs& inputs, const Decision& decision) const;
  void note(const FlightEvent& event);
  void enter(FlightState state, Reason reason, TimeUs now);
  void step_out_of_control(const SupervisorInputs& inputs);
  void prepare(const SupervisorInputs& inputs, Reason fault);
  void step_in_control(const SupervisorInputs& inputs, Decision& decision);
  void fill(const SupervisorInputs& inputs, Decision& decision) const;

  SupervisorSettings settings_;
  FlightState state_ = FlightState::kIdle;
  Reason reason_ = Reason::kNone;

  bool stepped_ = false;
  TimeUs last_step_ = 0;
  TimeUs step_gap_ = 0;
  TimeUs clock_shift_ = 0;  // of the last jump, for stamps made before it
  TimeUs clock_jumped_at_ = 0;

  bool has_odometry_ = false;
  bool odometry_invalid_ = false;   // what came last was unusable
  VehicleState odometry_;           // last good one
  Real tracking_error_ = 0;         // [m] of the last good one
  Reason latched_ = Reason::kNone;  // a fault that only the operator can clear

  bool was_engaged_ = false;
  bool engaged_anew_ = false;
  bool had_mode_ = false;  // since engaged, and ready
  bool was_armed_ = false;
  std::uint32_t boots_ = 0;
  bool storage_was_full_ = false;
  TimeUs blocked_since_ = 0;  // the last step at which the path was free

  std::uint32_t event_count_ = 0;
  std::array<FlightEvent, kEvents> events_;
};

}  // namespace swiftlet
