// The C++ side of mavlink_peer.py.
//   mavlink_peer_program codec        takes frames from standard input, prints what they say to standard error, and
//                                     sends them again to standard output
//   mavlink_peer_program link PATH [KEY_BYTE]  runs a link on a serial port and prints what it hears, a line each; does
//                                     what commands of number 31010 ask for
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "swiftlet/hal/monotonic_clock.hpp"
#include "swiftlet/hal/posix_uart.hpp"
#include "swiftlet/mavlink/link.hpp"

namespace {

using namespace swiftlet::mavlink;  // NOLINT(google-build-using-namespace): every name below is from there
using swiftlet::Vector3;

std::string line;

void put(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), " %.9g", value);
  line += text.data();
}
void put(const Vector3& v) {
  for (int axis = 0; axis < 3; ++axis) put(static_cast<double>(v[axis]));
}
void put(const Quaternion& q) {
  put(static_cast<double>(q.w()));
  put(Vector3(q.vec()));
}
void put(Address address) {
  put(address.system);
  put(address.component);
}
void put(std::string_view text) { line += " " + std::string(text); }
template <std::size_t kSize>
void put(const std::array<float, kSize>& values) {
  for (const float value : values) put(static_cast<double>(value));
}

template <typename... Values>
void put_all(const Values&... values) {
  (put(values), ...);
}

void show(const Heartbeat& m) {
  put_all(m.custom_mode, m.type, m.autopilot, m.base_mode, static_cast<double>(m.system_status));
}
void show(const SystemStatus& m) {
  put_all(m.sensors_present, m.sensors_enabled, m.sensors_health, m.voltage_mv, m.battery_percent);
}
void show(const ParameterRequest& m) { put_all(m.target, text_of(m.name), m.index); }
void show(const ParameterListRequest& m) { put(m.target); }
void show(const ParameterValue& m) { put_all(text_of(m.name), static_cast<double>(m.value), m.type, m.count, m.index); }
void show(const ParameterSet& m) { put_all(m.target, text_of(m.name), static_cast<double>(m.value), m.type); }
void show(const AttitudeQuaternion& m) { put_all(m.time_boot_ms, m.attitude.value, m.body_rates.value); }
void show(const LocalPositionNed& m) { put_all(m.time_boot_ms, m.position.value, m.velocity.value); }
void show(const CommandInt& m) { put_all(m.target, m.frame, m.command, m.param, m.x, m.y, static_cast<double>(m.z)); }
void show(const CommandLong& m) { put_all(m.target, m.command, m.confirmation, m.param); }
void show(const CommandAck& m) { put_all(m.command, static_cast<double>(m.result), m.target); }
void show(const SetAttitudeTarget& m) {
  put_all(m.time_boot_ms, m.target, m.type_mask, m.attitude.value, m.body_rates.value, static_cast<double>(m.thrust));
}
void show(const SetPositionTarget& m) {
  put_all(m.time_boot_ms, m.target, m.frame, m.type_mask, m.position.value, m.velocity.value, m.acceleration.value,
          static_cast<double>(m.yaw), static_cast<double>(m.yaw_rate));
}
void show(const PositionTarget& m) {
  put_all(m.time_boot_ms, m.frame, m.type_mask, m.position.value, m.velocity.value, m.acceleration.value,
          static_cast<double>(m.yaw), static_cast<double>(m.yaw_rate));
}
void show(const TimeSyncMessage& m) { put_all(static_cast<double>(m.tc1), static_cast<double>(m.ts1)); }
void show(const ExtendedSystemState& m) { put(static_cast<double>(m.landed_state)); }
void show(const StatusText& m) { put_all(static_cast<double>(m.severity), text_of(m.text), m.id, m.chunk); }
void show(const Odometry& m) {
  put_all(static_cast<double>(m.time_us), m.frame, m.child_frame, m.position.value, m.attitude.value, m.velocity_child,
          m.body_rates.value, m.reset_counter);
}
void show(const CurrentMode& m) { put_all(m.standard_mode, m.custom_mode, m.intended_custom_mode); }

template <typename Message>
void echo_as(const Frame& frame, Codec& sender) {
  const auto message = decode<Message>(frame);
  if (!message.has_value()) return;
  line = std::to_string(Message::kId);
  show(*message);
  std::fprintf(stderr, "%s\n", line.c_str());
  const auto bytes = sender.encode(*message);
  if (::write(STDOUT_FILENO, bytes.data(), bytes.size()) < 0) std::exit(1);
}

template <typename... Messages>
void echo(const Frame& frame, Codec& sender) {
  (echo_as<Messages>(frame, sender), ...);
}

int run_codec() {
  Codec receiver({1, kPathPlannerComponent});
  Codec sender({1, kPathPlannerComponent});
  std::array<std::byte, 4096> buffer{};
  while (true) {
    const ssize_t count = ::read(STDIN_FILENO, buffer.data(), buffer.size());
    if (count <= 0) return receiver.counters().skipped_bytes == 0 ? 0 : 1;
    std::span<const std::byte> bytes(buffer.data(), static_cast<std::size_t>(count));
    while (const auto frame = receiver.receive(bytes)) {
      echo<Heartbeat, SystemStatus, ParameterRequest, ParameterListRequest, ParameterValue, ParameterSet,
           AttitudeQuaternion, LocalPositionNed, CommandInt, CommandLong, CommandAck, SetAttitudeTarget,
           SetPositionTarget, PositionTarget, TimeSyncMessage, ExtendedSystemState, StatusText, Odometry, CurrentMode>(
          *frame, sender);
    }
  }
}

void say_line() { std::printf("%s\n", line.c_str()); }

void show_vehicle(const Link& link) {
  const VehicleState state = link.vehicle();
  line = "vehicle";
  put_all(state.position, state.velocity, state.attitude, state.body_rates);
  say_line();
}

/// What command 31010 asks for by its first parameter.
bool act(Link& link, const ReceivedCommand& command) {
  switch (static_cast<int>(command.param[0])) {
    case 1:
      return link.request_mode(Mode::kOffboard);
    case 2:
      return link.request_arm(true);
    case 3:
      return link.send(PositionSetpoint{
          .position = {1, 2, 3}, .velocity = {4, 5, 6}, .acceleration = {7, 8, 9}, .yaw = 0, .yaw_rate = 1});
    case 4:
      return link.send(AttitudeSetpoint{.thrust = swiftlet::Real(0.5)});
    case 5:
      return link.send(RateSetpoint{.body_rates = {1, 2, 3}, .thrust = swiftlet::Real(0.25)});
    case 6:
      return link.send_text(Severity::kNotice, "A text that is longer than the fifty characters of one message");
    case 7:
      return link.align({10, 20, 30}, 0);
    case 8:
      show_vehicle(link);
      return true;
    default:
      return false;
  }
}

void show_events(Link& link, bool& ended) {
  while (const auto command = link.take_command()) {
    line = command->is_int ? "command_int" : "command_long";
    put_all(command->command, command->param);
    if (command->is_int) put_all(command->x, command->y, command->frame);
    say_line();
    ended = ended || command->param[0] == 99;
    const bool done = command->command == 31010 && (ended || act(link, *command));
    link.answer(*command, done ? CommandResult::kAccepted : CommandResult::kUnsupported);
  }
  while (const auto outcome = link.take_outcome()) {
    line = "outcome";
    put_all(outcome->command, static_cast<double>(outcome->kind), static_cast<double>(outcome->result));
    say_line();
  }
  while (const auto text = link.take_text()) {
    line = "text";
    put_all(static_cast<double>(text->severity), text_of(text->text));
    say_line();
  }
  if (const auto goal = link.take_goal()) {
    line = "goal";
    put_all(goal->position, static_cast<double>(goal->yaw.value_or(-100)));
    say_line();
  }
}

int run_link(const char* path, int key_byte) {
  swiftlet::hal::SerialPort port;
  if (!port.open(path, 921600)) return 1;
  swiftlet::hal::MonotonicClock clock;
  std::array<Parameter, 2> parameters{Parameter{"SPEED_MAX", 1.5F, 0, 10, true}, Parameter{"RADIUS", 0.25F, 0, 1}};
  LinkConfig config;
  config.parameters = parameters;
  if (key_byte >= 0) {
    Signing signing;
    signing.key.fill(static_cast<std::byte>(key_byte));
    config.signing = signing;
  }
  static Link link(port, config);
  const auto end = clock.now() + std::chrono::seconds(60);
  bool ended = false;
  bool was_synchronised = false;
  std::puts("ready");
  while (!ended && clock.now() < end && port.is_open()) {
    std::fflush(stdout);
    pollfd waiting{port.descriptor(), POLLIN, 0};
    ::poll(&waiting, 1, 5);
    link.step(clock.now());
    show_events(link, ended);
    if (link.time_sync().synchronised() && !was_synchronised) std::puts("synchronised");
    was_synchronised = link.time_sync().synchronised();
  }
  line = "counters";
  put_all(link.codec_counters().skipped_bytes, link.counters().unauthorised, link.codec_counters().bad_signature,
          link.counters().lost_frames);
  say_line();
  return ended ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string mode = argc > 1 ? argv[1] : "";
  if (mode == "codec") return run_codec();
  if (mode == "link" && argc > 2) return run_link(argv[2], argc > 3 ? std::atoi(argv[3]) : -1);
  return 2;
}
