#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "report/grid_boxes.hpp"
#include "swiftlet/flatness.hpp"
#include "swiftlet/supervisor.hpp"
#include "swiftlet/trajectory.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet::tools {

/// What a page replays of a flight (flight_report.hpp). All times are [s] since the flight's beginning, on one clock;
/// all positions [m] and velocities [m/s] are in frame W; texts are UTF-8.

/// One moment. Counters count from the flight's beginning; the page makes rates of them.
struct RecordedSample {
  double t = 0;
  FlightState state = FlightState::kIdle;
  bool has_reference = false;  ///< without one there is no tracking error
  Vector3 reference = Vector3::Zero();
  Vector3 reference_velocity = Vector3::Zero();
  bool has_estimate = false;
  Vector3 estimate = Vector3::Zero();  ///< what the companion took for the position at `t`
  Vector3 position = Vector3::Zero();  ///< true p_WB
  Vector3 velocity = Vector3::Zero();  ///< true
  Quaternion attitude{1, 0, 0, 0};     ///< true q_WB, body forward-left-up
  std::uint64_t setpoints = 0;         ///< sent by the companion
  std::uint64_t bytes_in = 0;          ///< of the link, as the companion sees it
  std::uint64_t bytes_out = 0;
};

/// A plan from its commitment to that of the next one.
struct RecordedPlan {
  double committed = 0;
  double begins = 0;  ///< when its first segment begins; earlier or later than `committed`
  std::vector<Box> boxes;
  std::vector<Segment> segments;  ///< segment i in box i
};

/// What an event is about: the first three happen in the companion, the last is done to it.
enum class EventKind : std::uint8_t {
  kNote,      ///< a phase, a plan, a mode
  kArrival,   ///< a goal was reached
  kReaction,  ///< a transition of the supervisor that a fault caused
  kFault,     ///< a fault began or ended
};

struct RecordedEvent {
  double t = 0;
  EventKind kind = EventKind::kNote;
  std::string what;
};

/// A part of the flight (on the ground, take-off, mission, landing) from `t` to the next one's. Where there are any,
/// the page shows the tracking error in those named "mission".
struct RecordedPhase {
  double t = 0;
  std::string name;
};

struct FlightRecord {
  std::vector<RecordedSample> samples;  ///< t ascending, about 50 Hz or more; the page thins what it need not show
  std::vector<RecordedPhase> phases;    ///< t ascending; may be empty
  std::vector<RecordedPlan> plans;      ///< `committed` ascending; may be empty
  std::vector<RecordedEvent> events;    ///< t ascending
  std::vector<Vector3> goals;           ///< in their order
  GridBoxes obstacles;                  ///< of the flight's map, best merged (map/obstacles.hpp); may be empty
  double vehicle_radius = 0.25;         ///< [m] centre to the tips of the propellers: the size of the drawn vehicle
  double tracking_tube = 0;             ///< [m] beyond which the companion brakes; 0: not known
  double speed_limit = 0;               ///< [m/s]; 0: none
  bool speed_limit_per_axis = true;     ///< else it is the norm's
  double line_rate = 0;                 ///< [byte/s] that the link's line carries in each direction; 0: not known
};

}  // namespace swiftlet::tools
