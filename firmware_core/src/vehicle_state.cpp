#include "swiftlet/vehicle_state.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

const Vector3 kWeight{0, 0, kGravity};

bool is_sane(const Vector3& v) { return (v.array().abs() <= kLargestInput).all(); }

/// Attitude after turning with constant body rates for `dt`.
Quaternion turned(const Quaternion& q, const Vector3& omega, Real dt) {
  const Vector3 half = omega * (dt / 2);
  const Real angle = half.norm();
  const Real sinc = angle > Real(1e-4) ? std::sin(angle) / angle : 1 - angle * angle / 6;
  const Quaternion turn(std::cos(angle), half.x() * sinc, half.y() * sinc, half.z() * sinc);
  return to_quaternion((q * turn).toRotationMatrix());
}

/// A point mass whose acceleration follows the commanded one with a first-order lag.
struct Motion {
  Vector3 position;
  Vector3 velocity;
  Vector3 acceleration;

  // The implicit step is stable whatever the lag, and needs no exponential.
  void advance(const Vector3& wanted, Real lag, Real dt) {
    acceleration += (wanted - acceleration) * (dt / (lag + dt));
    position += velocity * dt + acceleration * (dt * dt / 2);
    velocity += acceleration * dt;
  }
};

}  // namespace

bool is_usable(const VehicleState& state) {
  const Real norm2 = state.attitude.coeffs().squaredNorm();
  return is_sane(state.position) && is_sane(state.velocity) && is_sane(state.body_rates) && norm2 > Real(0.81) &&
         norm2 < Real(1.21);
}

void StatePredictor::record(TimeUs time, const Vector3& commanded, const Vector3& compensation) {
  if (!is_sane(commanded) || !is_sane(compensation) || (count_ > 0 && time <= command(0).time)) return;
  commands_[next_] = {time, commanded, compensation};
  next_ = (next_ + 1) % kCommands;
  count_ = std::min(count_ + 1, kCommands);
}

VehicleState StatePredictor::predict(const VehicleState& measured, TimeUs target) const {
  if (!is_usable(measured) || target <= measured.time) return measured;
  const TimeUs end = std::min(target, measured.time + settings_.longest);
  // From the oldest command that matters: the one in force at the measurement.
  std::size_t age = 0;
  while (age < count_ && command(age).time > measured.time) ++age;
  Motion motion{measured.position, measured.velocity, Vector3::Zero()};
  if (age < count_) {
    const Real thrust = (command(age).commanded + kWeight).norm();
    motion.acceleration = measured.attitude.toRotationMatrix().col(2) * thrust - kWeight - command(age).compensation;
  }
  TimeUs now = measured.time;
  for (std::size_t left = age + 1; left > 0 && now < end; --left) {
    const bool known = left - 1 < count_;  // false only before the first command
    const TimeUs until = left == 1 ? end : std::min(end, command(left - 2).time);
    Vector3 flown = Vector3::Zero();
    if (known) flown = command(left - 1).commanded - command(left - 1).compensation;
    motion.advance(flown, settings_.response_time, to_seconds(until - now));
    now = until;
  }
  VehicleState predicted = measured;
  predicted.time = target;
  predicted.position = motion.position;
  predicted.velocity = motion.velocity;
  predicted.attitude = turned(measured.attitude, measured.body_rates, to_seconds(end - measured.time));
  return predicted;
}

}  // namespace swiftlet
