#include "report/flight_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "report/page.hpp"
#include "swiftlet/version.hpp"

namespace swiftlet::tools {
namespace {

using Json = nlohmann::ordered_json;

// Base64 of an obstacle takes 16 characters, of a moment 48; a box of a plan 45, with its part of the path 120 more.
constexpr std::size_t kMostObstacles = 250'000;
constexpr std::size_t kMostSamples = 30'000;
constexpr std::size_t kMostPlanBoxes = 10'000;
constexpr int kPathPieces = 15;  // of a segment

constexpr double kRateWindow = 1;             // [s] over which a rate is taken
constexpr double kShortestRateWindow = 0.25;  // [s]; a shorter one, at the beginning, gives no rate
constexpr std::string_view kTrackedPhase = "mission";
constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

using Samples = std::span<const RecordedSample>;

/// Indices of the samples that the page carries: every n-th, and the last.
std::vector<std::size_t> shown_samples(std::size_t count) {
  std::vector<std::size_t> shown;
  const std::size_t stride = std::max<std::size_t>(1, (count + kMostSamples - 1) / kMostSamples);
  for (std::size_t i = 0; i < count; i += stride) shown.push_back(i);
  if (count > 0 && shown.back() != count - 1) shown.push_back(count - 1);
  return shown;
}

/// Milliseconds since the first sample as two 16-bit words each.
Json times_json(Samples samples, std::span<const std::size_t> shown) {
  std::vector<std::uint16_t> low;
  std::vector<std::uint16_t> high;
  for (const std::size_t i : shown) {
    const auto ticks = static_cast<std::uint32_t>(std::lround(1000 * std::max(samples[i].t, 0.0)));
    low.push_back(static_cast<std::uint16_t>(ticks & 0xFFFFU));
    high.push_back(static_cast<std::uint16_t>(ticks >> 16U));
  }
  return {{"low", encode_integers(low)}, {"high", encode_integers(high)}};
}

/// True while the vehicle is to be where the reference is.
bool follows(const RecordedSample& sample) {
  const bool in_control = sample.state == FlightState::kFlying || sample.state == FlightState::kBraking ||
                          sample.state == FlightState::kHolding;
  return sample.has_reference && in_control;
}

/// True once the companion's frame is tied to the map's, which happens at arming.
bool is_aligned(const RecordedSample& sample) {
  return sample.has_estimate && sample.state != FlightState::kIdle && sample.state != FlightState::kReady;
}

/// True in the part of the flight for which tracking is promised: neither take-off nor landing.
bool is_tracked(std::span<const RecordedPhase> phases, double t) {
  const auto next = std::upper_bound(phases.begin(), phases.end(), t,
                                     [](double time, const RecordedPhase& phase) { return time < phase.t; });
  return phases.empty() || (next != phases.begin() && std::prev(next)->name == kTrackedPhase);
}

/// Not a number where it means nothing.
std::vector<double> tracking_errors(const FlightRecord& record) {
  std::vector<double> errors;
  for (const RecordedSample& sample : record.samples) {
    const bool counts = follows(sample) && is_tracked(record.phases, sample.t);
    errors.push_back(counts ? (sample.reference - sample.position).norm() : kMissing);
  }
  return errors;
}

/// The speed that the limit is about.
double limited_speed(const Vector3& velocity, bool per_axis) {
  return per_axis ? velocity.cwiseAbs().maxCoeff() : velocity.norm();
}

/// Growth of a counter [1/s] over the last second of every sample.
std::vector<double> rates(Samples samples, std::uint64_t RecordedSample::*counter) {
  std::vector<double> result;
  std::size_t first = 0;
  for (const RecordedSample& sample : samples) {
    while (samples[first].t < sample.t - kRateWindow) ++first;
    const double window = sample.t - samples[first].t;
    const bool usable = window >= kShortestRateWindow && sample.*counter >= samples[first].*counter;
    result.push_back(usable ? static_cast<double>(sample.*counter - samples[first].*counter) / window : kMissing);
  }
  return result;
}

/// One number of every sample that is shown, packed.
class Channels {
 public:
  explicit Channels(Samples samples) : samples_(samples), shown_(shown_samples(samples.size())) {}

  [[nodiscard]] std::span<const std::size_t> shown() const { return shown_; }

  [[nodiscard]] Json of(const std::function<double(const RecordedSample&)>& value) const {
    return of_index([&](std::size_t i) { return value(samples_[i]); });
  }
  [[nodiscard]] Json of_reference(const std::function<double(const RecordedSample&)>& value) const {
    return of([&](const RecordedSample& sample) { return follows(sample) ? value(sample) : kMissing; });
  }
  [[nodiscard]] Json rate_of(std::uint64_t RecordedSample::*counter) const {
    const std::vector<double> all = rates(samples_, counter);
    return of_index([&](std::size_t i) { return all[i]; });
  }
  /// Of each sample the largest of `values` since the one shown before, not a number without any.
  [[nodiscard]] Json worst_of(std::span<const double> values) const {
    std::size_t next = 0;
    return of_index([&](std::size_t i) {
      double worst = kMissing;
      for (; next <= i; ++next) worst = std::fmax(worst, values[next]);
      return worst;
    });
  }

 private:
  [[nodiscard]] Json of_index(const std::function<double(std::size_t)>& value) const {
    std::vector<double> values;
    for (const std::size_t i : shown_) values.push_back(value(i));
    return channel_json(values);
  }

  Samples samples_;
  std::vector<std::size_t> shown_;
};

void put_motion(Json& json, const Channels& channels) {
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const std::string name(1, "xyz"[axis]);
    json[name] = channels.of([&](const RecordedSample& sample) { return sample.position[axis]; });
    json["reference_" + name] =
        channels.of_reference([&](const RecordedSample& sample) { return sample.reference[axis]; });
  }
  json["qw"] = channels.of([](const RecordedSample& sample) { return sample.attitude.w(); });
  json["qx"] = channels.of([](const RecordedSample& sample) { return sample.attitude.x(); });
  json["qy"] = channels.of([](const RecordedSample& sample) { return sample.attitude.y(); });
  json["qz"] = channels.of([](const RecordedSample& sample) { return sample.attitude.z(); });
}

Json samples_json(const FlightRecord& record) {
  const Samples samples = record.samples;
  const Channels channels(samples);
  const bool per_axis = record.speed_limit_per_axis;
  Json json{{"count", samples.size()},
            {"shown", channels.shown().size()},
            {"t", times_json(samples, channels.shown())},
            {"tracking_error", channels.worst_of(tracking_errors(record))}};
  put_motion(json, channels);
  json["estimate_error"] = channels.of([](const RecordedSample& sample) {
    return is_aligned(sample) ? (sample.estimate - sample.position).norm() : kMissing;
  });
  json["speed"] = channels.of([&](const RecordedSample& sample) { return limited_speed(sample.velocity, per_axis); });
  json["reference_speed"] = channels.of_reference(
      [&](const RecordedSample& sample) { return limited_speed(sample.reference_velocity, per_axis); });
  json["setpoint_rate"] = channels.rate_of(&RecordedSample::setpoints);
  json["rate_in"] = channels.rate_of(&RecordedSample::bytes_in);
  json["rate_out"] = channels.rate_of(&RecordedSample::bytes_out);
  return json;
}

/// The changes of the flight state, each with the time from which it holds.
Json states_json(Samples samples) {
  Json states = Json::array();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (i > 0 && samples[i].state == samples[i - 1].state) continue;
    states.push_back({{"t", samples[i].t}, {"name", describe(samples[i].state)}});
  }
  return states;
}

/// To a tenth of a millimetre, which prints short.
double rounded(double value) { return std::round(1e4 * value) / 1e4; }

Json boxes_json(std::span<const Box> boxes) {
  Json json = Json::array();
  for (const Box& box : boxes) {
    Json corners = Json::array();
    for (const Vector3& corner : {box.lo, box.hi}) {
      for (const double value : corner) corners.push_back(rounded(value));
    }
    json.push_back(std::move(corners));
  }
  return json;
}

/// Points along a plan, the ends of its segments among them.
Json path_json(std::span<const Segment> segments) {
  std::array<std::vector<double>, 3> points;
  for (const Segment& segment : segments) {
    for (int piece = 0; piece <= kPathPieces; ++piece) {
      if (piece == 0 && !points[0].empty()) continue;  // the end of the segment before
      const Vector3 position = sample_segment(segment, segment.duration * piece / kPathPieces).position;
      for (Eigen::Index axis = 0; axis < 3; ++axis) points[static_cast<std::size_t>(axis)].push_back(position[axis]);
    }
  }
  return {{"x", channel_json(points[0])}, {"y", channel_json(points[1])}, {"z", channel_json(points[2])}};
}

/// Indices of the plans that the page carries, in their order.
std::vector<std::size_t> shown_plans(std::span<const RecordedPlan> plans) {
  std::size_t largest = 1;
  for (const RecordedPlan& plan : plans) largest = std::max({largest, plan.boxes.size(), plan.segments.size()});
  const auto milliseconds_in_force = [&](std::size_t i) {
    if (i + 1 == plans.size()) return std::numeric_limits<std::uint64_t>::max();
    return static_cast<std::uint64_t>(1000 * std::max(plans[i + 1].committed - plans[i].committed, 0.0));
  };
  std::vector<std::size_t> shown = largest_items(plans.size(), kMostPlanBoxes / largest, milliseconds_in_force);
  std::sort(shown.begin(), shown.end());
  return shown;
}

Json plans_json(std::span<const RecordedPlan> plans) {
  Json shown = Json::array();
  for (const std::size_t i : shown_plans(plans)) {
    const RecordedPlan& plan = plans[i];
    shown.push_back({{"number", i + 1},
                     {"committed", plan.committed},
                     {"begins", plan.begins},
                     {"duration", total_duration(plan.segments)},
                     {"length", arc_length(plan.segments)},
                     {"boxes", boxes_json(plan.boxes)},
                     {"path", path_json(plan.segments)}});
  }
  return {{"count", plans.size()}, {"shown", std::move(shown)}};
}

const char* to_word(EventKind kind) {
  switch (kind) {
    case EventKind::kArrival:
      return "arrival";
    case EventKind::kReaction:
      return "reaction";
    case EventKind::kFault:
      return "fault";
    case EventKind::kNote:
      break;
  }
  return "note";
}

Json events_json(std::span<const RecordedEvent> events) {
  Json json = Json::array();
  for (const RecordedEvent& event : events) {
    json.push_back({{"t", event.t}, {"kind", to_word(event.kind)}, {"what", event.what}});
  }
  return json;
}

Json phases_json(std::span<const RecordedPhase> phases) {
  Json json = Json::array();
  for (const RecordedPhase& phase : phases) json.push_back({{"t", phase.t}, {"name", phase.name}});
  return json;
}

Json goals_json(std::span<const Vector3> goals) {
  Json json = Json::array();
  for (const Vector3& goal : goals) json.push_back(Json::array({goal.x(), goal.y(), goal.z()}));
  return json;
}

Json known(double value) { return value > 0 ? Json(value) : Json(nullptr); }

}  // namespace

std::string flight_report_html(const FlightReportInput& input) {
  const FlightRecord& record = input.record;
  return page(input.title, {{"kind", "flight"},
                            {"title", input.title},
                            {"version", kVersion},
                            {"obstacles", obstacles_json(record.obstacles, kMostObstacles)},
                            {"vehicle_radius", record.vehicle_radius},
                            {"tracking_tube", known(record.tracking_tube)},
                            {"speed_limit", known(record.speed_limit)},
                            {"speed_limit_per_axis", record.speed_limit_per_axis},
                            {"line_rate", known(record.line_rate)},
                            {"goals", goals_json(record.goals)},
                            {"phases", phases_json(record.phases)},
                            {"states", states_json(record.samples)},
                            {"events", events_json(record.events)},
                            {"plans", plans_json(record.plans)},
                            {"samples", samples_json(record)},
                            {"flight", input.flight}});
}

}  // namespace swiftlet::tools
