// Vehicle, autopilot and ground station at the other end of companion_image's line, which is standard input (a socket,
// read and written). Usage: companion_peer MAP.bt
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "lockstep.hpp"
#include "map/voxel_map.hpp"
#include "sim/pixhawk_sim.hpp"
#include "swiftlet/mavlink/codec.hpp"

namespace {

using std::chrono::milliseconds;
using swiftlet::Vector3;
using swiftlet::tools::Microseconds;
using swiftlet::tools::PixhawkSim;
using swiftlet::tools::PixhawkSimSettings;
using Bytes = std::vector<std::byte>;
namespace mavlink = swiftlet::mavlink;

constexpr Microseconds kPeriod = milliseconds(10);
constexpr Microseconds kPatience = std::chrono::seconds(120);  // of the vehicle's time
constexpr Microseconds kRest = milliseconds(500);              // at a goal, before the next
constexpr double kAtGoal = 0.15;                               // [m]
constexpr double kAtRest = 0.1;                                // [m/s]
constexpr double kVehicleRadius = 0.1;                         // [m]
constexpr std::uint16_t kCommandLand = 21;
constexpr std::uint16_t kCommandMissionStart = 300;
const std::array kGoals{Vector3{3.5, 2.5, 0.8}, Vector3{1.0, 2.6, 1.0}, Vector3{0.6, 0.6, 0.8}};  // [m] frame W

PixhawkSimSettings settings(const std::string& map) {
  PixhawkSimSettings settings;
  settings.simulation.start = {0.48, 0.48, 0};  // as the image's flight_settings() say
  settings.simulation.start_yaw = 0.4;
  settings.simulation.estimator.origin = {10, 20, 1};
  settings.simulation.estimator.heading = 2;
  settings.simulation.obstacles = swiftlet::tools::occupied_boxes(*swiftlet::tools::read_octree(map));
  settings.link_delay = milliseconds(5);
  return settings;
}

/// Who sends the goals and the words, and sees from the truth what became of them.
class GroundStation {
 public:
  explicit GroundStation(const PixhawkSim& sim) : sim_(sim) {}

  void look_at(const mavlink::Frame& frame) {
    const bool from_companion = frame.from == mavlink::Address{1, mavlink::kPathPlannerComponent};
    heard_ = heard_ || (from_companion && frame.id == mavlink::Heartbeat::kId);
  }

  /// What is to be said now.
  Bytes step() {
    said_.clear();
    const auto& simulation = sim_.simulation();
    if (!heard_) return said_;
    if (!started_) {
      started_ = true;
      say(command(kCommandMissionStart));
      say(target(kGoals.front()));
    } else if (next_ < kGoals.size() && rests_at(kGoals[next_])) {
      std::printf("%.2f at goal %zu\n", seconds(), next_ + 1);
      ++next_;
      say(next_ < kGoals.size() ? codec_.encode(target(kGoals[next_])) : codec_.encode(command(kCommandLand)));
    }
    flew_ = flew_ || simulation.truth().position.z() > kAtGoal;
    return said_;
  }

  [[nodiscard]] bool over() const { return next_ == kGoals.size() && flew_ && !sim_.simulation().autopilot().armed(); }

 private:
  [[nodiscard]] double seconds() const { return std::chrono::duration<double>(sim_.time()).count(); }

  bool rests_at(const Vector3& goal) {
    const auto& truth = sim_.simulation().truth();
    const bool rests = (truth.position - goal).norm() < kAtGoal && truth.velocity.norm() < kAtRest;
    if (!rests) rests_since_ = sim_.time();
    return sim_.time() - rests_since_ >= kRest;
  }

  static mavlink::CommandLong command(std::uint16_t id) { return {{1, mavlink::kPathPlannerComponent}, id, 0, {}}; }
  static mavlink::SetPositionTarget target(const Vector3& goal) {
    mavlink::SetPositionTarget target;
    target.target = {1, mavlink::kPathPlannerComponent};
    target.frame = mavlink::kFrameLocalFlu;
    target.type_mask =
        mavlink::kIgnoreVelocity | mavlink::kIgnoreAcceleration | mavlink::kIgnoreYaw | mavlink::kIgnoreYawRate;
    target.position.value = goal;
    return target;
  }
  template <typename Message>
  void say(const Message& message) {
    say(codec_.encode(message));
  }
  void say(std::span<const std::byte> frame) { said_.insert(said_.end(), frame.begin(), frame.end()); }

  const PixhawkSim& sim_;
  mavlink::Codec codec_{{255, 190}};
  Bytes said_;
  bool heard_ = false;
  bool started_ = false;
  bool flew_ = false;
  std::size_t next_ = 0;
  Microseconds rests_since_{0};
};

class Peer {
 public:
  explicit Peer(const std::string& map) : sim_(settings(map)), station_(sim_) {}

  /// Until the flight is over; whether it went as it should.
  bool run() {
    std::array<std::byte, 4096> buffer{};
    while (!ended_) {
      const ssize_t count = ::read(STDIN_FILENO, buffer.data(), buffer.size());
      if (count <= 0) {
        std::printf("the image fell silent\n");
        return false;
      }
      take(std::span(buffer).first(static_cast<std::size_t>(count)));
    }
    return judge();
  }

 private:
  /// A frame at a time, to the autopilot unless it is the image's step.
  void take(std::span<const std::byte> bytes) {
    while (true) {
      const std::span<const std::byte> before = bytes;
      const auto frame = codec_.receive(bytes);
      const std::size_t taken = before.size() - bytes.size();
      frame_.insert(frame_.end(), before.begin(), before.begin() + static_cast<std::ptrdiff_t>(taken));
      if (!frame) return;
      if (frame->from == swiftlet::lockstep::kImage) {
        step(*mavlink::decode<mavlink::TimeSyncMessage>(*frame));
      } else {
        station_.look_at(*frame);
        sim_.receive(frame_);
        sent_to_autopilot_ += frame_.size();
      }
      frame_.clear();
    }
  }

  void step(const mavlink::TimeSyncMessage& question) {
    ended_ = station_.over() || sim_.time() > kPatience;
    Bytes bytes = sim_.step(kPeriod);
    sent_to_companion_ += bytes.size();
    const Bytes said = station_.step();
    bytes.insert(bytes.end(), said.begin(), said.end());
    const std::int64_t now = ended_ ? swiftlet::lockstep::kTheEnd : std::chrono::nanoseconds(sim_.time()).count();
    const auto answer = codec_.encode(mavlink::TimeSyncMessage{.tc1 = now, .ts1 = question.ts1});
    bytes.insert(bytes.end(), answer.begin(), answer.end());
    send(bytes);
  }

  void send(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const ssize_t count = ::write(STDIN_FILENO, bytes.data(), bytes.size());
      if (count <= 0) return;  // the next read says why
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
  }

  [[nodiscard]] bool judge() const {
    const auto& simulation = sim_.simulation();
    const double seconds = std::chrono::duration<double>(sim_.time()).count();
    const auto rate = [&](std::size_t bytes) { return static_cast<double>(bytes) / seconds; };
    std::printf("%s after %.2f s at %.2f %.2f %.2f m\n", station_.over() ? "landed and disarmed" : "NOT LANDED",
                seconds, simulation.truth().position.x(), simulation.truth().position.y(),
                simulation.truth().position.z());
    std::printf("clearance %.3f m, touch-down %.2f m/s, %u bytes skipped\n", simulation.clearance(),
                simulation.quadrotor().impact_speed(), codec_.counters().skipped_bytes);
    std::printf("%.0f bytes to the companion and %.0f back in a second of flight\n", rate(sent_to_companion_),
                rate(sent_to_autopilot_));
    return station_.over() && simulation.clearance() > kVehicleRadius && codec_.counters().skipped_bytes == 0;
  }

  PixhawkSim sim_;
  GroundStation station_;
  mavlink::Codec codec_{swiftlet::lockstep::kPeer};
  Bytes frame_;
  std::size_t sent_to_companion_ = 0;
  std::size_t sent_to_autopilot_ = 0;
  bool ended_ = false;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  return Peer(argv[1]).run() ? 0 : 1;
}
