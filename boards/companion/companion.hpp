#pragma once
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "plan_worker.hpp"
#include "settings.hpp"
#include "storage.hpp"
#include "swiftlet/box_graph_view.hpp"
#include "swiftlet/hal/uart.hpp"
#include "swiftlet/mavlink/link.hpp"
#include "swiftlet/supervisor.hpp"
#include "telemetry.hpp"

/// The flight application: the same on every board, in the simulator's loop and in a replay. docs/flight.md describes
/// it.
namespace swiftlet::companion {

class FlightLog;

/// What a companion works with; all of it outlives the companion.
struct Devices {
  hal::Uart& autopilot;
  PlanWorker& planner;
  FlightLog* log = nullptr;  ///< may be absent
};

/// Flies from goal to goal. A deterministic function of what enters: the time of each step, what the devices answered,
/// and the operator's words. No heap, no clock, no threads.
class Companion {
 public:
  static constexpr std::size_t kNotes = 32;

  /// `map` outlives the companion, as do the devices and the memory.
  Companion(const Settings& settings, const BoxGraphView& map, const Memory& memory, const Devices& devices);
  Companion(const Companion&) = delete;
  Companion& operator=(const Companion&) = delete;

  /// One step of the flight, to be made at a steady 100 Hz.
  void step(std::chrono::microseconds now);

  // The operator's words; they take effect in the next step, in order. False when they are refused at once: numbers
  // that are not finite, or no room.
  bool add_goal(const Vector3& position, std::optional<Real> yaw = {});  ///< [m] frame W; flown after those before it
  bool set_goal(const Vector3& position, std::optional<Real> yaw = {});  ///< flown to now, instead of all others
  bool engage(bool on);  ///< on: take off and fly, or take control anew; off: fall silent, the autopilot decides
  bool stop();           ///< brake, hold, forget all goals
  bool land();           ///< brake, then land where it is
  bool block(std::uint32_t id, const Box& obstacle);  ///< [m] frame W; keep out of it and the map's radius around
  bool unblock(std::uint32_t id);
  bool set_limits(Real v_max, Real a_max);  ///< [m/s] [m/s^2]; replans what is under way

  /// Another map from the next step on: the vehicle stops and plans anew. False, nothing having changed, when its
  /// radius does not cover the margins. Both maps outlive the companion.
  bool replace_map(const BoxGraphView& map);

  [[nodiscard]] const Telemetry& telemetry() const { return telemetry_; }
  [[nodiscard]] const Settings& settings() const { return settings_; }

  /// The supervisor's transitions; the newest Supervisor::kEvents are kept.
  [[nodiscard]] std::uint32_t event_count() const { return supervisor_.event_count(); }
  [[nodiscard]] const FlightEvent& event(std::uint32_t n) const { return supervisor_.event(n); }

  /// Lines for people; the newest kNotes are kept, note(n) for note_count() - kNotes <= n < note_count().
  [[nodiscard]] std::uint32_t note_count() const { return note_count_; }
  [[nodiscard]] const Note& note(std::uint32_t n) const { return notes_[n % kNotes]; }

 private:
  Settings settings_;
  BoxGraphView map_;
  mavlink::Link link_;
  Supervisor supervisor_;
  Telemetry telemetry_;
  std::uint32_t note_count_ = 0;
  std::array<Note, kNotes> notes_;
};

}  // namespace swiftlet::companion
