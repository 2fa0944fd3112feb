#pragma once
#include <cmath>
#include <cstdint>

#include "swiftlet/types.hpp"
#include "world/random.hpp"

namespace swiftlet::tools {

/// Random numbers of one source of disturbance; the same on every machine.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : random_(seed) {}

  /// In [0, 1).
  double uniform() { return static_cast<double>(random_.next() >> 11U) * 0x1p-53; }
  /// Normal to the eye, mean 0 and standard deviation 1: twelve uniforms, since libm is not the same everywhere. Never
  /// beyond 6.
  double gaussian() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }
  Vector3 vector() {
    const double x = gaussian();
    const double y = gaussian();
    return {x, y, gaussian()};
  }
  std::size_t below(std::size_t bound) { return random_.below(bound); }

 private:
  SplitMix64 random_;
};

/// A first-order Gauss-Markov process on each axis: coloured noise that forgets within `time_constant` [s].
class ColouredNoise {
 public:
  ColouredNoise(const Vector3& sigma, double time_constant) : sigma_(sigma), time_constant_(time_constant) {}

  void step(double dt, Noise& noise) {
    const double keep = 1 - std::fmin(1.0, dt / time_constant_);
    value_ = keep * value_ + std::sqrt(1 - keep * keep) * sigma_.cwiseProduct(noise.vector());
  }
  [[nodiscard]] const Vector3& value() const { return value_; }

 private:
  Vector3 sigma_;
  double time_constant_;
  Vector3 value_ = Vector3::Zero();
};

}  // namespace swiftlet::tools
