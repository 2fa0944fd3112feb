#include "companion/frame_alignment.hpp"

#include "swiftlet/trigonometry.hpp"

namespace swiftlet::companion {
namespace {

// What a standing vehicle's estimate may do.
constexpr Real kJump = Real(0.15);   // [m] from one to the next
constexpr Real kWander = Real(0.3);  // [m] from the first one on
constexpr Real kSpeed = Real(0.5);   // [m/s]

}  // namespace

void FrameAlignment::stand_at(const Vector3& position, Real yaw) {
  place_ = position;
  place_yaw_ = yaw;
}

void FrameAlignment::forget() {
  begun_ = tied_ = aligned_ = false;
  samples_ = 0;
  position_sum_.setZero();
  cos_sum_ = sin_sum_ = 0;
}

void FrameAlignment::begin(TimeUs now) {
  forget();
  begun_ = true;
  begun_at_ = now;
}

bool FrameAlignment::moves() const {
  const mavlink::VehicleState& local = link_.local_vehicle();
  return (local.position - last_position_).norm() > kJump || (local.position - first_position_).norm() > kWander ||
         local.velocity.norm() > kSpeed;
}

void FrameAlignment::add_sample(TimeUs now) {
  const mavlink::VehicleState& local = link_.local_vehicle();
  if (!local.has_position || !local.has_attitude || local.position_count == last_sample_) return;
  last_sample_ = local.position_count;
  if (samples_ == 0) first_position_ = last_position_ = local.position;
  if (moves()) return begin(now);
  last_position_ = local.position;
  const Real yaw = mavlink::yaw_of(local.attitude);
  position_sum_ += local.position;
  cos_sum_ += cosine(yaw);
  sin_sum_ += sine(yaw);
  ++samples_;
}

bool FrameAlignment::step(TimeUs now) {
  if (aligned_) return true;
  if (tied_ && link_.local_vehicle().position_count == last_sample_) return false;
  if (tied_ && !moves()) return aligned_ = true;
  if (!begun_ || tied_) {
    begin(now);
    last_sample_ = link_.local_vehicle().position_count;  // of before
  }
  add_sample(now);
  if (now - begun_at_ < standing_ || samples_ == 0) return false;
  const Vector3 mean = position_sum_ / static_cast<Real>(samples_);
  link_.align(mavlink::Alignment(mean, angle_of(sin_sum_, cos_sum_), place_, place_yaw_));
  tied_ = true;
  return false;
}

}  // namespace swiftlet::companion
