#include "swiftlet/hover_thrust.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/flatness.hpp"

namespace swiftlet {
namespace {

constexpr Real kLeastLift = Real(0.3) * kGravity;  // [m/s^2] mean below which the ratio says little

}  // namespace

HoverThrustEstimator::HoverThrustEstimator(const HoverThrustSettings& settings)
    : settings_(settings), hover_(settings.initial) {}

bool HoverThrustEstimator::begin_with(Real hover) {
  if (learnt_ || !std::isfinite(hover)) return false;
  hover_ = std::clamp(hover, settings_.least, settings_.most);
  return true;
}

void HoverThrustEstimator::open(TimeUs time, Real climb) {
  open_ = true;
  window_start_ = last_ = time;
  first_climb_ = climb;
  vertical_impulse_ = 0;
}

void HoverThrustEstimator::update(TimeUs time, Real climb, Real cos_tilt, Real sent) {
  const bool usable = std::fabs(climb) < kLargestInput && cos_tilt > Real(0.5) && cos_tilt < Real(1.01) &&
                      sent > Real(0.01) && sent <= 1;
  if (!usable) return pause();
  if (!open_ || time <= last_ || time - last_ > settings_.window) return open(time, climb);
  vertical_impulse_ += sent * cos_tilt * to_seconds(time - last_);
  last_ = time;
  if (time - window_start_ < settings_.window) return;
  const Real duration = to_seconds(time - window_start_);
  const Real lift = (climb - first_climb_) / duration + kGravity;
  if (lift > kLeastLift) {
    const Real measured = kGravity * vertical_impulse_ / duration / lift;
    const Real share = duration / (settings_.time_constant + duration);
    hover_ = std::clamp(hover_ + share * (measured - hover_), settings_.least, settings_.most);
    learnt_ = true;
  }
  open(time, climb);
}

Real HoverThrustEstimator::normalised(Real specific_thrust) const {
  if (!(std::fabs(specific_thrust) < kLargestInput)) return hover_;
  return std::clamp(specific_thrust / kGravity * hover_, Real(0), Real(1));
}

}  // namespace swiftlet
