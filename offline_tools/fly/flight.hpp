#pragma once
#include <optional>
#include <string>
#include <vector>

#include "companion/companion.hpp"
#include "fly/fillable_storage.hpp"
#include "fly/flight_fault.hpp"
#include "fly/flight_planner.hpp"
#include "fly/floor.hpp"
#include "report/flight_record.hpp"
#include "sim/pixhawk_sim.hpp"

namespace swiftlet::tools {

/// A flight of the companion against the simulated vehicle and autopilot.
struct FlightRequest {
  Vector3 start = Vector3::Zero();  ///< [m] frame W: where the take-off ends; the vehicle stands on the pad below it
  double yaw = 0;                   ///< [rad] there, from east
  std::vector<Vector3> goals;       ///< [m] flown to one after the other; then it lands
  companion::Settings companion;    ///< start, take-off height and what begins and ends a flight are filled in
  PixhawkSimSettings sim;           ///< start, obstacles, faults and the autopilot's frame are filled in
  std::vector<FlightFault> faults;
  bool in_process = true;  ///< in lock-step; else in real time over a pseudo-terminal
  double longest = 1800;   ///< [s] after which the flight is given up
};

/// How a fault was answered.
struct FaultAnswer {
  std::string fault;
  double at;  ///< [s] when it began
  /// The first transition or note that the supervisor gave a fault's reason for, between this fault and the next one.
  std::optional<double> after;  ///< [s] from its beginning
  std::string what;
  /// From then until the reference rested, or nothing was sent any more [s].
  std::optional<double> settled;
};

/// What the companion sent, seen at its device.
struct SetpointReport {
  std::uint32_t count = 0;
  std::uint32_t stale = 0;     ///< with another time than that of the step, or a second one in it: must be 0
  std::uint32_t repeated = 0;  ///< with the numbers of the one before while the reference moved: must be 0
  double interval_p50 = 0;     ///< [s]
  double interval_p99 = 0;
  double jitter_p99 = 0;  ///< [s] of the difference to the step
  double interval_max = 0;
};

struct FlightReport {
  std::string status;                      ///< "arrived", or a word for why not
  std::string reason;                      ///< the same for people; empty when arrived
  FlightState state = FlightState::kIdle;  ///< at the end, or before the landing
  bool landed = false;
  std::uint32_t goals_reached = 0;
  std::vector<double> arrivals;  ///< [s] when each goal was reached

  // From the end of the take-off to the start of the landing.
  double tracking_rms = 0;  ///< [m] not finite without such a span
  double tracking_max = 0;
  double estimate_rms = 0;  ///< [m] of the companion's newest estimate, its age included, to the true position
  double estimate_max = 0;
  double clearance = 0;              ///< [m] of the true centre to occupied voxels, while the companion was in control
  std::optional<double> touched_at;  ///< [s] when it first was the vehicle's radius or less
  double begin = 0;                  ///< [s]
  double end = 0;
  double speed_max = 0;                              ///< [m/s] of the vehicle
  Vector3 reference_speed = Vector3::Zero();         ///< [m/s] largest of the reference, per axis
  Vector3 reference_acceleration = Vector3::Zero();  ///< [m/s^2]
  double reference_speed_norm = 0;                   ///< [m/s]
  double reference_acceleration_norm = 0;            ///< [m/s^2]
  double load_in = 0;                                ///< share of a line of 921,600 baud
  double load_out = 0;

  double duration = 0;   ///< [s] from the end of the take-off to the arrival, or to the end of the flight
  double simulated = 0;  ///< [s] all of it
  double lag_max = 0;    ///< [s] in real time: how far the simulation fell behind the wall's clock
  mavlink::LinkCounters link;
  mavlink::CodecCounters codec;
  SetpointReport setpoints;
  std::vector<FaultAnswer> answers;
  FlightRecord record;  ///< without the map's obstacles
};

/// What a flight needs beside its request.
struct FlightWorld {
  const BoxGraphView& map;
  const std::vector<Box>& obstacles;  ///< the source map's occupied voxels [m], frame W
  companion::Memory memory;
  FlightPlanner& planner;
  companion::FlightLog* log = nullptr;  ///< begun
  FillableStorage* storage = nullptr;   ///< of the log; what the fault `storage-full` fills
};

/// The companion's settings in that flight, for its log.
companion::Settings settings_of(const FlightRequest& request, const BoxGraphView& map,
                                const std::vector<Box>& obstacles);

/// Flies. In lock-step the same request gives the same report, but for the times that planning took.
/// Error: exit status 3, no pseudo-terminal could be had.
Expected<FlightReport> fly(const FlightRequest& request, const FlightWorld& world);

/// A word for a reason, in the report's `status`: "link_lost".
const char* to_word(Reason reason);

}  // namespace swiftlet::tools
