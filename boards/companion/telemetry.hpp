#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "swiftlet/certificate.hpp"
#include "swiftlet/margin_ledger.hpp"
#include "swiftlet/mavlink/link.hpp"
#include "swiftlet/status.hpp"
#include "swiftlet/supervisor.hpp"
#include "swiftlet/tracking_controller.hpp"
#include "swiftlet/trajectory.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet::companion {

/// Where in a flight the companion is; the supervisor's state says who flies.
enum class Phase : std::uint8_t {
  kGround,   ///< before the take-off: waiting, asking for mode and arming, aligning the frames
  kTakeoff,  ///< climbing, until the measured height is reached and our own control has settled
  kMission,  ///< goal after goal, or holding
  kLanding,  ///< the autopilot's land mode is asked for, or lands
  kDone,     ///< disarmed after a flight
};
const char* describe(Phase phase);

/// The plan that is flown or will be. Spans live until the plan after the next one is committed.
struct CommittedPlan {
  std::uint32_t id = 0;  ///< counts committed plans; 0: none yet
  TimeUs start = 0;      ///< from when on it is flown
  State from;            ///< the states that it was planned between
  State goal;
  std::span<const Segment> segments;
  std::span<const Box> boxes;  ///< [m] one a segment
  Certificate certificate;
  Status status = Status::kBadRequest;  ///< kOk or kFallback
  std::uint32_t map_crc = 0;            ///< of the map that it was planned in
  TimeUs latency = 0;                   ///< from the trigger (goal, limits, block) to the commitment, in steps' time
};

/// What the last step saw and did.
struct Telemetry {
  TimeUs time = 0;
  FlightState state = FlightState::kIdle;
  Reason reason = Reason::kNone;
  Phase phase = Phase::kGround;

  bool has_estimate = false;
  VehicleState estimate;  ///< frame W, newest received, at its own time

  bool has_reference = false;
  Reference reference;      ///< at `time`, frame W
  Real tracking_error = 0;  ///< [m] estimate to reference at the estimate's time

  Setpoints setpoints = Setpoints::kNone;       ///< what was allowed
  bool sent = false;                            ///< whether the line took the set-point
  SetpointForm form = SetpointForm::kPosition;  ///< of the set-point
  TrackingCommand command;                      ///< its numbers, in all forms
  Real thrust = 0;                              ///< 0 to 1, as sent with attitude and rates
  Real hover_thrust = 0;                        ///< as learnt
  TimeUs link_delay = 0;                        ///< one way, half of the shortest round trip

  CommittedPlan plan;
  std::uint32_t goals_reached = 0;
  std::uint32_t goals_waiting = 0;  ///< the one that is flown to included
  std::uint32_t plans_discarded = 0;
  std::uint32_t deadline_misses = 0;  ///< late plans, ever

  bool aligned = false;
  bool armed = false;
  mavlink::Mode mode = mavlink::Mode::kUnknown;
  mavlink::AutopilotKind autopilot = mavlink::AutopilotKind::kUnknown;
  std::uint16_t battery_mv = 0xFFFF;
  mavlink::LinkCounters link;
  mavlink::CodecCounters codec;
  std::uint64_t signing_time = 0;  ///< [10 us since 2015] of the newest signature; 0: none
};

/// A line for people: what the companion did, refused, or heard. Goes to the console, the log, and as STATUSTEXT over
/// the link.
struct Note {
  TimeUs time = 0;
  mavlink::Severity severity = mavlink::Severity::kInfo;
  std::array<char, 120> text{};

  [[nodiscard]] std::string_view view() const {
    std::size_t size = 0;
    while (size < text.size() && text[size] != 0) ++size;
    return {text.data(), size};
  }
};

}  // namespace swiftlet::companion
