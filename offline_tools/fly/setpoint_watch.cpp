#include "fly/setpoint_watch.hpp"

namespace swiftlet::tools {
namespace {

using Contents = std::array<double, 11>;

Contents contents_of(const mavlink::SetPositionTarget& target) {
  const Vector3& p = target.position.value;
  const Vector3& v = target.velocity.value;
  const Vector3& a = target.acceleration.value;
  return {p.x(), p.y(), p.z(), v.x(), v.y(), v.z(), a.x(), a.y(), a.z(), target.yaw, target.yaw_rate};
}

Contents contents_of(const mavlink::SetAttitudeTarget& target) {
  const auto& q = target.attitude.value;
  const Vector3& w = target.body_rates.value;
  return {q.w(), q.x(), q.y(), q.z(), w.x(), w.y(), w.z(), target.thrust};
}

}  // namespace

void SetpointWatch::begin_step(Microseconds now) {
  now_ = now;
  sent_in_step_ = 0;
  repeated_ = false;
}

std::size_t SetpointWatch::write(std::span<const std::byte> bytes) {
  const std::size_t taken = uart_.write(bytes);
  sent_bytes_ += taken;
  std::span<const std::byte> rest = bytes.first(taken);
  while (const std::optional<mavlink::Frame> frame = codec_.receive(rest)) {
    if (const auto target = mavlink::decode<mavlink::SetPositionTarget>(*frame)) {
      see(target->time_boot_ms, contents_of(*target));
    } else if (const auto attitude = mavlink::decode<mavlink::SetAttitudeTarget>(*frame)) {
      see(attitude->time_boot_ms, contents_of(*attitude));
    }
  }
  return taken;
}

std::size_t SetpointWatch::read(std::span<std::byte> into) {
  const std::size_t count = uart_.read(into);
  received_bytes_ += count;
  return count;
}

void SetpointWatch::see(std::uint32_t time_boot_ms, const Contents& contents) {
  constexpr Microseconds kNewStream{250'000};
  ++count_;
  ++sent_in_step_;
  const bool of_this_step = time_boot_ms == static_cast<std::uint32_t>(now_ / std::chrono::milliseconds(1));
  if (!of_this_step || sent_in_step_ > 1) ++stale_;
  repeated_ = contents == last_;
  last_ = contents;
  const Microseconds instant = clock_.now();
  if (last_instant_.count() >= 0 && instant - last_instant_ < kNewStream) intervals_.push_back(instant - last_instant_);
  last_instant_ = instant;
}

}  // namespace swiftlet::tools
