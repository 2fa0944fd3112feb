#pragma once
#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "swiftlet/hal/uart.hpp"
#include "swiftlet/mavlink/codec.hpp"
#include "swiftlet/mavlink/modes.hpp"
#include "swiftlet/mavlink/ring.hpp"
#include "swiftlet/mavlink/time_sync.hpp"

/// The companion's end of the link to an autopilot (PX4 or ArduPilot), as MAVLink component 195. docs/link.md tells the
/// messages, rates and rules. No heap; time is an argument; everything that enters or leaves here is in our frames.
namespace swiftlet::mavlink {

/// A parameter of ours that ground stations may read, and set where `settable`.
struct Parameter {
  std::string_view name;  ///< At most 16 characters.
  float value = 0;
  float lowest = 0;  ///< Values outside [lowest, highest] are refused.
  float highest = 0;
  bool settable = false;
};

/// How often the autopilot is to send a message; 0 Hz: not at all.
struct MessageRate {
  std::uint32_t id;
  float hz;
};

/// What tracking at 50 to 100 Hz needs, and silence from PX4's loudest default streams: docs/link.md.
std::span<const MessageRate> default_rates();

struct LinkConfig {
  std::uint8_t system_id = 1;  ///< Of the vehicle: the autopilot's and ours.
  std::span<const MessageRate> rates = default_rates();
  std::span<Parameter> parameters;
  /// When given, our frames are signed, and commands, goals and new parameter values must be.
  std::optional<Signing> signing;
  /// With `signing`: the autopilot's own messages must be signed too. PX4 v1.16 cannot, ArduPilot can.
  bool autopilot_signs = false;
};

/// What the autopilot said last. Times are of our clock; judge every value by its age.
struct AutopilotState {
  bool heard = false;
  std::chrono::microseconds heard_at{0};  ///< HEARTBEAT
  AutopilotKind kind = AutopilotKind::kUnknown;
  SystemState system_state = SystemState::kUninitialised;
  bool armed = false;
  Mode mode = Mode::kUnknown;           ///< From HEARTBEAT or CURRENT_MODE, whichever came last.
  Mode intended_mode = Mode::kUnknown;  ///< CURRENT_MODE; differs from `mode` in a failsafe.
  std::uint32_t custom_mode = 0;
  std::chrono::microseconds mode_at{0};
  /// SYS_STATUS. About the current mode: in OFFBOARD false until set-points stream, so do not wait for it.
  bool prearm_ok = false;
  std::uint16_t battery_mv = 0xFFFF;
  LandedState landed_state = LandedState::kUnknown;  ///< PX4 says "in air" a second before lift-off.
  std::uint32_t restarts = 0;                        ///< Times that its clock went back.
};

/// The autopilot's estimate in one frame. `sampled_at` is its own time stamp on our clock, once TIMESYNC has met.
struct VehicleState {
  bool has_position = false;
  std::chrono::microseconds position_received_at{0};
  std::chrono::microseconds position_sampled_at{0};
  std::uint32_t position_count = 0;    ///< Estimates taken so far.
  Vector3 position = Vector3::Zero();  ///< [m]
  Vector3 velocity = Vector3::Zero();  ///< [m/s]
  std::uint8_t reset_counter = 0;      ///< ODOMETRY: jumps of the estimate.
  std::uint32_t refused_count = 0;     ///< Estimates with numbers that are not finite, no rotation or no time.

  bool has_attitude = false;
  std::chrono::microseconds attitude_received_at{0};
  std::chrono::microseconds attitude_sampled_at{0};
  std::uint32_t attitude_count = 0;
  Quaternion attitude = Quaternion::Identity();  ///< of B
  Vector3 body_rates = Vector3::Zero();          ///< [rad/s] in B
};

/// Position, velocity, acceleration in W [m] [m/s] [m/s^2], yaw [rad] and its rate [rad/s].
struct PositionSetpoint {
  Vector3 position = Vector3::Zero();
  Vector3 velocity = Vector3::Zero();
  Vector3 acceleration = Vector3::Zero();
  Real yaw = 0;
  Real yaw_rate = 0;
};

/// Attitude of B in W. Thrust as a share of the full collective thrust, 0 to 1.
struct AttitudeSetpoint {
  Quaternion attitude = Quaternion::Identity();
  Real thrust = 0;
};

/// Body rates in B [rad/s]; thrust as above.
struct RateSetpoint {
  Vector3 body_rates = Vector3::Zero();
  Real thrust = 0;
};

/// A place to fly to, in W.
struct Goal {
  Vector3 position = Vector3::Zero();  ///< [m]
  std::optional<Real> yaw{};           ///< [rad]
  bool local = false;                  ///< it was given in the autopilot's frame: wrong unless the frames are aligned
  Address from{};
};

/// A command that someone sent to us; answer it with `Link::answer`.
struct ReceivedCommand {
  Address from{};
  bool is_int = false;  ///< COMMAND_INT: `x`, `y` and `frame` hold, and param[4] and [5] do not.
  std::uint16_t command = 0;
  std::array<float, 7> param{};
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::uint8_t frame = 0;
};

/// How a request of ours to the autopilot ended.
struct Outcome {
  enum class Kind : std::uint8_t {
    kDone,      ///< Acknowledged; a change of mode: seen in force.
    kRejected,  ///< `result` tells how.
    kNoAnswer,  ///< No acknowledgement after all repetitions, or no sight of the mode in time.
  };
  Kind kind = Kind::kNoAnswer;
  std::uint16_t command = 0;
  std::array<float, 7> param{};
  CommandResult result = CommandResult::kAccepted;
};

/// What the autopilot says of a parameter of its own; no value when it does not answer, or not with a finite REAL32.
struct ParameterAnswer {
  ParameterName name{};
  std::optional<float> value{};
};

/// A text for people; longer ones are cut.
struct Text {
  Address from{};
  Severity severity = Severity::kInfo;
  std::array<char, 200> text{};
};

struct LinkCounters {
  std::uint64_t received_bytes = 0;
  std::uint64_t sent_bytes = 0;
  std::uint32_t sent_frames = 0;
  /// Found the device full, or waited there half taken; dropped, since a late set-point is worse than none.
  std::uint32_t unsent_frames = 0;
  std::uint32_t lost_frames = 0;     ///< Gaps in the autopilot's numbering.
  std::uint32_t foreign = 0;         ///< Of others, or for others.
  std::uint32_t unused = 0;          ///< Of the autopilot, of a kind that we do not use.
  std::uint32_t refused_values = 0;  ///< Not finite, no rotation, no time, or in a frame that we do not know.
  std::uint32_t refused_setpoints = 0;
  std::uint32_t unauthorised = 0;    ///< Unsigned, where a signature is asked for.
  std::uint32_t dropped_events = 0;  ///< Texts, commands, outcomes or parameters that nobody fetched in time.
  std::uint32_t refused_rates = 0;   ///< SET_MESSAGE_INTERVAL that the autopilot did not accept.
  std::uint32_t stray_acknowledgements = 0;
};

class Link {
 public:
  Link(hal::Uart& uart, const LinkConfig& config);

  /// Takes what was received, answers it, repeats what was not acknowledged, and sends what is due. Call it at least as
  /// often as set-points are sent; reads at most 4096 bytes. `now` never goes back but by a jump that was announced.
  void step(std::chrono::microseconds now);
  /// The caller's clock jumps by `jump` before the next step: what is due stays due, stamps stay what they were.
  void shift_clock(std::chrono::microseconds jump);

  // What is known.
  [[nodiscard]] const AutopilotState& autopilot() const { return autopilot_; }
  [[nodiscard]] VehicleState vehicle() const;                                 ///< In the map's frame W.
  [[nodiscard]] const VehicleState& local_vehicle() const { return local_; }  ///< In L: the autopilot's frame as ENU.
  [[nodiscard]] const TimeSync& time_sync() const { return time_sync_; }
  [[nodiscard]] const LinkCounters& counters() const { return counters_; }
  [[nodiscard]] const CodecCounters& codec_counters() const { return codec_.counters(); }
  [[nodiscard]] std::uint64_t signing_time() const { return codec_.signing_time(); }  ///< To be kept in storage.

  // Alignment: done once, at arming, when the estimate stops to drift.
  /// The vehicle now stands at `position` with `yaw` in W. False, and nothing changed, without an estimate.
  bool align(const Vector3& position, Real yaw);
  /// The same from a pose that the application has averaged.
  void align(const Alignment& alignment);
  [[nodiscard]] const Alignment& alignment() const { return alignment_; }
  [[nodiscard]] bool aligned() const { return aligned_; }

  // Requests to the autopilot, carried out one after the other. False when it has no such mode or the queue is full.
  bool request_mode(Mode mode);
  bool request_arm(bool armed);
  bool request(std::uint16_t command, const std::array<float, 7>& param);
  void cancel_requests();  ///< Those that are not done are not repeated and have no outcome.
  std::optional<Outcome> take_outcome() { return outcomes_.pop_front(); }

  // Parameters of the autopilot, asked for one after the other and up to four times each. False when the name has more
  // than 16 characters or the queue is full.
  bool request_parameter(std::string_view name);
  std::optional<ParameterAnswer> take_parameter() { return parameter_answers_.pop_front(); }

  // Set-points, sent at once and once. False when not sent: not finite, thrust outside 0 to 1, no rotation, device
  // full.
  bool send(const PositionSetpoint& setpoint);
  bool send(const AttitudeSetpoint& setpoint);
  bool send(const RateSetpoint& setpoint);

  // From and for people.
  std::optional<Goal> take_goal();  ///< The latest that was not fetched.
  std::optional<ReceivedCommand> take_command() { return commands_.pop_front(); }
  void answer(const ReceivedCommand& command, CommandResult result);
  std::optional<Text> take_text() { return texts_.pop_front(); }
  bool send_text(Severity severity, std::string_view text);
  void set_state(SystemState state) { own_state_ = state; }  ///< In our HEARTBEAT.
  /// Grows when somebody has set one of `LinkConfig::parameters`.
  [[nodiscard]] std::uint32_t parameter_changes() const { return parameter_changes_; }

 private:
  struct Request {
    CommandLong command{};
    Mode awaited_mode = Mode::kUnknown;  // not kUnknown: to be seen in force
    bool is_rate = false;                // of ours, not the application's
    bool acknowledged = false;
    std::uint8_t transmissions = 0;
    std::chrono::microseconds next_at{0};
  };
  struct ParameterQuestion {
    ParameterName name{};
    std::uint8_t transmissions = 0;
    std::chrono::microseconds next_at{0};
  };
  enum class Stamp : std::uint8_t { kPosition, kAttitude, kOdometry };  // whose time it is

  void receive();
  void dispatch(const Frame& frame);
  bool is_authorised(const Frame& frame);
  void count_losses(std::uint8_t sequence);

  // Of the autopilot.
  bool take_autopilot(const Frame& frame);
  void take(const Heartbeat& heartbeat);
  void take(const CurrentMode& mode);
  void take(const SystemStatus& status);
  void take(const ExtendedSystemState& state);
  void take(const LocalPositionNed& position);
  void take(const AttitudeQuaternion& attitude);
  void take(const Odometry& odometry);
  void take(const CommandAck& ack);
  void take(const ParameterValue& parameter);
  void take(const TimeSyncMessage& message);
  void set_mode(Mode mode, std::uint32_t custom_mode);
  void set_position(const Vector3& position, const Vector3& velocity, std::chrono::microseconds sampled_at);
  void set_attitude(const Quaternion& attitude, const Vector3& body_rates, std::chrono::microseconds sampled_at);
  std::chrono::microseconds sampled_at(std::chrono::microseconds boot_time, Stamp stamp);

  // Of anybody, for us.
  bool take_for_us(const Frame& frame);
  void take(const CommandLong& command, const Frame& frame);
  void take(const CommandInt& command, const Frame& frame);
  void take(const ReceivedCommand& command, bool may_be_repetition, const Frame& frame);
  void take(const SetPositionTarget& target, const Frame& frame);
  void take(const ParameterRequest& request, const Frame& frame);
  void take(const ParameterSet& set, const Frame& frame);
  void take(const StatusText& text, const Frame& frame);
  void finish_text();

  // To the autopilot.
  void send_due();
  void advance_request();
  void finish_request(Outcome::Kind kind, CommandResult result);
  void queue_rate();
  void ask_for_parameter();
  void answer_parameter(std::optional<float> value);
  void send_parameter(std::size_t index);
  void acknowledge(const ReceivedCommand& command, CommandResult result);
  std::size_t find_parameter(std::string_view name) const;
  bool send_target(SetAttitudeTarget target, Real thrust);

  template <typename Message>
  bool transmit(const Message& message) {
    return transmit_frame(codec_.encode(message));
  }
  bool transmit_frame(std::span<const std::byte> frame);
  bool flush();

  hal::Uart& uart_;
  Codec codec_;
  Address autopilot_address_{};
  std::span<const MessageRate> rates_;
  std::span<Parameter> parameters_;
  bool autopilot_signs_;
  std::uint64_t signing_start_ = 0;
  bool started_ = false;
  std::chrono::microseconds start_{0};
  std::chrono::microseconds now_{0};

  AutopilotState autopilot_;
  VehicleState local_;
  TimeSync time_sync_;
  Alignment alignment_;
  bool aligned_ = false;
  LinkCounters counters_;
  SystemState own_state_ = SystemState::kBoot;
  std::uint32_t parameter_changes_ = 0;

  std::optional<std::uint8_t> next_sequence_;
  std::array<std::chrono::microseconds, 3> latest_boot_times_{};  // by Stamp
  std::chrono::microseconds next_heartbeat_{0};
  std::chrono::microseconds next_time_sync_{0};
  std::array<std::int64_t, 5> time_sync_asked_{};  // ts1 of requests of the last second; 0: none, or answered
  std::size_t next_rate_ = 0;
  std::size_t next_parameter_ = 0;  // of a list that was asked for; parameters_.size() when none is due
  std::uint16_t text_id_ = 0;

  Ring<Request, 8> requests_;
  Ring<Outcome, 8> outcomes_;
  Ring<ParameterQuestion, 4> parameter_questions_;
  Ring<ParameterAnswer, 4> parameter_answers_;
  Ring<ReceivedCommand, 4> commands_;
  Ring<Text, 4> texts_;
  std::optional<Goal> goal_;

  struct LatestCommand {
    ReceivedCommand command{};
    std::chrono::microseconds at{0};
    std::optional<CommandResult> result{};
  };
  std::optional<LatestCommand> latest_command_;

  struct PartialText {
    Text text;
    std::uint16_t id = 0;  // 0: none
    std::uint8_t next_chunk = 0;
    std::size_t size = 0;
  };
  PartialText partial_text_;

  std::array<std::byte, kMaxFrame> backlog_{};  // the rest of a frame whose beginning the device took
  std::size_t backlog_size_ = 0;
  std::chrono::microseconds backlog_since_{0};
};

}  // namespace swiftlet::mavlink
