#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "harness/random_corridor.hpp"
#include "swiftlet/corridor.hpp"
#include "swiftlet/trajectory_planner.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet::test {

/// A request on a random corridor for the whole trajectory stage, in buffers with room for knots.
struct RandomFlight {
  static constexpr std::size_t kMost = 64;
  static constexpr std::size_t kMostBoxes = 14;
  std::array<IntBox, kMost> int_boxes{};
  std::array<Box, kMost> boxes;
  std::array<Box, kMost> gates;
  std::array<Vector3, kMost + 1> points;
  std::size_t count = 0;
  TrajectoryRequest request;

  /// Thin gates (cells) or gates with volume (extents) by the seed's parity; limits from 0.5 to 10, evenly in their
  /// logarithm; rest to rest.
  explicit RandomFlight(std::uint64_t seed) {
    Random random(seed ^ 0xF11);
    const RandomCorridor corridor(seed, 1 + random.below(kMostBoxes), seed % 2 == 0);
    count = corridor.count;
    std::copy_n(corridor.boxes.begin(), count, boxes.begin());
    std::copy_n(corridor.gates.begin(), count - 1, gates.begin());
    // Neighbours differ, as boxes of a map do.
    for (std::size_t i = 0; i < count; ++i) int_boxes[i] = {{0, 0, 0}, {1, 1, static_cast<std::uint16_t>(i + 1)}};
    request.start.position = inside(random, boxes[0]);
    request.goal.position = inside(random, boxes[count - 1]);
    pull();
    request.limits.v_max = limit(random);
    request.limits.a_max = limit(random);
  }

  /// A start in motion with 0.75 v^2 / a of room ahead on every axis, often just that.
  void start_with_room(std::uint64_t seed) {
    Random random(seed ^ 0x5747);
    State& start = request.start;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const Real direction = random.below(2) == 0 ? Real(1) : Real(-1);
      const Real room =
          direction > 0 ? boxes[0].hi[axis] - start.position[axis] : start.position[axis] - boxes[0].lo[axis];
      const Real fastest = std::sqrt(room * request.limits.a_max / Real(0.75));
      const Real share = random.below(2) == 0 ? Real(0.9999) : random.uniform(0, 1);
      start.velocity[axis] = direction * share * std::min(fastest, request.limits.v_max);
    }
  }

  /// The state of a trajectory through this corridor at time t, and the corridor that is left from there.
  void start_from(std::span<const Segment> segments, std::span<const Box> flown, Real t) {
    std::size_t passed = 0;
    while (passed + 1 < segments.size() && t > segments[passed].duration) t -= segments[passed++].duration;
    const Sample sample = sample_segment(segments[passed], std::min(t, segments[passed].duration));
    request.start = {sample.position, sample.velocity, sample.acceleration};
    const auto is_flown = [&](const Box& box) { return box.lo == flown[passed].lo && box.hi == flown[passed].hi; };
    const auto first =
        static_cast<std::size_t>(std::find_if(boxes.begin(), boxes.begin() + count, is_flown) - boxes.begin());
    std::copy(int_boxes.begin() + first, int_boxes.begin() + count, int_boxes.begin());
    std::copy(boxes.begin() + first, boxes.begin() + count, boxes.begin());
    std::copy(gates.begin() + first, gates.begin() + count - 1, gates.begin());
    count -= first;
    pull();
  }

  [[nodiscard]] KnottedCorridor corridor() { return {int_boxes, boxes, gates, points}; }

 private:
  /// The taut path, as the planner gives it.
  void pull() {
    std::array<TautNode, kMost + 1> nodes;
    (void)pull_taut(request.start.position, request.goal.position, std::span(gates).first(count - 1), points, nodes);
  }
  static Vector3 inside(Random& random, const Box& box) {
    Vector3 point;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      point[axis] = box.lo[axis] + random.uniform(Real(0.02), Real(0.98)) * (box.hi[axis] - box.lo[axis]);
    }
    return point;
  }
  /// 0.5 * 20^u with u uniform, by square roots alone: the same on every machine.
  static Real limit(Random& random) {
    Real value = Real(0.5);
    Real factor = 20;
    for (int bit = 0; bit < 12; ++bit) {
      factor = std::sqrt(factor);
      if (random.below(2) == 1) value *= factor;
    }
    return value;
  }
};

}  // namespace swiftlet::test
