#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "swiftlet/stop_at_gates.hpp"
#include "swiftlet/trajectory_generator.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet::test {

/// SplitMix64: the same numbers on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = state_ += 0x9E3779B97F4A7C15;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
    return z ^ (z >> 31);
  }
  /// Uniform in [lo, hi].
  Real uniform(Real lo, Real hi) { return lo + (hi - lo) * static_cast<Real>(next() >> 40) / Real(16777215); }
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(next() % count); }

 private:
  std::uint64_t state_;
};

/// A chain of boxes that share faces (thin gates) or overlap (gates with volume), with generous durations: rest to rest
/// at the ends of the chain's middle line. For tests of trajectory generation alone.
struct RandomCorridor {
  static constexpr std::size_t kMost = 24;
  static constexpr Real kShortest = Real(0.2);  // [s]
  std::array<Box, kMost> boxes;
  std::array<Box, kMost> gates;
  std::array<Real, kMost> durations{};
  std::array<Vector3, kMost + 1> points;
  std::size_t count = 0;
  State start;
  State goal;
  Real v_max = 1;
  Real a_max = 1;

  RandomCorridor(std::uint64_t seed, std::size_t segment_count, bool thin_gates) : count(segment_count) {
    Random random(seed);
    v_max = random.uniform(1, 3);
    a_max = random.uniform(1, 3);
    Vector3 corner{random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-5, 5)};
    for (std::size_t i = 0; i < count; ++i) {
      const Vector3 size{random.uniform(Real(0.6), 3), random.uniform(Real(0.6), 3), random.uniform(Real(0.6), 3)};
      boxes[i] = {corner, corner + size};
      const auto axis = static_cast<Eigen::Index>(random.below(3));
      // The next low corner: on this box's far face along one axis, somewhere inside its face on the others.
      for (Eigen::Index k = 0; k < 3; ++k) {
        const Real share =
            k == axis ? (thin_gates ? Real(1) : random.uniform(Real(0.4), Real(0.9))) : random.uniform(0, Real(0.4));
        corner[k] = boxes[i].lo[k] + share * (boxes[i].hi[k] - boxes[i].lo[k]);
        if (k == axis && thin_gates) corner[k] = boxes[i].hi[k];
      }
    }
    for (std::size_t i = 0; i + 1 < count; ++i) {
      gates[i] = {boxes[i].lo.cwiseMax(boxes[i + 1].lo), boxes[i].hi.cwiseMin(boxes[i + 1].hi)};
      points[i + 1] = (gates[i].lo + gates[i].hi) / 2;
    }
    points[0] = start.position = (boxes[0].lo + boxes[0].hi) / 2;
    points[count] = goal.position = (boxes[count - 1].lo + boxes[count - 1].hi) / 2;
    std::array<Segment, kMost> stop;
    stop_at_gates(std::span(points).first(count + 1), Vector3::Constant(v_max), Vector3::Constant(a_max), stop);
    for (std::size_t i = 0; i < count; ++i) durations[i] = std::max(stop[i].duration, kShortest);
  }

  [[nodiscard]] TrajectoryProblem problem() const {
    return {std::span(boxes).first(count),
            std::span(gates).first(count - 1),
            std::span(durations).first(count),
            start,
            goal,
            Vector3::Constant(v_max),
            Vector3::Constant(a_max),
            {}};
  }
};

}  // namespace swiftlet::test
