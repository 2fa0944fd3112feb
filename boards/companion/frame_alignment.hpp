#pragma once
#include <cstdint>

#include "swiftlet/flight_time.hpp"
#include "swiftlet/mavlink/link.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet::companion {

/// Ties the autopilot's local frame to the map's at arming: the vehicle stands at a known pose, and what the autopilot
/// believes it to be is averaged over a while, since the estimate wanders by centimetres and its origin drifts before.
/// An estimate that jumps, wanders off or moves meanwhile begins the averaging anew.
class FrameAlignment {
 public:
  /// `standing` [us]: how long the vehicle stands after arming.
  FrameAlignment(mavlink::Link& link, TimeUs standing) : link_(link), standing_(standing) {}

  /// Where the vehicle stands: [m] and [rad] in W.
  void stand_at(const Vector3& position, Real yaw);
  [[nodiscard]] const Vector3& place() const { return place_; }
  [[nodiscard]] Real place_yaw() const { return place_yaw_; }

  /// One step while armed, standing, and not aligned; true from the step on in which the frames are tied and an
  /// estimate came after.
  bool step(TimeUs now);

  void shift_clock(TimeUs jump) { begun_at_ += jump; }

  /// The autopilot restarted or was disarmed: its frame is no longer known.
  void forget();
  [[nodiscard]] bool aligned() const { return aligned_; }

 private:
  void begin(TimeUs now);
  [[nodiscard]] bool moves() const;
  void add_sample(TimeUs now);

  mavlink::Link& link_;
  TimeUs standing_;
  Vector3 place_ = Vector3::Zero();
  Real place_yaw_ = 0;

  bool begun_ = false;
  bool tied_ = false;
  bool aligned_ = false;
  TimeUs begun_at_ = 0;
  std::uint32_t last_sample_ = 0;
  std::uint32_t samples_ = 0;
  Vector3 first_position_ = Vector3::Zero();
  Vector3 last_position_ = Vector3::Zero();
  Vector3 position_sum_ = Vector3::Zero();
  Real cos_sum_ = 0;
  Real sin_sum_ = 0;
};

}  // namespace swiftlet::companion
