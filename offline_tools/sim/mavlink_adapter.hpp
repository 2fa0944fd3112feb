#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "sim/simulation.hpp"
#include "swiftlet/mavlink/codec.hpp"

namespace swiftlet::tools {

enum class OdometryFault : std::uint8_t { kNone, kStale, kNan };

/// The simulated autopilot's end of a MAVLink link, as PX4 in its onboard mode: its streams, commands, parameters and
/// time synchronisation. Bytes in, messages out.
class MavlinkAdapter {
 public:
  using Message = std::vector<std::byte>;

  /// `simulation` must outlive this object.
  explicit MavlinkAdapter(Simulation& simulation);

  void receive(std::span<const std::byte> bytes);
  /// What is due since the last call, to be called every millisecond after the simulation's step; valid until the next
  /// one.
  std::span<const Message> step();
  /// As after a boot: usual rates, no ground station heard, first sequence number.
  void reset();

  // Faults.
  void set_odometry_fault(OdometryFault fault);
  void set_clock_offset(Microseconds offset) { clock_offset_ = offset; }
  void drop_setpoints(bool on) { drops_setpoints_ = on; }

  [[nodiscard]] const mavlink::CodecCounters& counters() const { return codec_.counters(); }

 private:
  struct Stream {
    std::uint32_t id;
    Microseconds usual;     ///< interval; 0: never
    Microseconds interval;  ///< 0: never
    Microseconds next{0};
    bool fixed = false;  ///< SET_MESSAGE_INTERVAL has no effect
  };
  /// A command on its way to the commander.
  struct Command {
    Microseconds due;
    mavlink::Address from;
    std::uint16_t id;
    std::array<float, 4> param;
  };
  struct Pose {
    Microseconds time;
    Estimate estimate;
  };

  [[nodiscard]] Microseconds clock() const { return simulation_.boot_time() + clock_offset_; }
  [[nodiscard]] std::uint32_t clock_ms() const;
  [[nodiscard]] bool is_for_us(mavlink::Address target) const;
  [[nodiscard]] Pose pose() const;

  template <typename M>
  void send(const M& message);
  void send_stream(std::uint32_t id);
  void send_heartbeat();
  void send_system_status();
  void send_attitude();
  void send_local_position();
  void send_odometry();
  void send_position_target();
  void send_extended_state();
  void send_mode();
  void send_timesync();
  void send_parameter(std::size_t index);
  void send_text(const Announcement& text);

  void handle(const mavlink::Frame& frame);
  void handle_position_target(const mavlink::SetPositionTarget& message);
  void handle_attitude_target(const mavlink::SetAttitudeTarget& message);
  void handle_timesync(const mavlink::TimeSyncMessage& message);
  void handle_parameter_set(const mavlink::ParameterSet& message);
  void handle_parameter_request(const mavlink::ParameterRequest& message);
  void handle_command(const mavlink::Address& from, const mavlink::Address& target, std::uint16_t id,
                      const std::array<float, 4>& param);
  mavlink::CommandResult set_interval(float id, float interval_us);
  mavlink::CommandResult request_message(float id);
  mavlink::CommandResult carry_out(const Command& command);
  void acknowledge(const mavlink::Address& to, std::uint16_t id, mavlink::CommandResult result);

  Simulation& simulation_;
  mavlink::Codec codec_;
  std::vector<Stream> streams_;
  std::deque<Command> commands_;
  std::deque<std::size_t> asked_parameters_;
  std::vector<Message> outbox_;     ///< of this millisecond
  std::vector<Message> given_out_;  ///< by the last step
  std::optional<std::uint64_t> shown_mode_;
  bool ground_station_ = false;
  std::uint16_t text_id_ = 0;
  OdometryFault odometry_fault_ = OdometryFault::kNone;
  std::optional<Pose> frozen_pose_;
  Microseconds clock_offset_{0};
  bool drops_setpoints_ = false;
};

}  // namespace swiftlet::tools
