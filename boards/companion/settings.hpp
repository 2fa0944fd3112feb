#pragma once
#include <cstdint>
#include <optional>

#include "swiftlet/corridor.hpp"
#include "swiftlet/corridor_search.hpp"
#include "swiftlet/flight_limits.hpp"
#include "swiftlet/flight_time.hpp"
#include "swiftlet/hover_thrust.hpp"
#include "swiftlet/margin_ledger.hpp"
#include "swiftlet/mavlink/codec.hpp"
#include "swiftlet/supervisor.hpp"
#include "swiftlet/tracking_controller.hpp"
#include "swiftlet/trajectory_planner.hpp"
#include "swiftlet/types.hpp"
#include "swiftlet/vehicle_state.hpp"
#include "swiftlet/yaw.hpp"

namespace swiftlet::companion {

/// What the vehicle's size, the map's and the numbers' errors take of the map's radius; the tracking tube comes on top.
struct Margins {
  Real vehicle_radius = Real(0.2);    ///< [m] centre to the outermost part
  Real map_error = Real(0.05);        ///< [m] scan, registration, alignment
  Real numeric_margin = Real(0.001);  ///< [m] the certificate's tolerance
  TrackingTubes tubes;                ///< [m] by the set-point form in use
  Real heading_accuracy = 0;          ///< [rad] of the autopilot while the frames are tied, at worst; 0: not budgeted
};

/// What the frames' tie is worth after flights that began where the one before had ended.
struct Tie {
  std::uint32_t readings = 1;  ///< of the autopilot's heading, each with an error of its own, that it rests on
  Real error = 0;              ///< [m] of the place, by the headings before
};

/// How long a set-point sent now takes until the vehicle answers it, beyond the way over the link, which is measured
/// [us]. The reference is sampled that much ahead.
struct CommandDelays {
  TimeUs position = 150'000;  ///< PX4's position loop was seen 0.16 to 0.22 s late
  TimeUs attitude = 80'000;   ///< its attitude loop
  TimeUs rates = 0;
};

/// Gains and bounds of the controller by the form in use; the position form leaves control to the autopilot.
struct ControllerGains {
  ControllerSettings attitude;
  ControllerSettings rates;
};

struct TakeoffSettings {
  Real height = 1;              ///< [m] above the start, at least; where nothing is free there, the next free above
  Real tolerance = Real(0.15);  ///< [m] of measured height below it at which the climb is over
  TimeUs patience = 20 * kSecondUs;  ///< from arming to that height; then the flight ends by the autopilot's landing
  TimeUs standing = 5 * kSecondUs;   ///< after arming, on the ground: the pose is averaged over it for the alignment
};

struct PlanningSettings {
  TimeUs latency = 50'000;  ///< worst case from a plan's beginning to its offer; the splice lies that far ahead
  /// The deadline is 4 to 7 ms of linux-x86_64: a plan from motion for which all ways fail would take some hundred, and
  /// a word in flight shall be answered within 10 ms.
  WorkBudget budget{.deadline = 100'000};
  SearchOptions search;
  CorridorKind corridor = CorridorKind::kExtents;
};

/// Everything that can be configured (docs/flight.md tabulates the keys). The same values on every board.
struct Settings {
  std::uint8_t system_id = 1;  ///< of the vehicle
  SetpointForm form = SetpointForm::kAttitude;

  Vector3 start = Vector3::Zero();  ///< [m] frame W: where the vehicle stands when it is armed, on the ground
  Real start_yaw = 0;               ///< [rad] from east, anticlockwise

  FlightLimits limits{.v_max = 1, .a_max = 2, .j_max = kUnlimited, .norm = LimitNorm::kAxis, .vehicle = {}};
  Margins margins;
  TakeoffSettings takeoff;
  Real arrival_tolerance = Real(0.1);  ///< [m] of the vehicle to a goal when the reference has come to rest there
  bool engage_at_start = false;        ///< fly as soon as all is well, without a word of the operator
  bool land_at_end = false;            ///< when the last goal is reached

  PlanningSettings planning;
  YawSettings yaw;
  ControllerGains control;
  CommandDelays delays;
  PredictorSettings predictor;
  HoverThrustSettings hover_thrust;
  bool asks_hover_thrust = true;  ///< what the autopilot answers takes the place of hover_thrust.initial
  SupervisorSettings supervisor;  ///< its tracking tube is taken from `margins`

  // Not in the configuration file: a key has a file of its own.
  std::optional<mavlink::Signing> signing{};
  bool autopilot_signs = false;
};

/// Whether every number is finite and in range; what is wrong otherwise, nullptr when nothing is.
const char* find_fault(const Settings& settings);

/// The margin ledger for the form in use against the radius [m] that a map was inflated by.
MarginReport margins_of(const Settings& settings, Real map_radius, const Tie& tie = {});

}  // namespace swiftlet::companion
