// The companion's link and the simulated autopilot: two implementations of one protocol, in lock-step and on devices.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "sim/lockstep_uart.hpp"
#include "swiftlet/hal/monotonic_clock.hpp"
#include "swiftlet/hal/posix_uart.hpp"
#include "swiftlet/mavlink/link.hpp"

namespace swiftlet::tools {
namespace {

using mavlink::Mode;

/// A companion with the real link, one step every 10 ms.
class Flight {
 public:
  explicit Flight(const PixhawkSimSettings& settings) : sim(settings), uart_(sim), link(uart_, {}) {}

  PixhawkSim sim;

 private:
  LockstepUart uart_;

 public:
  mavlink::Link link;
  std::function<void()> send;

  void run(double seconds) {
    for (int i = 0; i < std::lround(seconds * 100); ++i) {
      link.step(sim.time());
      if (send) send();
      uart_.advance(std::chrono::milliseconds(10));
    }
  }
  /// The vehicle's true position on its ground and in the map's frame.
  [[nodiscard]] Vector3 truth() const { return sim.simulation().truth().position; }

  void take_off(const Vector3& start, double yaw) {
    run(1.5);
    send = [&] {
      mavlink::PositionSetpoint setpoint;
      setpoint.position = link.vehicle().position;
      (void)link.send(setpoint);
    };
    ASSERT_TRUE(link.request_mode(Mode::kOffboard));
    run(1.2);
    ASSERT_EQ(link.autopilot().mode, Mode::kOffboard);
    ASSERT_TRUE(link.autopilot().prearm_ok);
    ASSERT_TRUE(link.request_arm(true));
    run(0.2);
    ASSERT_TRUE(link.align(start, yaw));
    hold(start + Vector3{0, 0, 1.5});
    run(9);
    ASSERT_TRUE(link.autopilot().armed);
    ASSERT_EQ(link.autopilot().landed_state, mavlink::LandedState::kInAir);
  }
  void hold(const Vector3& p_W) {
    send = [this, p_W] {
      mavlink::PositionSetpoint setpoint;
      setpoint.position = p_W;
      (void)link.send(setpoint);
    };
  }
};

PixhawkSimSettings turned_frame() {
  PixhawkSimSettings settings;
  settings.simulation.start = {4, -3, 0.5};
  settings.simulation.start_yaw = 0.4;
  settings.simulation.estimator.origin = {10, 20, 1};
  settings.simulation.estimator.heading = 2;
  settings.simulation.estimator.attitude_sigma.setZero();
  settings.link_delay = std::chrono::milliseconds(5);
  return settings;
}

TEST(PixhawkSimLink, AFlightInTheMapsFrameGoesWhereItIsSentThoughTheLocalFrameIsTurnedAndShifted) {
  Flight flight(turned_frame());
  flight.take_off({4, -3, 0.5}, 0.4);
  EXPECT_NEAR((flight.truth() - Vector3{4, -3, 2}).norm(), 0, 0.2);
  flight.hold({6, -3, 2.5});
  flight.run(8);
  EXPECT_NEAR((flight.truth() - Vector3{6, -3, 2.5}).norm(), 0, 0.2);
  EXPECT_EQ(flight.link.counters().refused_values, 0U);
  EXPECT_EQ(flight.link.counters().refused_rates, 0U);
  EXPECT_EQ(flight.link.codec_counters().bad_checksum, 0U);
  EXPECT_EQ(flight.sim.counters().bad_checksum, 0U);
}

TEST(PixhawkSimLink, OffboardRefusedInTheAirIsSeenAsRefusedDespiteTheFirstAcknowledgement) {
  Flight flight(turned_frame());
  flight.take_off({4, -3, 0.5}, 0.4);
  ASSERT_TRUE(flight.link.request_mode(Mode::kHold));
  flight.run(0.5);
  EXPECT_EQ(flight.link.autopilot().mode, Mode::kHold);
  while (flight.link.take_outcome()) {
  }
  flight.send = {};
  flight.run(1.5);
  ASSERT_TRUE(flight.link.request_mode(Mode::kOffboard));
  std::optional<mavlink::Outcome> outcome;
  for (int i = 0; i < 100 && !outcome; ++i) {
    flight.run(0.1);
    outcome = flight.link.take_outcome();
  }
  ASSERT_TRUE(outcome.has_value());
  EXPECT_NE(outcome->kind, mavlink::Outcome::Kind::kDone);
  EXPECT_EQ(flight.link.autopilot().mode, Mode::kHold);
}

TEST(PixhawkSimLink, AttitudeAndRateSetpointsFly) {
  for (const bool rates : {false, true}) {
    Flight flight(turned_frame());
    flight.take_off({4, -3, 0.5}, 0.4);
    const double yaw = yaw_of(flight.sim.simulation().truth().attitude);
    const Quaternion level(Eigen::AngleAxis<double>(yaw, Vector3::UnitZ()));
    const Quaternion nose_down = level * Eigen::AngleAxis<double>(0.15, Vector3::UnitY());
    flight.send = [&] {
      if (rates) {
        (void)flight.link.send(mavlink::RateSetpoint{{0, 0.3, 0}, 0.5});
      } else {
        (void)flight.link.send(mavlink::AttitudeSetpoint{nose_down, 0.5});
      }
    };
    flight.run(0.6);
    const RigidState& truth = flight.sim.simulation().truth();
    EXPECT_GT((level.conjugate() * truth.velocity).x(), 0.15);
    if (rates) {
      EXPECT_NEAR(truth.rate.y(), 0.3, 0.08);
    } else {
      EXPECT_LT(truth.attitude.angularDistance(nose_down), 0.06);
    }
  }
}

TEST(PixhawkSimLink, ARestartOfTheAutopilotIsNoticed) {
  PixhawkSimSettings settings = turned_frame();
  settings.faults = {*parse_fault("restart@2+1")};
  Flight flight(settings);
  flight.run(5);
  EXPECT_EQ(flight.link.autopilot().restarts, 1U);
}

/// Runs the program and steps a link on the device that `open` makes from its first line, until everything is heard.
void hears(const std::string& arguments, const std::function<hal::Uart*(const std::string&)>& open) {
  const std::string command = std::string("echo $$; exec ") + PIXHAWK_SIM_PROGRAM + " " + arguments + " 2>/dev/null";
  const std::unique_ptr<FILE, int (*)(FILE*)> program(::popen(command.c_str(), "r"), ::pclose);
  ASSERT_NE(program, nullptr);
  std::array<char, 256> line{};
  ASSERT_NE(std::fgets(line.data(), line.size(), program.get()), nullptr);
  const auto process = static_cast<pid_t>(std::strtol(line.data(), nullptr, 10));
  if (arguments.empty()) {
    ASSERT_NE(std::fgets(line.data(), line.size(), program.get()), nullptr);
  }
  std::string path(line.data());
  while (!path.empty() && path.back() == '\n') path.pop_back();
  hal::Uart* uart = open(path);
  ASSERT_NE(uart, nullptr) << path;
  mavlink::Link link(*uart, {});
  hal::MonotonicClock clock;
  const auto done = [&] {
    return link.autopilot().heard && link.local_vehicle().has_position && link.local_vehicle().has_attitude;
  };
  for (int i = 0; i < 30'000 && !done(); ++i) {
    link.step(clock.now());
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(done());
  EXPECT_EQ(::kill(process, SIGTERM), 0);
}

TEST(PixhawkSimLink, TheProgramSpeaksOnAPseudoTerminal) {
  hal::SerialPort port;
  hears("", [&](const std::string& path) { return port.open(path.c_str(), 921'600) ? &port : nullptr; });
}

TEST(PixhawkSimLink, TheProgramSpeaksOverUdp) {
  hal::UdpUart first;
  ASSERT_TRUE(first.open(0, "127.0.0.1", 0));
  const std::string ours = std::to_string(first.local_port());
  hears("--udp " + std::to_string(20'000 + first.local_port() % 10'000) + " --to 127.0.0.1:" + ours,
        [&](const std::string&) { return &first; });
}

}  // namespace
}  // namespace swiftlet::tools
