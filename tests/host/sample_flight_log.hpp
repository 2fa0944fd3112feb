#pragma once
#include <array>

#include "companion/flight_log.hpp"

namespace swiftlet::companion {

inline constexpr int kSampleSteps = 100;
inline constexpr TimeUs kSampleStart = 1'000'000;

/// A log of a second whose values can be told from the number of the step; plans, texts and all kinds of input in it.
inline void write_sample(FlightLog& log, std::string_view name) {
  log.begin(name, kSampleStart, {.version = "1.2.3", .board = "test", .settings = R"({"a": 1})", .map_crc32 = 42});
  const std::array<Box, 2> boxes{Box{{0, 0, 0}, {2, 1, 1}}, Box{{1, 0, 0}, {3, 1, 1}}};
  std::array<Segment, 2> segments{};
  segments[0].duration = 1.5;
  segments[1].duration = 2.5;
  log.note_word({.kind = Word::Kind::kAddGoal, .id = 0, .a = {1, 2, 3}, .yaw = Real(0.5)});
  for (int i = 0; i < kSampleSteps; ++i) {
    const TimeUs now = kSampleStart + 10'000 * TimeUs{i};
    const auto x = static_cast<Real>(i);
    if (i == 31) log.note_map(43, "/maps/other.swm");
    log.begin_step(now);
    const std::array<std::byte, 300> received{static_cast<std::byte>(i)};
    if (i % 10 == 3) log.note_read({});
    log.note_read(std::span(received).first(static_cast<std::size_t>(3 * i)));
    log.note_read({});
    log.note_write(received, i == 5 ? 100 : received.size());
    if (i == 20) log.note_plan_done();
    Telemetry telemetry;
    telemetry.time = now;
    telemetry.state = i < 50 ? FlightState::kFlying : FlightState::kBraking;
    telemetry.reason = i < 50 ? Reason::kPlanStarted : Reason::kOdometryStale;
    telemetry.phase = Phase::kMission;
    telemetry.has_estimate = true;
    telemetry.estimate.time = now - 4'000;
    telemetry.estimate.position = {x, 2, 3};
    telemetry.estimate.velocity = {x, 5, 6};
    telemetry.estimate.body_rates = {Real(0.1), Real(0.2), Real(0.3)};
    telemetry.has_reference = true;
    telemetry.reference.sample = {{x, 2, 3}, {x, 5, 6}, {7, 8, 9}, {10, 11, 12}};
    telemetry.tracking_error = Real(0.25);
    telemetry.sent = true;
    telemetry.form = i % 2 == 0 ? SetpointForm::kAttitude : SetpointForm::kRates;
    telemetry.command.body_rates = {Real(0.1), Real(0.2), Real(0.3)};
    telemetry.thrust = Real(0.5);
    if (i >= 20) {
      telemetry.plan.id = 1;
      telemetry.plan.segments = segments;
      telemetry.plan.boxes = boxes;
      telemetry.plan.map_crc = 42;
    }
    if (i == 50) log.write(FlightEvent{now, FlightState::kFlying, FlightState::kBraking, Reason::kOdometryStale});
    log.end_step(telemetry);
  }
  log.end();
}

}  // namespace swiftlet::companion
