#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "report/flight_record.hpp"
#include "swiftlet/quintic.hpp"

// A flight made up for the tests of its page: round and round a figure of eight between four pillars, behind the
// reference and blown about, over plans of six segments, with a gust, a brake and a take-over near the end.
namespace swiftlet::tools::test {

inline constexpr double kRoundTime = 24;  // [s]
inline constexpr double kSegmentTime = 2;
inline constexpr int kSegmentsPerPlan = 6;

/// The figure of eight at time t.
inline Sample eight(double t) {
  const double w = 2 * std::acos(-1.0) / kRoundTime;
  const Vector3 amplitude{4, 2, 0.4};
  const Vector3 rate{w, 2 * w, w};
  Sample sample;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double a = amplitude[axis];
    const double r = rate[axis];
    sample.position[axis] = a * std::sin(r * t);
    sample.velocity[axis] = a * r * std::cos(r * t);
    sample.acceleration[axis] = -a * r * r * std::sin(r * t);
    sample.jerk[axis] = -a * r * r * r * std::cos(r * t);
  }
  sample.position += Vector3{5, 3, 1.5};
  return sample;
}

inline Segment segment_of_eight(double begin) {
  const Sample from = eight(begin);
  const Sample to = eight(begin + kSegmentTime);
  const double h = kSegmentTime;
  Segment segment{h, {}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    const Quintic quintic = quintic_from_ends({from.position[i], h * from.velocity[i], h * h * from.acceleration[i],
                                               to.position[i], h * to.velocity[i], h * h * to.acceleration[i]});
    for (std::size_t j = 0; j < kQuinticTerms; ++j) {
      segment.coefficients[axis][j] = quintic[j] / std::pow(h, static_cast<double>(j));
    }
  }
  return segment;
}

inline RecordedPlan plan_of_eight(double begin) {
  RecordedPlan plan{begin - 0.2, begin, {}, {}};
  for (int i = 0; i < kSegmentsPerPlan; ++i) {
    plan.segments.push_back(segment_of_eight(begin + i * kSegmentTime));
    Box box{Vector3::Constant(1e9), Vector3::Constant(-1e9)};
    for (double t = 0; t <= kSegmentTime; t += 0.1) {
      const Vector3 p = sample_segment(plan.segments.back(), t).position;
      box.lo = box.lo.cwiseMin(p - Vector3::Constant(0.35));
      box.hi = box.hi.cwiseMax(p + Vector3::Constant(0.35));
    }
    plan.boxes.push_back(box);
  }
  return plan;
}

/// Thrust direction along the acceleration, nose along the velocity.
inline Quaternion attitude_of(const Sample& sample) {
  const Vector3 up = (sample.acceleration * 2 + Vector3{0, 0, kGravity}).normalized();
  const Vector3 ahead = Vector3{sample.velocity.x(), sample.velocity.y(), 0};
  const Vector3 left = up.cross(ahead).normalized();
  Matrix3 rotation;
  rotation << left.cross(up), left, up;
  return Quaternion(rotation);
}

inline RecordedSample moment_of_eight(double t, double duration) {
  const Sample reference = eight(t);
  RecordedSample sample;
  sample.t = t;
  sample.state = t < 1              ? FlightState::kReady
                 : t > duration - 2 ? FlightState::kYielded
                 : t > duration - 5 ? FlightState::kBraking
                 : t < 3            ? FlightState::kHolding
                                    : FlightState::kFlying;
  sample.has_reference = sample.state != FlightState::kReady && sample.state != FlightState::kYielded;
  sample.reference = reference.position;
  sample.reference_velocity = reference.velocity;
  const double gust = std::exp(-std::pow((t - 0.6 * duration) / 2, 2));
  const Vector3 off{std::sin(1.7 * t), std::cos(2.3 * t), 0.4 * std::sin(3.1 * t)};
  sample.position = reference.position + (0.02 + 0.09 * gust) * off - 0.02 * reference.velocity;
  sample.velocity = reference.velocity + (0.03 + 0.1 * gust) * off;
  sample.has_estimate = true;
  sample.estimate = sample.position + 0.01 * off;
  sample.attitude = attitude_of(eight(t - 0.05));
  sample.setpoints = static_cast<std::uint64_t>(50 * t);
  sample.bytes_in = static_cast<std::uint64_t>(5200 * t);
  sample.bytes_out = static_cast<std::uint64_t>(3100 * t);
  return sample;
}

inline FlightRecord flight_of_eight(double duration, double rate) {
  static const std::vector<IntBox> world{{{0, 0, 0}, {100, 60, 1}},   {{0, 0, 1}, {100, 1, 30}},
                                         {{0, 59, 1}, {100, 60, 30}}, {{0, 1, 1}, {1, 59, 30}},
                                         {{28, 27, 1}, {32, 33, 30}}, {{68, 27, 1}, {72, 33, 30}},
                                         {{48, 2, 1}, {52, 22, 12}},  {{48, 38, 1}, {52, 58, 20}}};
  FlightRecord record;
  record.obstacles = {{0, 0, 0}, 0.1, 0.1, world};
  const auto count = static_cast<int>(duration * rate);
  for (int i = 0; i <= count; ++i) record.samples.push_back(moment_of_eight(i / rate, duration));
  const double plan_time = kSegmentTime * kSegmentsPerPlan;
  for (double t = 3; t + plan_time < duration; t += plan_time) record.plans.push_back(plan_of_eight(t));
  record.phases = {{0, "ground"}, {1, "take-off"}, {3, "mission"}, {duration - 2, "pilot"}};
  record.goals = {eight(kRoundTime / 4).position, eight(3 * kRoundTime / 4).position};
  record.events = {{1, EventKind::kNote, "armed and in our mode"},
                   {3, EventKind::kNote, "a plan has started"},
                   {0.3 * duration, EventKind::kArrival, "goal 1 reached"},
                   {duration - 5.2, EventKind::kFault, "20 % of <all> frames & \"more\" are lost"},
                   {duration - 5, EventKind::kReaction, "braking: the odometry is stale"},
                   {duration - 2, EventKind::kReaction, "yielded: the pilot took over"}};
  record.tracking_tube = 0.15;
  record.speed_limit = 1.2;
  record.line_rate = 92160;
  return record;
}

}  // namespace swiftlet::tools::test
