#include "sim/mavlink_adapter.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "swiftlet/mavlink/frames.hpp"

namespace swiftlet::tools {
namespace {

using mavlink::CommandResult;
using std::chrono::milliseconds;

constexpr std::uint8_t kParameterInt32 = 6;  // MAV_PARAM_TYPE_INT32
constexpr Microseconds kCommanderDelay = milliseconds(10);
constexpr float kForce = 21196;
constexpr std::uint16_t kGimbalCommand = 1000;  // MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW, broadcast on the link
constexpr std::uint32_t kGimbalStream = 0xFFFFFF;
/// Streams of PX4 that can be asked for but are not made here: ATTITUDE, GLOBAL_POSITION_INT, SERVO_OUTPUT_RAW,
/// VFR_HUD, ATTITUDE_TARGET, HIGHRES_IMU, ALTITUDE, BATTERY_STATUS, ESTIMATOR_STATUS.
constexpr std::array<std::uint32_t, 9> kUnsentStreams{30, 33, 36, 74, 83, 105, 141, 147, 230};

/// PX4's custom mode: main mode << 16 | sub-mode << 24.
std::uint32_t custom_mode(FlightMode mode) {
  const auto code = [](std::uint32_t main, std::uint32_t sub) { return main << 16 | sub << 24; };
  switch (mode) {
    case FlightMode::kManual:
      return code(1, 0);
    case FlightMode::kPosctl:
      return code(3, 0);
    case FlightMode::kOffboard:
      return code(6, 0);
    case FlightMode::kLand:
      return code(4, 6);
    case FlightMode::kLoiter:
      return code(4, 3);
  }
  return 0;
}

std::optional<FlightMode> mode_of(float main, float sub) {
  for (const FlightMode mode :
       {FlightMode::kManual, FlightMode::kPosctl, FlightMode::kOffboard, FlightMode::kLand, FlightMode::kLoiter}) {
    const std::uint32_t code = custom_mode(mode);
    const bool has_sub = code >> 24 != 0;
    if (main == static_cast<float>(code >> 16 & 0xFF) && (!has_sub || sub == static_cast<float>(code >> 24))) {
      return mode;
    }
  }
  return std::nullopt;
}

CommandResult to_result(Verdict verdict) { return static_cast<CommandResult>(verdict); }

/// Components whose bit is set, or that are not finite, are not asked for.
Vector3 masked(const mavlink::NedVector& v, unsigned mask, unsigned first_bit) {
  mavlink::NedVector kept = v;
  for (int axis = 0; axis < 3; ++axis) {
    const bool ignored = (mask >> (first_bit + static_cast<unsigned>(axis)) & 1U) != 0;
    if (ignored || !std::isfinite(v.value[axis])) kept.value[axis] = kNotGiven;
  }
  return mavlink::to_enu(kept);
}

/// From our yaw to MAVLink's and back; what is not asked for stays so.
double turned(double yaw) { return std::isfinite(yaw) ? mavlink::ned_yaw(yaw) : kNotGiven; }

mavlink::ParameterName to_name(std::string_view name) {
  mavlink::ParameterName padded{};
  std::copy(name.begin(), name.end(), padded.begin());
  return padded;
}

/// PX4 sends the bytes of an integer in the place of the float.
float encoded(const Parameter& parameter) {
  if (!parameter.integer) return static_cast<float>(parameter.value);
  return std::bit_cast<float>(static_cast<std::int32_t>(parameter.value));
}

double decoded(float value, bool integer) {
  if (!integer) return static_cast<double>(value);
  return std::bit_cast<std::int32_t>(value);
}

std::optional<std::size_t> index_of(std::span<const Parameter> parameters, std::string_view name) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].name == name) return i;
  }
  return std::nullopt;
}

/// A float that stands for a whole number of 24 bits, a message id for one.
std::optional<std::uint32_t> to_id(float value) {
  if (!(value >= 0 && value <= 0xFFFFFF)) return std::nullopt;
  return static_cast<std::uint32_t>(value);
}

}  // namespace

MavlinkAdapter::MavlinkAdapter(Simulation& simulation)
    : simulation_(simulation), codec_({1, mavlink::kAutopilotComponent}) {
  reset();
}

void MavlinkAdapter::reset() {
  using namespace mavlink;
  const double system_id = std::clamp(simulation_.autopilot().parameter(ParameterIndex::kSystemId), 1.0, 255.0);
  const auto system = static_cast<std::uint8_t>(system_id);
  codec_ = Codec({system, kAutopilotComponent});
  const auto stream = [](std::uint32_t id, int interval_ms) {
    return Stream{id, milliseconds(interval_ms), milliseconds(interval_ms)};
  };
  streams_ = {
      stream(Heartbeat::kId, 1000),   stream(SystemStatus::kId, 200),      stream(ExtendedSystemState::kId, 200),
      stream(CurrentMode::kId, 2000), stream(AttitudeQuaternion::kId, 20), stream(LocalPositionNed::kId, 33),
      stream(Odometry::kId, 33),      stream(PositionTarget::kId, 100),    stream(TimeSyncMessage::kId, 100),
      stream(kGimbalStream, 5000)};
  streams_.front().fixed = true;
  for (const std::uint32_t id : kUnsentStreams) streams_.push_back(stream(id, 0));
  commands_.clear();
  asked_parameters_.clear();
  shown_mode_.reset();
  ground_station_ = false;
}

std::uint32_t MavlinkAdapter::clock_ms() const { return static_cast<std::uint32_t>(clock().count() / 1000); }

bool MavlinkAdapter::is_for_us(mavlink::Address target) const {
  const mavlink::Address self = codec_.self();
  return (target.system == self.system || target.system == 0) &&
         (target.component == self.component || target.component == 0);
}

void MavlinkAdapter::set_odometry_fault(OdometryFault fault) {
  if (fault == OdometryFault::kStale && odometry_fault_ != fault) frozen_pose_ = pose();
  if (fault != OdometryFault::kStale) frozen_pose_.reset();
  odometry_fault_ = fault;
}

MavlinkAdapter::Pose MavlinkAdapter::pose() const {
  if (frozen_pose_) return *frozen_pose_;
  Pose pose{clock(), simulation_.estimate()};
  if (odometry_fault_ == OdometryFault::kNan) {
    pose.estimate.position.setConstant(kNotGiven);
    pose.estimate.velocity.setConstant(kNotGiven);
    pose.estimate.attitude.coeffs().setConstant(kNotGiven);
  }
  return pose;
}

// Out.

template <typename M>
void MavlinkAdapter::send(const M& message) {
  const std::span<const std::byte> frame = codec_.encode(message);
  outbox_.emplace_back(frame.begin(), frame.end());
}

std::span<const MavlinkAdapter::Message> MavlinkAdapter::step() {
  const Microseconds now = simulation_.boot_time();
  const Autopilot& autopilot = simulation_.autopilot();
  const std::uint64_t mode =
      std::uint64_t{custom_mode(autopilot.mode())} << 32 | custom_mode(autopilot.intended_mode());
  if (shown_mode_ != mode) send_mode();
  shown_mode_ = mode;
  for (Stream& stream : streams_) {
    if (stream.interval.count() == 0 || now < stream.next) continue;
    send_stream(stream.id);
    stream.next = std::max(stream.next + stream.interval, now);
  }
  while (!commands_.empty() && commands_.front().due <= now) {
    const Command command = commands_.front();
    commands_.pop_front();
    acknowledge(command.from, command.id, carry_out(command));
  }
  if (!asked_parameters_.empty()) {
    send_parameter(asked_parameters_.front());
    asked_parameters_.pop_front();
  }
  for (const Announcement& text : simulation_.autopilot().take_texts()) {
    if (ground_station_) send_text(text);
  }
  given_out_.clear();
  std::swap(given_out_, outbox_);
  return given_out_;
}

void MavlinkAdapter::send_stream(std::uint32_t id) {
  switch (id) {
    case mavlink::Heartbeat::kId:
      return send_heartbeat();
    case mavlink::SystemStatus::kId:
      return send_system_status();
    case mavlink::ExtendedSystemState::kId:
      return send_extended_state();
    case mavlink::CurrentMode::kId:
      return send_mode();
    case mavlink::AttitudeQuaternion::kId:
      return send_attitude();
    case mavlink::LocalPositionNed::kId:
      return send_local_position();
    case mavlink::Odometry::kId:
      return send_odometry();
    case mavlink::PositionTarget::kId:
      return send_position_target();
    case mavlink::TimeSyncMessage::kId:
      return send_timesync();
    case kGimbalStream:
      return send(mavlink::CommandLong{{codec_.self().system, 0}, kGimbalCommand, 0, {}});
    default:
      return;
  }
}

void MavlinkAdapter::send_heartbeat() {
  const Autopilot& autopilot = simulation_.autopilot();
  mavlink::Heartbeat message;
  message.custom_mode = custom_mode(autopilot.mode());
  message.type = mavlink::kTypeQuadrotor;
  message.autopilot = mavlink::kAutopilotPx4;
  message.base_mode = mavlink::kModeFlagCustom;
  if (autopilot.armed()) message.base_mode |= mavlink::kModeFlagArmed;
  message.system_status = static_cast<mavlink::SystemState>(autopilot.system_status());
  send(message);
}

void MavlinkAdapter::send_system_status() {
  mavlink::SystemStatus message;
  message.sensors_present = message.sensors_enabled = mavlink::kSensorPrearmCheck;
  message.sensors_health = simulation_.autopilot().prearm_ok() ? mavlink::kSensorPrearmCheck : 0;
  message.voltage_mv = 16'000;
  message.battery_percent = 100;
  send(message);
}

void MavlinkAdapter::send_extended_state() {
  send(mavlink::ExtendedSystemState{simulation_.autopilot().in_air() ? mavlink::LandedState::kInAir
                                                                     : mavlink::LandedState::kOnGround});
}

void MavlinkAdapter::send_mode() {
  const Autopilot& autopilot = simulation_.autopilot();
  send(mavlink::CurrentMode{custom_mode(autopilot.mode()), custom_mode(autopilot.intended_mode()), 0});
}

void MavlinkAdapter::send_attitude() {
  const Pose now = pose();
  const auto time = static_cast<std::uint32_t>(now.time.count() / 1000);
  send(mavlink::AttitudeQuaternion{time, mavlink::to_ned(now.estimate.attitude), mavlink::to_frd(now.estimate.rate)});
}

void MavlinkAdapter::send_local_position() {
  const Pose now = pose();
  const auto time = static_cast<std::uint32_t>(now.time.count() / 1000);
  send(mavlink::LocalPositionNed{time, mavlink::to_ned(now.estimate.position), mavlink::to_ned(now.estimate.velocity)});
}

/// PX4's estimator publishes its velocity in the local frame and says so; other autopilots send it in the body's.
void MavlinkAdapter::send_odometry() {
  const Pose now = pose();
  mavlink::Odometry message;
  message.time_us = static_cast<std::uint64_t>(now.time.count());
  message.frame = message.child_frame = mavlink::kFrameLocalNed;
  message.position = mavlink::to_ned(now.estimate.position);
  message.attitude = mavlink::to_ned(now.estimate.attitude);
  message.velocity_child = mavlink::to_ned(now.estimate.velocity).value;
  message.body_rates = mavlink::to_frd(now.estimate.rate);
  send(message);
}

void MavlinkAdapter::send_position_target() {
  const std::optional<PositionSetpoint>& target = simulation_.autopilot().position_target();
  if (!target) return;
  mavlink::PositionTarget message;
  message.time_boot_ms = clock_ms();
  message.position = mavlink::to_ned(target->position);
  message.velocity = mavlink::to_ned(target->velocity);
  message.acceleration = mavlink::to_ned(target->acceleration);
  message.yaw = static_cast<float>(turned(target->yaw));
  message.yaw_rate = static_cast<float>(-target->yaw_rate);
  send(message);
}

void MavlinkAdapter::send_timesync() { send(mavlink::TimeSyncMessage{0, clock().count() * 1000}); }

void MavlinkAdapter::send_parameter(std::size_t index) {
  const std::span<const Parameter> parameters = simulation_.autopilot().parameters();
  const Parameter& parameter = parameters[index];
  mavlink::ParameterValue message;
  message.name = to_name(parameter.name);
  message.value = encoded(parameter);
  message.type = parameter.integer ? kParameterInt32 : mavlink::kParameterReal32;
  message.count = static_cast<std::uint16_t>(parameters.size());
  message.index = static_cast<std::uint16_t>(index);
  send(message);
}

/// In pieces of 50 characters.
void MavlinkAdapter::send_text(const Announcement& text) {
  mavlink::StatusText message;
  message.severity = static_cast<mavlink::Severity>(text.severity);
  const std::size_t piece = message.text.size();
  if (text.text.size() > piece) message.id = ++text_id_;
  for (std::size_t at = 0; at < text.text.size(); at += piece) {
    const std::string part = text.text.substr(at, piece);
    message.text = {};
    std::copy(part.begin(), part.end(), message.text.begin());
    message.chunk = static_cast<std::uint8_t>(at / piece);
    send(message);
  }
}

void MavlinkAdapter::acknowledge(const mavlink::Address& to, std::uint16_t id, CommandResult result) {
  send(mavlink::CommandAck{id, result, to});
}

// In. Answers wait in the outbox of the next step.

void MavlinkAdapter::receive(std::span<const std::byte> bytes) {
  while (const std::optional<mavlink::Frame> frame = codec_.receive(bytes)) handle(*frame);
}

void MavlinkAdapter::handle(const mavlink::Frame& frame) {
  using namespace mavlink;
  switch (frame.id) {
    case Heartbeat::kId:
      ground_station_ = ground_station_ || decode<Heartbeat>(frame)->type == kTypeGroundStation;
      return;
    case SetPositionTarget::kId:
      return handle_position_target(*decode<SetPositionTarget>(frame));
    case SetAttitudeTarget::kId:
      return handle_attitude_target(*decode<SetAttitudeTarget>(frame));
    case TimeSyncMessage::kId:
      return handle_timesync(*decode<TimeSyncMessage>(frame));
    case ParameterSet::kId:
      return handle_parameter_set(*decode<ParameterSet>(frame));
    case ParameterRequest::kId:
      return handle_parameter_request(*decode<ParameterRequest>(frame));
    case ParameterListRequest::kId: {
      if (!is_for_us(decode<ParameterListRequest>(frame)->target)) return;
      for (std::size_t i = 0; i < simulation_.autopilot().parameters().size(); ++i) asked_parameters_.push_back(i);
      return;
    }
    case CommandLong::kId: {
      const auto message = *decode<CommandLong>(frame);
      const std::array<float, 4> param{message.param[0], message.param[1], message.param[2], message.param[3]};
      return handle_command(frame.from, message.target, message.command, param);
    }
    case CommandInt::kId: {
      const auto message = *decode<CommandInt>(frame);
      return handle_command(frame.from, message.target, message.command, message.param);
    }
    default:
      return;
  }
}

/// PX4 takes set-points in the local frame (and one that turns with the vehicle, left out here) as long as anything is
/// asked for.
void MavlinkAdapter::handle_position_target(const mavlink::SetPositionTarget& message) {
  if (!is_for_us(message.target) || drops_setpoints_) return;
  if (message.frame != mavlink::kFrameLocalNed || (message.type_mask & mavlink::kAccelerationIsForce) != 0) return;
  PositionSetpoint target;
  target.position = masked(message.position, message.type_mask, 0);
  target.velocity = masked(message.velocity, message.type_mask, 3);
  target.acceleration = masked(message.acceleration, message.type_mask, 6);
  if ((message.type_mask & mavlink::kIgnoreYaw) == 0) target.yaw = turned(message.yaw);
  const bool has_yaw_rate = (message.type_mask & mavlink::kIgnoreYawRate) == 0 && std::isfinite(message.yaw_rate);
  if (has_yaw_rate) target.yaw_rate = -message.yaw_rate;
  const auto asks = [](const Vector3& v) { return !v.array().isNaN().all(); };
  if (!asks(target.position) && !asks(target.velocity) && !asks(target.acceleration)) return;
  simulation_.autopilot().set_target(target, simulation_.now());
}

void MavlinkAdapter::handle_attitude_target(const mavlink::SetAttitudeTarget& message) {
  if (!is_for_us(message.target) || drops_setpoints_) return;
  AttitudeSetpoint target;
  target.has_attitude = (message.type_mask & mavlink::kIgnoreAttitude) == 0;
  constexpr unsigned kIgnoreRollAndPitchRate = 0x03;
  const bool has_rates = (message.type_mask & kIgnoreRollAndPitchRate) == 0;
  if (!target.has_attitude && !has_rates) return;
  const mavlink::Quaternion& q = message.attitude.value;
  const bool usable = message.body_rates.value.allFinite() && std::isfinite(message.thrust) &&
                      (!target.has_attitude || (q.coeffs().allFinite() && q.norm() > 0.5));
  if (!usable) return;
  target.rate = mavlink::to_flu(message.body_rates);
  if (target.has_attitude) {
    target.attitude = mavlink::to_enu(mavlink::NedQuaternion{q.normalized()});
    constexpr unsigned kIgnoreYawOfRates = 0x04;
    if ((message.type_mask & kIgnoreYawOfRates) != 0) target.rate.z() = 0;
  }
  const bool has_thrust = (message.type_mask & mavlink::kIgnoreThrust) == 0;
  target.thrust = has_thrust ? std::clamp(static_cast<double>(message.thrust), 0.0, 1.0) : 0;
  simulation_.autopilot().set_target(target, simulation_.now());
}

void MavlinkAdapter::handle_timesync(const mavlink::TimeSyncMessage& message) {
  if (message.tc1 != 0) return;  // an answer to ours
  send(mavlink::TimeSyncMessage{clock().count() * 1000, message.ts1});
}

void MavlinkAdapter::handle_parameter_set(const mavlink::ParameterSet& message) {
  Autopilot& autopilot = simulation_.autopilot();
  const std::optional<std::size_t> index = index_of(autopilot.parameters(), mavlink::text_of(message.name));
  if (!is_for_us(message.target) || !index) return;
  const double value = decoded(message.value, autopilot.parameters()[*index].integer);
  if (std::isfinite(value)) autopilot.set_parameter(static_cast<ParameterIndex>(*index), value);
  asked_parameters_.push_back(*index);
}

void MavlinkAdapter::handle_parameter_request(const mavlink::ParameterRequest& message) {
  const std::span<const Parameter> parameters = simulation_.autopilot().parameters();
  if (!is_for_us(message.target)) return;
  if (message.index < 0) {
    if (const auto index = index_of(parameters, mavlink::text_of(message.name))) asked_parameters_.push_back(*index);
  } else if (static_cast<std::size_t>(message.index) < parameters.size()) {
    asked_parameters_.push_back(static_cast<std::size_t>(message.index));
  }
}

/// The receiver answers what concerns the link at once. A mode command it passes on, and says "accepted" to that; the
/// commander's verdict is a second acknowledgement.
void MavlinkAdapter::handle_command(const mavlink::Address& from, const mavlink::Address& target, std::uint16_t id,
                                    const std::array<float, 4>& param) {
  if (!is_for_us(target)) return;
  switch (id) {
    case mavlink::kCommandSetMessageInterval:
      return acknowledge(from, id, set_interval(param[0], param[1]));
    case mavlink::kCommandRequestMessage:
      return acknowledge(from, id, request_message(param[0]));
    case mavlink::kCommandDoSetMode:
      acknowledge(from, id, CommandResult::kAccepted);
      [[fallthrough]];
    case mavlink::kCommandArmDisarm:
      commands_.push_back({simulation_.boot_time() + kCommanderDelay, from, id, param});
      return;
    default:
      return acknowledge(from, id, CommandResult::kUnsupported);
  }
}

CommandResult MavlinkAdapter::set_interval(float id, float interval_us) {
  const auto stream =
      std::find_if(streams_.begin(), streams_.end(), [&](const Stream& each) { return to_id(id) == each.id; });
  if (stream == streams_.end() || !std::isfinite(interval_us)) return CommandResult::kFailed;
  if (stream->fixed) return CommandResult::kAccepted;
  const auto wanted = Microseconds(static_cast<std::int64_t>(std::clamp(interval_us, -1.0F, 1e9F)));
  stream->interval = wanted.count() == 0 ? stream->usual : std::max(wanted, Microseconds{0});
  stream->next = simulation_.boot_time();
  return CommandResult::kAccepted;
}

CommandResult MavlinkAdapter::request_message(float id) {
  const auto stream =
      std::find_if(streams_.begin(), streams_.end(), [&](const Stream& each) { return to_id(id) == each.id; });
  if (stream == streams_.end()) return CommandResult::kFailed;
  send_stream(stream->id);
  return CommandResult::kAccepted;
}

CommandResult MavlinkAdapter::carry_out(const Command& command) {
  Autopilot& autopilot = simulation_.autopilot();
  const double now = simulation_.now();
  if (command.id == mavlink::kCommandArmDisarm) {
    const bool forced = command.param[1] == kForce;
    return to_result(command.param[0] > 0.5F ? autopilot.arm(forced, now) : autopilot.disarm(forced));
  }
  const std::optional<std::uint32_t> base_mode = to_id(command.param[0]);
  const bool custom = base_mode && (*base_mode & mavlink::kModeFlagCustom) != 0;
  const std::optional<FlightMode> mode = custom ? mode_of(command.param[1], command.param[2]) : std::nullopt;
  if (!mode) return CommandResult::kDenied;
  return to_result(autopilot.set_mode(*mode, now));
}

}  // namespace swiftlet::tools
