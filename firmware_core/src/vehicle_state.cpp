#include "swiftlet/vehicle_state.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/trigonometry.hpp"

namespace swiftlet {
namespace {

const Vector3 kWeight{0, 0, kGravity};
constexpr TimeUs kLongestGap = 100'000;  // [us] between two measurements that tell an acceleration

bool is_sane(const Vector3& v) { return (v.array().abs() <= kLargestInput).all(); }

Vector3 thrust_axis(const VehicleState& state) { return state.attitude.normalized().toRotationMatrix().col(2); }

/// Attitude after turning with constant body rates for `dt`.
Quaternion turned(const Quaternion& q, const Vector3& omega, Real dt) {
  const Vector3 half = omega * (dt / 2);
  const Real angle = half.norm();
  const Real sinc = angle > Real(1e-4) ? sine(angle) / angle : 1 - angle * angle / 6;
  const Quaternion turn(cosine(angle), half.x() * sinc, half.y() * sinc, half.z() * sinc);
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

void StatePredictor::reset() {
  count_ = 0;
  learns_ = false;
  disturbance_.setZero();
}

void StatePredictor::record(TimeUs time, const Vector3& commanded, Real thrust) {
  const bool usable = is_sane(commanded) && std::fabs(thrust) <= kLargestInput;
  if (!usable || (count_ > 0 && time <= command(0).time)) return;
  commands_[next_] = {time, commanded, thrust};
  next_ = (next_ + 1) % kCommands;
  count_ = std::min(count_ + 1, kCommands);
}

/// Age of the command in force at `time`, counted from the newest; count_ when all came later.
std::size_t StatePredictor::age_in_force(TimeUs time) const {
  std::size_t age = 0;
  while (age < count_ && command(age).time > time) ++age;
  return age;
}

/// Mean of the thrust after the motors' lag; advances it.
Real StatePredictor::mean_thrust(TimeUs from, TimeUs to) {
  Real impulse = 0;
  TimeUs now = from;
  for (std::size_t left = age_in_force(from) + 1; left > 0 && now < to; --left) {
    const TimeUs until = left == 1 ? to : std::clamp(command(left - 2).time, now, to);
    const Real dt = to_seconds(until - now);
    const Real wanted = left - 1 < count_ ? command(left - 1).thrust : thrust_;
    thrust_ += (wanted - thrust_) * (dt / (settings_.thrust_time + dt));
    impulse += thrust_ * dt;
    now = until;
  }
  return impulse / to_seconds(to - from);
}

void StatePredictor::learn(const VehicleState& measured) {
  if (!is_usable(measured) || (learns_ && measured.time == last_.time)) return;
  const TimeUs gap = measured.time - last_.time;
  if (learns_ && gap > 0 && gap <= kLongestGap) {
    const Real dt = to_seconds(gap);
    const Vector3 axis = (thrust_axis(last_) + thrust_axis(measured)) / 2;
    const Vector3 shown =
        (measured.velocity - last_.velocity) / dt + kWeight - axis * mean_thrust(last_.time, measured.time);
    const Vector3 bound = Vector3::Constant(settings_.disturbance_max);
    disturbance_ += (shown.cwiseMax(-bound).cwiseMin(bound) - disturbance_) * (dt / (settings_.disturbance_time + dt));
  } else {
    const std::size_t age = age_in_force(measured.time);
    thrust_ = age < count_ ? command(age).thrust : kGravity;
  }
  learns_ = true;
  last_ = measured;
}

VehicleState StatePredictor::predict(const VehicleState& measured, TimeUs target) const {
  if (!is_usable(measured) || target <= measured.time) return measured;
  const TimeUs end = std::min(target, measured.time + settings_.longest);
  // From the oldest command that matters: the one in force at the measurement.
  const std::size_t age = age_in_force(measured.time);
  Motion motion{measured.position, measured.velocity, disturbance_};
  if (age < count_) motion.acceleration += thrust_axis(measured) * command(age).thrust - kWeight;
  TimeUs now = measured.time;
  for (std::size_t left = age + 1; left > 0 && now < end; --left) {
    const bool known = left - 1 < count_;  // false only before the first command
    const TimeUs until = left == 1 ? end : std::min(end, command(left - 2).time);
    Vector3 wanted = disturbance_;
    if (known) wanted += command(left - 1).commanded;
    motion.advance(wanted, settings_.response_time, to_seconds(until - now));
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
