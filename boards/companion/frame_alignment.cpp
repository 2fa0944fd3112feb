#include "companion/frame_alignment.hpp"

#include <cmath>

namespace swiftlet::companion {
namespace {

constexpr Real kJump = Real(0.15);  // [m] from one estimate of a standing vehicle to the next

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

bool FrameAlignment::has_jumped() const { return (link_.local_vehicle().position - last_position_).norm() > kJump; }

void FrameAlignment::add_sample(TimeUs now) {
  const mavlink::VehicleState& local = link_.local_vehicle();
  if (!local.has_position || !local.has_attitude || local.position_count == last_sample_) return;
  last_sample_ = local.position_count;
  if (samples_ > 0 && has_jumped()) begin(now);
  last_position_ = local.position;
  const Real yaw = mavlink::yaw_of(local.attitude);
  position_sum_ += local.position;
  cos_sum_ += std::cos(yaw);
  sin_sum_ += std::sin(yaw);
  ++samples_;
}

bool FrameAlignment::step(TimeUs now) {
  if (aligned_) return true;
  if (tied_ && link_.local_vehicle().position_count == last_sample_) return false;
  if (tied_ && !has_jumped()) return aligned_ = true;
  if (!begun_ || tied_) {
    begin(now);
    last_sample_ = link_.local_vehicle().position_count;  // of before
  }
  add_sample(now);
  if (now - begun_at_ < standing_ || samples_ == 0) return false;
  const Vector3 mean = position_sum_ / static_cast<Real>(samples_);
  link_.align(mavlink::Alignment(mean, std::atan2(sin_sum_, cos_sum_), place_, place_yaw_));
  tied_ = true;
  return false;
}

}  // namespace swiftlet::companion
