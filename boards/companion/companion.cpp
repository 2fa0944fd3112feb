#include "companion.hpp"

namespace swiftlet::companion {

const char* describe(Phase phase) {
  switch (phase) {
    case Phase::kGround:
      return "ground";
    case Phase::kTakeoff:
      return "take-off";
    case Phase::kMission:
      return "mission";
    case Phase::kLanding:
      return "landing";
    case Phase::kDone:
      return "done";
  }
  return "unknown phase";
}

const char* find_fault(const Settings& settings) { return is_usable(settings.limits) ? nullptr : "limits"; }

Companion::Companion(const Settings& settings, const BoxGraphView& map, const Memory& memory, const Devices& devices)
    : settings_(settings), map_(map), link_(devices.autopilot, {}), supervisor_(settings.supervisor) {
  (void)memory;
}

void Companion::step(std::chrono::microseconds now) {
  link_.step(now);
  telemetry_.time = now.count();
  telemetry_.link = link_.counters();
}

bool Companion::add_goal(const Vector3& position, std::optional<Real> /*yaw*/) { return position.allFinite(); }
bool Companion::set_goal(const Vector3& position, std::optional<Real> /*yaw*/) { return position.allFinite(); }
bool Companion::engage(bool /*on*/) { return true; }
bool Companion::stop() { return true; }
bool Companion::land() { return true; }
bool Companion::block(std::uint32_t /*id*/, const Box& /*obstacle*/) { return true; }
bool Companion::unblock(std::uint32_t /*id*/) { return true; }
bool Companion::set_limits(Real /*v_max*/, Real /*a_max*/) { return true; }
bool Companion::replace_map(const BoxGraphView& map) {
  map_ = map;
  return true;
}

}  // namespace swiftlet::companion
