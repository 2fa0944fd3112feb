#pragma once
#include <cstdint>

#include "swiftlet/types.hpp"

namespace swiftlet {

/// Where the nose points.
enum class YawMode : std::uint8_t {
  kFixed,      ///< `angle`
  kAlongPath,  ///< where the vehicle goes: a forward camera sees the way before it is flown
  kTowards,    ///< the point `target`
};

struct YawSettings {
  YawMode mode = YawMode::kAlongPath;
  Real angle = 0;                    ///< [rad] kFixed; anticlockwise from east
  Vector3 target = Vector3::Zero();  ///< [m] kTowards
  Real rate_max = Real(1.5);         ///< [rad/s] > 0
  Real acceleration_max = 3;         ///< [rad/s^2] > 0
  Real look_ahead = Real(0.5);       ///< [s] kAlongPath: the nose points at the reference this far ahead
  Real least_distance = Real(0.1);   ///< [m] horizontal way below which a direction is none: the yaw stays
};

/// Yaw with its rate: [rad] in (-pi, pi], [rad/s].
struct YawState {
  Real yaw = 0;
  Real rate = 0;
};

/// The heading wanted at `position` when the reference will be at `ahead` after the look-ahead time; `current` where
/// there is no direction. Always finite for finite arguments.
Real wanted_yaw(const YawSettings& settings, const Vector3& position, const Vector3& ahead, Real current);

/// One step of `dt` [s] towards `wanted`, the shorter way round: at most rate_max, changed by at most acceleration_max,
/// slowing down in time, so that a constant goal is met without overshoot beyond one step. Numbers that are not finite,
/// or dt <= 0, leave the state as it was.
YawState step_yaw(const YawSettings& settings, const YawState& state, Real wanted, Real dt);

}  // namespace swiftlet
