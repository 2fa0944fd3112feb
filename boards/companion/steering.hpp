#pragma once
#include <cstdint>
#include <optional>

#include "companion/settings.hpp"
#include "swiftlet/hover_thrust.hpp"
#include "swiftlet/mavlink/link.hpp"
#include "swiftlet/tracking_controller.hpp"
#include "swiftlet/trajectory_store.hpp"
#include "swiftlet/vehicle_state.hpp"
#include "swiftlet/yaw.hpp"

namespace swiftlet::companion {

/// What a step of the steering rests on.
struct SteeringInputs {
  TimeUs now = 0;
  TimeUs link_delay = 0;  ///< one way
  SetpointForm form = SetpointForm::kPosition;
  bool trusted = false;  ///< the estimate; otherwise the reference is sent open loop
  VehicleState estimate;
  bool new_estimate = false;
  std::optional<Real> yaw{};  ///< [rad] wanted; nothing: as the settings say
};

/// Turns the reference into set-points: yaw, prediction over the link's delay, control, thrust.
class Steering {
 public:
  explicit Steering(const Settings& settings);

  /// Control is not ours: forget what was commanded, and look where the vehicle looks [rad].
  void rest(Real yaw, TimeUs now);

  TrackingCommand step(const SteeringInputs& inputs, const TrajectoryStore& store);

  /// Sends the last command in the last step's form, once; false when it may not be sent or the line did not take it.
  bool send(mavlink::Link& link);

  [[nodiscard]] Real thrust() const { return thrust_; }  ///< 0 to 1, of the last command
  /// Before the first flight: what somebody else knows of it. Whether it is taken.
  bool begin_with_hover_thrust(Real hover) { return hover_.begin_with(hover); }
  [[nodiscard]] Real hover_thrust() const { return hover_.hover(); }
  [[nodiscard]] const YawState& yaw() const { return yaw_; }

 private:
  TrackingController& controller() { return form_ == SetpointForm::kRates ? rate_control_ : attitude_control_; }
  void change_form(SetpointForm form);
  void learn_hover_thrust(const SteeringInputs& inputs);
  void step_yaw_towards(const SteeringInputs& inputs, const TrajectoryStore& store, TimeUs effect, Real dt);

  const Settings& settings_;
  StatePredictor predictor_;
  TrackingController attitude_control_;
  TrackingController rate_control_;
  HoverThrustEstimator hover_;
  YawState yaw_;
  SetpointForm form_ = SetpointForm::kPosition;
  TimeUs last_ = 0;
  TrackingCommand command_;
  Real thrust_ = 0;
};

}  // namespace swiftlet::companion
