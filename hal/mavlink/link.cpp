#include "swiftlet/mavlink/link.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace swiftlet::mavlink {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

constexpr std::size_t kMaxBytesInAStep = 4096;
constexpr microseconds kHeartbeatPeriod = seconds(1);
constexpr microseconds kTimeSyncPeriod = milliseconds(200);
constexpr microseconds kSilence = seconds(3);  // after which an autopilot may have forgotten what was asked of it
constexpr microseconds kRestartJump = seconds(1);
constexpr microseconds kStaleRest = milliseconds(50);  // of a frame that the device takes piece by piece

// PX4 acknowledges within 20 ms (docs/link.md); its HEARTBEAT, the slower of the two sights of a mode, is 1 Hz.
constexpr microseconds kRepeatAfter = milliseconds(300);
constexpr microseconds kSightOfMode = milliseconds(2500);
constexpr microseconds kProgress = seconds(3);
constexpr std::uint8_t kMaxTransmissions = 4;
constexpr microseconds kRepetitionWindow = seconds(3);

constexpr auto kLatestStamp = static_cast<std::uint64_t>(std::chrono::duration_cast<microseconds>(kLatestTime).count());
constexpr float kLargestYaw = 1e6F;  // [rad] of a goal; there is no turn in the digits of more

constexpr std::array kDefaultRates{
    MessageRate{LocalPositionNed::kId, 50},
    MessageRate{AttitudeQuaternion::kId, 100},
    MessageRate{CurrentMode::kId, 10},
    MessageRate{ExtendedSystemState::kId, 5},
    MessageRate{SystemStatus::kId, 2},
    MessageRate{Odometry::kId, 0},
    MessageRate{30, 0},   // ATTITUDE
    MessageRate{105, 0},  // HIGHRES_IMU
    MessageRate{33, 0},   // GLOBAL_POSITION_INT
    MessageRate{85, 0},   // POSITION_TARGET_LOCAL_NED
    MessageRate{83, 0},   // ATTITUDE_TARGET
    MessageRate{36, 0},   // SERVO_OUTPUT_RAW
    MessageRate{74, 0},   // VFR_HUD
    MessageRate{141, 0},  // ALTITUDE
};

template <typename... Values>
bool all_finite(const Values&... values) {
  return (std::isfinite(values) && ...);
}

/// A rotation that was rounded to float on its way, made exact; nothing for what is none.
std::optional<Quaternion> as_rotation(const Quaternion& q) {
  const Real norm = q.norm();
  if (!(norm > Real(0.9) && norm < Real(1.1))) return std::nullopt;  // false for NaN as well
  return Quaternion(q.coeffs() / norm);
}

/// Equal bits: a NaN, which commands carry for "unchanged", equals itself.
bool same(const ReceivedCommand& a, const ReceivedCommand& b) {
  using Bits = std::array<std::uint32_t, 7>;
  return a.from == b.from && a.is_int == b.is_int && a.command == b.command && a.x == b.x && a.y == b.y &&
         a.frame == b.frame && std::bit_cast<Bits>(a.param) == std::bit_cast<Bits>(b.param);
}

float to_float(Real value) { return static_cast<float>(value); }

}  // namespace

std::span<const MessageRate> default_rates() { return kDefaultRates; }

Link::Link(hal::Uart& uart, const LinkConfig& config)
    : uart_(uart),
      codec_({config.system_id, kPathPlannerComponent}),
      autopilot_address_{config.system_id, kAutopilotComponent},
      rates_(config.rates),
      parameters_(config.parameters),
      autopilot_signs_(config.autopilot_signs),
      next_rate_(config.rates.size()),
      next_parameter_(config.parameters.size()) {
  if (!config.signing.has_value()) return;
  codec_.sign_with(*config.signing);
  signing_start_ = config.signing->time;
}

void Link::step(microseconds now) {
  now_ = now;
  if (!started_) {
    started_ = true;
    start_ = next_heartbeat_ = next_time_sync_ = now;
  }
  if (codec_.signs()) {
    codec_.advance_signing_time(signing_start_ + static_cast<std::uint64_t>((now - start_) / microseconds(10)));
  }
  flush();
  receive();
  send_due();
}

void Link::shift_clock(microseconds jump) {
  start_ += jump;
  backlog_since_ += jump;
  next_heartbeat_ += jump;
  next_time_sync_ = now_ + jump;  // the clocks meet anew
  time_sync_asked_.fill(0);
  if (!requests_.empty()) requests_.front().next_at += jump;  // the others have not been sent yet
  if (!parameter_questions_.empty()) parameter_questions_.front().next_at += jump;
  if (latest_command_.has_value()) latest_command_->at += jump;
}

// ---- Receiving

void Link::receive() {
  std::array<std::byte, 512> buffer{};
  for (std::size_t total = 0; total < kMaxBytesInAStep;) {
    const std::size_t count = uart_.read(buffer);
    if (count == 0) return;
    total += count;
    counters_.received_bytes += count;
    std::span<const std::byte> bytes(buffer.data(), count);
    while (const std::optional<Frame> frame = codec_.receive(bytes)) dispatch(*frame);
  }
}

void Link::dispatch(const Frame& frame) {
  const bool from_autopilot = frame.from == autopilot_address_;
  if (from_autopilot) count_losses(frame.sequence);
  if (take_for_us(frame)) return;
  if (!from_autopilot) {
    ++counters_.foreign;
  } else if (autopilot_signs_ && codec_.signs() && !frame.authentic) {
    ++counters_.unauthorised;
  } else if (!take_autopilot(frame)) {
    ++counters_.unused;
  }
}

/// Whether the sender may make us do something.
bool Link::is_authorised(const Frame& frame) {
  if (!codec_.signs() || frame.authentic) return true;
  ++counters_.unauthorised;
  return false;
}

void Link::count_losses(std::uint8_t sequence) {
  if (next_sequence_.has_value()) counters_.lost_frames += static_cast<std::uint8_t>(sequence - *next_sequence_);
  next_sequence_ = static_cast<std::uint8_t>(sequence + 1);
}

// ---- The autopilot

bool Link::take_autopilot(const Frame& frame) {
  const auto take_as = [this, &frame]<typename Message>() {
    const std::optional<Message> message = decode<Message>(frame);
    if (message.has_value()) take(*message);
    return message.has_value();
  };
  return take_as.operator()<AttitudeQuaternion>() || take_as.operator()<LocalPositionNed>() ||
         take_as.operator()<Odometry>() || take_as.operator()<TimeSyncMessage>() || take_as.operator()<Heartbeat>() ||
         take_as.operator()<CurrentMode>() || take_as.operator()<SystemStatus>() ||
         take_as.operator()<ExtendedSystemState>() || take_as.operator()<CommandAck>() ||
         take_as.operator()<ParameterValue>();
}

void Link::take(const Heartbeat& heartbeat) {
  if (!autopilot_.heard || now_ - autopilot_.heard_at > kSilence) next_rate_ = 0;
  autopilot_.heard = true;
  autopilot_.heard_at = now_;
  autopilot_.kind = kind_of(heartbeat);
  autopilot_.system_state = heartbeat.system_status;
  autopilot_.armed = (heartbeat.base_mode & kModeFlagArmed) != 0;
  set_mode(mode_of(autopilot_.kind, heartbeat.custom_mode), heartbeat.custom_mode);
}

void Link::take(const CurrentMode& mode) {
  if (!autopilot_.heard) return;  // the numbers mean nothing before we know whose they are
  autopilot_.intended_mode = mode_of(autopilot_.kind, mode.intended_custom_mode);
  set_mode(mode_of(autopilot_.kind, mode.custom_mode), mode.custom_mode);
}

void Link::set_mode(Mode mode, std::uint32_t custom_mode) {
  autopilot_.mode = mode;
  autopilot_.custom_mode = custom_mode;
  autopilot_.mode_at = now_;
  if (requests_.empty()) return;
  const Request& request = requests_.front();
  if (request.awaited_mode == mode && request.transmissions > 0) {
    finish_request(Outcome::Kind::kDone, CommandResult::kAccepted);
  }
}

void Link::take(const SystemStatus& status) {
  autopilot_.prearm_ok = (status.sensors_health & kSensorPrearmCheck) != 0;
  autopilot_.battery_mv = status.voltage_mv;
}

void Link::take(const ExtendedSystemState& state) { autopilot_.landed_state = state.landed_state; }

void Link::take(const LocalPositionNed& message) {
  const Vector3 position = to_enu(message.position);
  const Vector3 velocity = to_enu(message.velocity);
  const microseconds at = sampled_at(milliseconds(message.time_boot_ms), Stamp::kPosition);
  set_position(position, velocity, at);
}

void Link::take(const AttitudeQuaternion& message) {
  const microseconds at = sampled_at(milliseconds(message.time_boot_ms), Stamp::kAttitude);
  set_attitude(to_enu(message.attitude), to_flu(message.body_rates), at);
}

void Link::take(const Odometry& message) {
  const std::optional<Quaternion> attitude = as_rotation(message.attitude.value);
  const bool velocity_in_body = message.child_frame == kFrameBodyFrd || message.child_frame == kFrameBodyNed;
  const bool known_frames = velocity_in_body || message.child_frame == kFrameLocalNed;
  const bool usable = attitude.has_value() && message.time_us <= kLatestStamp;
  if (!usable || message.frame != kFrameLocalNed || !known_frames) {
    ++counters_.refused_values;
    if (!usable) ++local_.refused_count;
    return;
  }
  const NedVector velocity{velocity_in_body ? Vector3(*attitude * message.velocity_child) : message.velocity_child};
  const microseconds at = sampled_at(microseconds(static_cast<std::int64_t>(message.time_us)), Stamp::kOdometry);
  local_.reset_counter = message.reset_counter;
  set_position(to_enu(message.position), to_enu(velocity), at);
  set_attitude(to_enu(NedQuaternion{*attitude}), to_flu(message.body_rates), at);
}

void Link::set_position(const Vector3& position, const Vector3& velocity, microseconds sampled_at) {
  if (!position.allFinite() || !velocity.allFinite()) {
    ++counters_.refused_values;
    ++local_.refused_count;
    return;
  }
  local_.has_position = true;
  local_.position_received_at = now_;
  local_.position_sampled_at = sampled_at;
  ++local_.position_count;
  local_.position = position;
  local_.velocity = velocity;
}

void Link::set_attitude(const Quaternion& attitude, const Vector3& body_rates, microseconds sampled_at) {
  const std::optional<Quaternion> rotation = as_rotation(attitude);
  if (!rotation.has_value() || !body_rates.allFinite()) {
    ++counters_.refused_values;
    ++local_.refused_count;
    return;
  }
  local_.has_attitude = true;
  local_.attitude_received_at = now_;
  local_.attitude_sampled_at = sampled_at;
  ++local_.attitude_count;
  local_.attitude = *rotation;
  local_.body_rates = body_rates;
}

/// A time since the autopilot's boot on our clock: the time of reception as long as the clocks have not met. Each kind
/// of message is compared with itself, since ODOMETRY may count from 1970.
microseconds Link::sampled_at(microseconds boot_time, Stamp stamp) {
  microseconds& latest = latest_boot_times_[static_cast<std::size_t>(stamp)];
  if (boot_time + kRestartJump < latest) {
    ++autopilot_.restarts;
    time_sync_.reset();
    next_rate_ = 0;
    latest_boot_times_.fill(microseconds(0));
  }
  latest = std::max(latest, boot_time);
  return time_sync_.synchronised() ? std::min(time_sync_.to_ours(boot_time), now_) : now_;
}

void Link::take(const TimeSyncMessage& message) {
  const std::int64_t now = nanoseconds(now_).count();
  if (message.tc1 == 0) {
    transmit(TimeSyncMessage{.tc1 = std::max<std::int64_t>(now, 1), .ts1 = message.ts1});
    return;
  }
  const auto asked = std::find(time_sync_asked_.begin(), time_sync_asked_.end(), message.ts1);
  if (message.ts1 == 0 || asked == time_sync_asked_.end()) return;
  time_sync_.add(nanoseconds(message.ts1), nanoseconds(message.tc1), nanoseconds(now));
  *asked = 0;
}

VehicleState Link::vehicle() const {
  VehicleState state = local_;
  state.position = alignment_.point_to_map(local_.position);
  state.velocity = alignment_.vector_to_map(local_.velocity);
  state.attitude = alignment_.attitude_to_map(local_.attitude);
  return state;
}

bool Link::align(const Vector3& position, Real yaw) {
  if (!local_.has_position || !local_.has_attitude) return false;
  if (!position.allFinite() || !std::isfinite(yaw)) return false;
  align(Alignment(local_.position, yaw_of(local_.attitude), position, yaw));
  return true;
}

void Link::align(const Alignment& alignment) {
  alignment_ = alignment;
  aligned_ = true;
}

// ---- Requests to the autopilot

bool Link::request_mode(Mode mode) {
  const std::optional<CommandLong> command = set_mode_command(autopilot_.kind, mode);
  return command.has_value() && requests_.try_push_back({.command = *command, .awaited_mode = mode});
}

bool Link::request_arm(bool armed) { return request(kCommandArmDisarm, {armed ? 1.0F : 0.0F}); }

bool Link::request(std::uint16_t command, const std::array<float, 7>& param) {
  Request request;
  request.command.command = command;
  request.command.param = param;
  return requests_.try_push_back(request);
}

void Link::cancel_requests() {
  for (std::size_t left = requests_.size(); left > 0; --left) {
    const std::optional<Request> request = requests_.pop_front();
    if (request->is_rate) static_cast<void>(requests_.try_push_back(*request));
  }
}

void Link::take(const CommandAck& ack) {
  const bool for_others = ack.target.system != 0 && ack.target != codec_.self();
  if (for_others) {
    ++counters_.foreign;
    return;
  }
  const bool awaited =
      !requests_.empty() && requests_.front().transmissions > 0 && requests_.front().command.command == ack.command;
  if (!awaited) {
    ++counters_.stray_acknowledgements;
    return;
  }
  Request& request = requests_.front();
  if (ack.result == CommandResult::kInProgress) {
    request.transmissions = kMaxTransmissions;
    request.next_at = now_ + kProgress;
  } else if (ack.result == CommandResult::kAccepted && request.awaited_mode != Mode::kUnknown) {
    // PX4's receiver accepts every change of mode before its commander decides: only the mode itself tells.
    request.acknowledged = true;
    request.next_at = now_ + kSightOfMode;
  } else {
    const bool accepted = ack.result == CommandResult::kAccepted;
    finish_request(accepted ? Outcome::Kind::kDone : Outcome::Kind::kRejected, ack.result);
  }
}

void Link::advance_request() {
  if (requests_.empty()) queue_rate();
  if (requests_.empty()) return;
  Request& request = requests_.front();
  if (request.transmissions > 0 && now_ < request.next_at) return;
  if (request.acknowledged || request.transmissions >= kMaxTransmissions) {
    finish_request(Outcome::Kind::kNoAnswer, CommandResult::kFailed);
    return;
  }
  request.command.target = autopilot_address_;
  request.command.confirmation = request.transmissions;
  if (!transmit(request.command)) return;  // the device is full; the next step tries again
  ++request.transmissions;
  request.next_at = now_ + kRepeatAfter;
}

void Link::finish_request(Outcome::Kind kind, CommandResult result) {
  const std::optional<Request> request = requests_.pop_front();
  if (request->is_rate) {
    if (kind != Outcome::Kind::kDone) ++counters_.refused_rates;
    return;
  }
  const Outcome outcome{kind, request->command.command, request->command.param, result};
  if (!outcomes_.try_push_back(outcome)) ++counters_.dropped_events;
}

/// The next of the message rates, when the autopilot has come or come back.
void Link::queue_rate() {
  if (next_rate_ >= rates_.size()) return;
  const MessageRate& rate = rates_[next_rate_++];
  Request request;
  request.is_rate = true;
  request.command.command = kCommandSetMessageInterval;
  request.command.param[0] = static_cast<float>(rate.id);
  request.command.param[1] = rate.hz > 0 ? 1e6F / rate.hz : -1.0F;  // [us]; -1: never
  static_cast<void>(requests_.try_push_back(request));              // into an empty ring
}

// ---- Parameters of the autopilot

bool Link::request_parameter(std::string_view name) {
  ParameterQuestion question;
  if (name.size() > question.name.size()) return false;
  std::copy(name.begin(), name.end(), question.name.begin());
  return parameter_questions_.try_push_back(question);
}

void Link::ask_for_parameter() {
  if (parameter_questions_.empty()) return;
  ParameterQuestion& question = parameter_questions_.front();
  if (question.transmissions > 0 && now_ < question.next_at) return;
  if (question.transmissions >= kMaxTransmissions) return answer_parameter(std::nullopt);
  if (!transmit(ParameterRequest{.target = autopilot_address_, .name = question.name})) return;
  ++question.transmissions;
  question.next_at = now_ + kRepeatAfter;
}

/// PX4 does not say whom it answers.
void Link::take(const ParameterValue& parameter) {
  const bool awaited = !parameter_questions_.empty() && parameter_questions_.front().transmissions > 0 &&
                       text_of(parameter_questions_.front().name) == text_of(parameter.name);
  if (!awaited) {
    ++counters_.unused;
    return;
  }
  const bool usable = parameter.type == kParameterReal32 && std::isfinite(parameter.value);
  if (!usable) ++counters_.refused_values;
  answer_parameter(usable ? std::optional(parameter.value) : std::nullopt);
}

void Link::answer_parameter(std::optional<float> value) {
  const std::optional<ParameterQuestion> question = parameter_questions_.pop_front();
  if (!parameter_answers_.try_push_back({question->name, value})) ++counters_.dropped_events;
}

// ---- Set-points

bool Link::send(const PositionSetpoint& setpoint) {
  const bool finite = setpoint.position.allFinite() && setpoint.velocity.allFinite() &&
                      setpoint.acceleration.allFinite() && all_finite(setpoint.yaw, setpoint.yaw_rate);
  if (!finite) {
    ++counters_.refused_setpoints;
    return false;
  }
  SetPositionTarget target;
  target.time_boot_ms = static_cast<std::uint32_t>(now_ / milliseconds(1));
  target.target = autopilot_address_;
  target.position = to_ned(alignment_.point_to_local(setpoint.position));
  target.velocity = to_ned(alignment_.vector_to_local(setpoint.velocity));
  target.acceleration = to_ned(alignment_.vector_to_local(setpoint.acceleration));
  target.yaw = to_float(ned_yaw(alignment_.yaw_to_local(setpoint.yaw)));
  target.yaw_rate = to_float(-setpoint.yaw_rate);
  return transmit(target);
}

bool Link::send(const AttitudeSetpoint& setpoint) {
  const std::optional<Quaternion> attitude = as_rotation(setpoint.attitude);
  if (!attitude.has_value()) {
    ++counters_.refused_setpoints;
    return false;
  }
  SetAttitudeTarget target;
  target.type_mask = kIgnoreBodyRates;
  target.attitude = to_ned(alignment_.attitude_to_local(*attitude));
  return send_target(target, setpoint.thrust);
}

bool Link::send(const RateSetpoint& setpoint) {
  if (!setpoint.body_rates.allFinite()) {
    ++counters_.refused_setpoints;
    return false;
  }
  SetAttitudeTarget target;
  target.type_mask = kIgnoreAttitude;
  target.body_rates = to_frd(setpoint.body_rates);
  return send_target(target, setpoint.thrust);
}

bool Link::send_target(SetAttitudeTarget target, Real thrust) {
  if (!(thrust >= 0 && thrust <= 1)) {  // false for NaN as well
    ++counters_.refused_setpoints;
    return false;
  }
  target.time_boot_ms = static_cast<std::uint32_t>(now_ / milliseconds(1));
  target.target = autopilot_address_;
  target.thrust = to_float(thrust);
  return transmit(target);
}

// ---- Messages for us, from anybody

bool Link::take_for_us(const Frame& frame) {
  const auto take_as = [this, &frame]<typename Message>() {
    const std::optional<Message> message = decode<Message>(frame);
    if (!message.has_value() || message->target != codec_.self()) return false;
    take(*message, frame);
    return true;
  };
  if (take_as.operator()<SetPositionTarget>() || take_as.operator()<CommandLong>() ||
      take_as.operator()<CommandInt>() || take_as.operator()<ParameterRequest>() ||
      take_as.operator()<ParameterSet>()) {
    return true;
  }
  if (const auto list = decode<ParameterListRequest>(frame)) {  // also to all components
    const bool ours = list->target.system == codec_.self().system &&
                      (list->target.component == 0 || list->target.component == codec_.self().component);
    if (ours) next_parameter_ = 0;
    return ours;
  }
  if (const auto text = decode<StatusText>(frame)) {
    take(*text, frame);
    return true;
  }
  return false;
}

void Link::take(const CommandLong& message, const Frame& frame) {
  ReceivedCommand command;
  command.from = frame.from;
  command.command = message.command;
  command.param = message.param;
  take(command, message.confirmation > 0, frame);
}

void Link::take(const CommandInt& message, const Frame& frame) {
  ReceivedCommand command;
  command.from = frame.from;
  command.is_int = true;
  command.command = message.command;
  std::copy(message.param.begin(), message.param.end(), command.param.begin());
  command.param[6] = message.z;
  command.x = message.x;
  command.y = message.y;
  command.frame = message.frame;
  take(command, true, frame);  // it does not say whether it is one
}

/// A repetition of the latest command is answered again and not carried out again.
void Link::take(const ReceivedCommand& command, bool may_be_repetition, const Frame& frame) {
  if (!is_authorised(frame)) {
    acknowledge(command, CommandResult::kDenied);
    return;
  }
  const bool is_repetition = may_be_repetition && latest_command_.has_value() &&
                             same(latest_command_->command, command) && now_ - latest_command_->at < kRepetitionWindow;
  if (is_repetition) {
    if (latest_command_->result.has_value()) acknowledge(command, *latest_command_->result);
    return;
  }
  if (!commands_.try_push_back(command)) {
    ++counters_.dropped_events;
    acknowledge(command, CommandResult::kTemporarilyRejected);
    return;
  }
  latest_command_ = {.command = command, .at = now_, .result = std::nullopt};
}

void Link::answer(const ReceivedCommand& command, CommandResult result) {
  if (latest_command_.has_value() && same(latest_command_->command, command)) latest_command_->result = result;
  acknowledge(command, result);
}

void Link::acknowledge(const ReceivedCommand& command, CommandResult result) {
  transmit(CommandAck{.command = command.command, .result = result, .target = command.from});
}

/// A goal in the autopilot's local frame, or with MAV_FRAME_LOCAL_FLU in the map's own coordinates.
void Link::take(const SetPositionTarget& target, const Frame& frame) {
  if (!is_authorised(frame)) return;
  const bool has_yaw = (target.type_mask & kIgnoreYaw) == 0;
  const bool usable = (target.type_mask & kIgnorePosition) == 0 && target.position.value.allFinite() &&
                      (!has_yaw || std::fabs(target.yaw) <= kLargestYaw) &&
                      (target.frame == kFrameLocalNed || target.frame == kFrameLocalFlu);
  if (!usable) {
    ++counters_.refused_values;
    return;
  }
  Goal goal;
  goal.from = frame.from;
  const bool in_map = target.frame == kFrameLocalFlu;
  goal.local = !in_map;
  goal.position = in_map ? target.position.value : alignment_.point_to_map(to_enu(target.position));
  if (has_yaw) goal.yaw = in_map ? wrap_angle(Real(target.yaw)) : alignment_.yaw_to_map(enu_yaw(Real(target.yaw)));
  goal_ = goal;
}

std::optional<Goal> Link::take_goal() {
  std::optional<Goal> goal = goal_;
  goal_.reset();
  return goal;
}

// ---- Parameters of ours

void Link::take(const ParameterRequest& request, const Frame& /*frame*/) {
  const std::size_t index =
      request.index >= 0 ? static_cast<std::size_t>(request.index) : find_parameter(text_of(request.name));
  send_parameter(index);
}

/// Answers with the value in force, whether it was changed or not, as the protocol asks.
void Link::take(const ParameterSet& set, const Frame& frame) {
  const std::size_t index = find_parameter(text_of(set.name));
  if (index >= parameters_.size() || !is_authorised(frame)) return;
  Parameter& parameter = parameters_[index];
  const bool in_range = set.value >= parameter.lowest && set.value <= parameter.highest;  // false for NaN as well
  if (parameter.settable && set.type == kParameterReal32 && in_range) {
    parameter.value = set.value;
    ++parameter_changes_;
  }
  send_parameter(index);
}

std::size_t Link::find_parameter(std::string_view name) const {
  const auto found = std::find_if(parameters_.begin(), parameters_.end(),
                                  [name](const Parameter& parameter) { return parameter.name == name; });
  return static_cast<std::size_t>(found - parameters_.begin());
}

void Link::send_parameter(std::size_t index) {
  if (index >= parameters_.size()) return;
  const Parameter& parameter = parameters_[index];
  ParameterValue value;
  std::copy_n(parameter.name.begin(), std::min(parameter.name.size(), value.name.size()), value.name.begin());
  value.value = parameter.value;
  value.count = static_cast<std::uint16_t>(parameters_.size());
  value.index = static_cast<std::uint16_t>(index);
  transmit(value);
}

// ---- Texts

void Link::take(const StatusText& message, const Frame& frame) {
  const std::string_view piece = text_of(message.text);
  const bool goes_on = message.id != 0 && message.id == partial_text_.id && frame.from == partial_text_.text.from &&
                       message.chunk == partial_text_.next_chunk;
  if (!goes_on) {
    finish_text();
    if (message.id != 0 && message.chunk != 0) {  // its beginning was lost
      ++counters_.dropped_events;
      return;
    }
    partial_text_.text.from = frame.from;
    partial_text_.text.severity = message.severity;
  }
  const std::size_t count = std::min(piece.size(), partial_text_.text.text.size() - partial_text_.size);
  std::copy_n(piece.begin(), count, partial_text_.text.text.begin() + static_cast<std::ptrdiff_t>(partial_text_.size));
  partial_text_.size += count;
  partial_text_.id = message.id;
  partial_text_.next_chunk = static_cast<std::uint8_t>(message.chunk + 1);
  const bool is_last = message.id == 0 || piece.size() < message.text.size();
  if (is_last || partial_text_.size == partial_text_.text.text.size()) finish_text();
}

void Link::finish_text() {
  if (partial_text_.size > 0 && !texts_.try_push_back(partial_text_.text)) ++counters_.dropped_events;
  partial_text_ = {};
}

bool Link::send_text(Severity severity, std::string_view text) {
  StatusText message;
  message.severity = severity;
  const std::size_t piece = message.text.size();
  if (text.size() > piece) {
    text_id_ = static_cast<std::uint16_t>(text_id_ % 0xFFFFU + 1U);  // 0 stands for a text in one piece
    message.id = text_id_;
  }
  bool sent = true;
  text = {text.data(), std::min(text.size(), Text{}.text.size())};  // substr may throw
  // A last piece that fills its message is followed by an empty one: only a zero ends a text.
  do {
    const std::string_view part(text.data(), std::min(text.size(), piece));
    message.text = {};
    std::copy(part.begin(), part.end(), message.text.begin());
    sent = transmit(message) && sent;
    ++message.chunk;
    text.remove_prefix(part.size());
    if (part.size() < piece || message.id == 0) break;
  } while (true);
  return sent;
}

// ---- Sending

void Link::send_due() {
  if (now_ >= next_heartbeat_) {
    Heartbeat heartbeat;
    heartbeat.type = kTypeOnboardController;
    heartbeat.autopilot = kAutopilotInvalid;
    heartbeat.system_status = own_state_;
    transmit(heartbeat);
    next_heartbeat_ = now_ + kHeartbeatPeriod;
  }
  if (now_ >= next_time_sync_ && autopilot_.heard) {
    const std::int64_t asked = nanoseconds(now_).count();
    if (transmit(TimeSyncMessage{.tc1 = 0, .ts1 = asked})) {
      std::shift_left(time_sync_asked_.begin(), time_sync_asked_.end(), 1);
      time_sync_asked_.back() = asked;
    }
    next_time_sync_ = now_ + kTimeSyncPeriod;
  }
  advance_request();
  ask_for_parameter();
  if (next_parameter_ < parameters_.size() && backlog_size_ == 0) send_parameter(next_parameter_++);
}

/// Whole frames only: what the device does not take of one is kept and goes first, unless it gets stale; a frame of
/// which it takes nothing is dropped.
bool Link::transmit_frame(std::span<const std::byte> frame) {
  const std::size_t taken = flush() ? uart_.write(frame) : 0;
  if (taken == 0) {
    ++counters_.unsent_frames;
    return false;
  }
  const std::span<const std::byte> rest = frame.subspan(taken);
  std::copy(rest.begin(), rest.end(), backlog_.begin());
  backlog_size_ = rest.size();
  backlog_since_ = now_;
  counters_.sent_bytes += taken;
  ++counters_.sent_frames;
  return true;
}

bool Link::flush() {
  if (backlog_size_ == 0) return true;
  if (now_ - backlog_since_ > kStaleRest) {  // its receiver finds the next frame
    backlog_size_ = 0;
    --counters_.sent_frames;
    ++counters_.unsent_frames;
    return true;
  }
  const std::size_t taken = uart_.write(std::span(backlog_).first(backlog_size_));
  std::copy(backlog_.begin() + static_cast<std::ptrdiff_t>(taken),
            backlog_.begin() + static_cast<std::ptrdiff_t>(backlog_size_), backlog_.begin());
  backlog_size_ -= taken;
  counters_.sent_bytes += taken;
  return backlog_size_ == 0;
}

}  // namespace swiftlet::mavlink
