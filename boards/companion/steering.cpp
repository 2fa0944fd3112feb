#include "companion/steering.hpp"

namespace swiftlet::companion {
namespace {

TimeUs delay_of(const CommandDelays& delays, SetpointForm form) {
  switch (form) {
    case SetpointForm::kPosition:
      return delays.position;
    case SetpointForm::kAttitude:
      return delays.attitude;
    case SetpointForm::kRates:
      return delays.rates;
  }
  return 0;
}

VehicleState unusable_state() {
  VehicleState state;
  state.attitude.coeffs().setZero();
  return state;
}

}  // namespace

Steering::Steering(const Settings& settings)
    : settings_(settings),
      predictor_(settings.predictor),
      attitude_control_(settings.control.attitude),
      rate_control_(settings.control.rates),
      hover_(settings.hover_thrust) {}

void Steering::rest(Real yaw, TimeUs now) {
  yaw_ = {yaw, 0};
  last_ = now;
  change_form(SetpointForm::kPosition);
}

/// Neither disturbance nor prediction knows what another form, or somebody else, commanded.
void Steering::change_form(SetpointForm form) {
  if (form == form_) return;
  form_ = form;
  predictor_.reset();
  controller().reset();
  hover_.pause();
}

void Steering::learn_hover_thrust(const SteeringInputs& inputs) {
  if (form_ == SetpointForm::kPosition) return hover_.pause();
  if (!inputs.new_estimate || thrust_ == 0) return;
  const Real cos_tilt = inputs.estimate.attitude.toRotationMatrix()(2, 2);
  hover_.update(inputs.estimate.time, inputs.estimate.velocity.z(), cos_tilt, thrust_);
}

void Steering::step_yaw_towards(const SteeringInputs& inputs, const TrajectoryStore& store, TimeUs effect, Real dt) {
  const Vector3 here = store.sample(effect).position;
  const Vector3 ahead = store.sample(effect + to_us(settings_.yaw.look_ahead)).position;
  const Real wanted = inputs.yaw ? *inputs.yaw : wanted_yaw(settings_.yaw, here, ahead, yaw_.yaw);
  yaw_ = step_yaw(settings_.yaw, yaw_, wanted, dt);
}

TrackingCommand Steering::step(const SteeringInputs& inputs, const TrajectoryStore& store) {
  const Real dt = to_seconds(inputs.now - last_);
  last_ = inputs.now;
  change_form(inputs.form);
  learn_hover_thrust(inputs);
  const TimeUs arrives = inputs.now + inputs.link_delay;
  const TimeUs effect = arrives + delay_of(settings_.delays, form_);
  step_yaw_towards(inputs, store, effect, dt);
  const Reference reference{store.sample(effect), yaw_.yaw, yaw_.rate};
  const bool own_form = form_ != SetpointForm::kPosition;
  if (own_form && inputs.new_estimate) predictor_.learn(inputs.estimate);
  const VehicleState predicted = inputs.trusted ? predictor_.predict(inputs.estimate, effect) : unusable_state();
  command_ = controller().step(reference, predicted, predictor_.disturbance());
  thrust_ = own_form ? hover_.normalised(command_.thrust) : 0;
  if (own_form) predictor_.record(arrives, command_.commanded_acceleration, command_.thrust);
  return command_;
}

bool Steering::send(mavlink::Link& link) {
  switch (form_) {
    case SetpointForm::kPosition:
      if (command_.basis == CommandBasis::kLevel) return false;  // it has no position
      return link.send(mavlink::PositionSetpoint{command_.position, command_.velocity, command_.acceleration,
                                                 command_.yaw, command_.yaw_rate});
    case SetpointForm::kAttitude:
      return link.send(mavlink::AttitudeSetpoint{command_.attitude, thrust_});
    case SetpointForm::kRates:
      return link.send(mavlink::RateSetpoint{command_.body_rates, thrust_});
  }
  return false;
}

}  // namespace swiftlet::companion
