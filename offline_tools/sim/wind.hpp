#pragma once
#include <cstdint>

#include "sim/noise.hpp"

namespace swiftlet::tools {

struct WindSettings {
  Vector3 mean = Vector3::Zero();  ///< [m/s] frame W
  double gust = 0;                 ///< [m/s] speed that gusts reach; 0: steady wind
  double gust_time = 1;            ///< [s] how long a gust lasts
};

/// Mean wind and gusts: coloured noise of the first order, the simplest of Dryden's spectra, a standard deviation of
/// half of `gust` on the horizontal axes and a quarter on the vertical one, cut off at `gust`.
class Wind {
 public:
  Wind(const WindSettings& settings, std::uint64_t seed)
      : settings_(settings), noise_(seed), gust_(Vector3{0.5, 0.5, 0.25} * settings.gust, settings.gust_time) {}

  void step(double dt) { gust_.step(dt, noise_); }
  [[nodiscard]] Vector3 velocity() const {
    const double speed = gust_.value().norm();
    const double cut = speed > settings_.gust ? settings_.gust / speed : 1;
    return settings_.mean + cut * gust_.value();
  }

 private:
  WindSettings settings_;
  Noise noise_;
  ColouredNoise gust_;
};

}  // namespace swiftlet::tools
