#include "swiftlet/yaw.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/flatness.hpp"
#include "swiftlet/trigonometry.hpp"

namespace swiftlet {

Real wanted_yaw(const YawSettings& settings, const Vector3& position, const Vector3& ahead, Real current) {
  if (settings.mode == YawMode::kFixed) return wrap_angle(settings.angle);
  const Vector3 way = (settings.mode == YawMode::kTowards ? settings.target : ahead) - position;
  const Real distance2 = way.x() * way.x() + way.y() * way.y();
  const bool has_direction = distance2 >= settings.least_distance * settings.least_distance;  // false for NaN
  return has_direction ? angle_of(way.y(), way.x()) : current;
}

YawState step_yaw(const YawSettings& settings, const YawState& state, Real wanted, Real dt) {
  const bool usable = std::isfinite(state.yaw) && std::isfinite(state.rate) && std::fabs(wanted) <= kLargestInput &&
                      dt > 0 && dt <= 1 && settings.rate_max > 0 && settings.acceleration_max > 0;
  if (!usable) return state;
  const Real error = wrap_angle(wanted - state.yaw);
  const Real change = settings.acceleration_max * dt;
  // The highest rate from which the rest of the way suffices to stop in whole steps: a continuous sqrt(2 a e) would
  // overshoot by half a step's change.
  const Real stoppable = std::sqrt(2 * settings.acceleration_max * std::fabs(error) + change * change / 4) - change / 2;
  const Real rate_wanted = std::copysign(std::min({settings.rate_max, stoppable, std::fabs(error) / dt}), error);
  const Real lowest = std::max(state.rate - change, -settings.rate_max);
  const Real highest = std::min(state.rate + change, settings.rate_max);
  YawState next;
  next.rate = lowest <= highest ? std::clamp(rate_wanted, lowest, highest) : state.rate;
  next.yaw = wrap_angle(state.yaw + next.rate * dt);
  return next;
}

}  // namespace swiftlet
