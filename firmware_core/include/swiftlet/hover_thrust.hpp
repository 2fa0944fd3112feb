#pragma once
#include "swiftlet/flight_time.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

struct HoverThrustSettings {
  Real initial = Real(0.5);  ///< normalised thrust that carries the weight
  Real least = Real(0.1);    ///< bounds of the estimate
  Real most = Real(0.8);
  Real time_constant = 2;   ///< [s] of the filter
  TimeUs window = 100'000;  ///< [us] over which climb is compared with thrust; > link delay
};

/// Learns which normalised thrust (0 to 1, as SET_ATTITUDE_TARGET takes it) hovers, from climb and the thrust that was
/// sent: over a window, mean u * g / hover * cos(tilt) - g must equal the change of climb rate. Battery, payload and
/// air density change it.
class HoverThrustEstimator {
 public:
  explicit HoverThrustEstimator(const HoverThrustSettings& settings);

  /// Begins with `hover` within the bounds, unless something has been learnt; whether it does.
  bool begin_with(Real hover);

  /// One measurement while flying with our thrust.
  ///   climb     [m/s] vertical velocity, up
  ///   cos_tilt  vertical component of body z
  ///   sent      normalised thrust in force
  /// Windows with numbers that are not finite, an inverted vehicle, a time that goes back or a gap are thrown away.
  void update(TimeUs time, Real climb, Real cos_tilt, Real sent);

  /// Starts a new window; keeps the estimate. When not flying or not in control.
  void pause() { open_ = false; }

  [[nodiscard]] Real hover() const { return hover_; }

  /// Normalised thrust for a specific thrust [m/s^2], in [0, 1]; the hover thrust for what is not finite.
  [[nodiscard]] Real normalised(Real specific_thrust) const;

 private:
  void open(TimeUs time, Real climb);

  HoverThrustSettings settings_;
  Real hover_;
  bool learnt_ = false;
  bool open_ = false;
  TimeUs window_start_ = 0;
  TimeUs last_ = 0;
  Real first_climb_ = 0;
  Real vertical_impulse_ = 0;  // integral of sent * cos_tilt [s]
};

}  // namespace swiftlet
