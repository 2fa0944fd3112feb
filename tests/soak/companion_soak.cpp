// companion_soak [SECONDS]: the companion in lock-step, goal after goal at speed in wind, over a line that loses,
// corrupts and holds back bytes every few seconds. Built with sanitizers by `./go soak companion`. Fails when something
// that was sent or received gets lost on our side, when nothing moves any more, or when memory grows.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <memory>
#include <vector>

#include "companion/companion.hpp"
#include "map/map_builder.hpp"
#include "map/voxel_map.hpp"
#include "sim/lockstep_uart.hpp"
#include "world/random.hpp"
#include "world/worlds.hpp"

// NOLINTNEXTLINE(readability-identifier-naming,bugprone-reserved-identifier): AddressSanitizer asks for it by this name
extern "C" const char* __asan_default_options() {
  return "quarantine_size_mb=1:thread_local_quarantine_size_kb=64";  // freed memory is kept back: not to look like
                                                                     // growth
}

namespace swiftlet::tools {
namespace {

using std::chrono::milliseconds;

constexpr Capacity kCapacity{.segments = 256, .search_nodes = 65'536};
constexpr double kGround = -0.4;             // [m]
constexpr double kMapRadius = 0.3;           // [m]
constexpr double kPatience = 120;            // [s] after which the operator engages anew
constexpr double kLongestWithoutGoal = 600;  // [s] of the flight
constexpr double kGrowth = 1'048'576;        // [bytes]
constexpr std::uint64_t kSeed = 7;

enum class Trouble : std::uint8_t { kNone, kLoss, kCorruption, kHoldUp, kCount };

/// The line between companion and autopilot, with its troubles, which watches that nothing gets lost before or behind
/// it.
class RoughLine final : public hal::Uart {
 public:
  explicit RoughLine(PixhawkSim& sim) : line_(sim) {}

  void advance(std::chrono::microseconds duration) { line_.advance(duration); }
  void set(Trouble trouble) { trouble_ = trouble; }

  std::size_t write(std::span<const std::byte> bytes) override {
    std::span<const std::byte> rest = bytes;
    while (const auto frame = sent_.receive(rest)) {
      if (sent_.counters().frames > 1) missing_ += static_cast<std::uint8_t>(frame->sequence - next_);
      next_ = static_cast<std::uint8_t>(frame->sequence + 1);
    }
    if (trouble_ == Trouble::kLoss && random_.below(10) < 3) return bytes.size();
    std::vector<std::byte> copy(bytes.begin(), bytes.end());
    corrupt(copy);
    return line_.write(copy);
  }
  std::size_t read(std::span<std::byte> into) override {
    if (trouble_ == Trouble::kHoldUp) return 0;
    std::size_t count = line_.read(into);
    while (count > 0 && trouble_ == Trouble::kLoss && random_.below(10) < 3) count = line_.read(into);
    corrupt(into.first(count));
    given_bytes_ += count;
    std::span<const std::byte> rest = into.first(count);
    while (given_.receive(rest)) continue;
    return count;
  }
  [[nodiscard]] std::uint32_t overruns() const override { return 0; }

  [[nodiscard]] std::uint32_t sent_frames() const { return sent_.counters().frames; }
  [[nodiscard]] std::uint32_t missing_frames() const { return missing_; }  ///< gaps in what the companion sent
  [[nodiscard]] std::uint32_t given_frames() const { return given_.counters().frames; }
  [[nodiscard]] std::uint64_t given_bytes() const { return given_bytes_; }

 private:
  void corrupt(std::span<std::byte> bytes) {
    if (trouble_ != Trouble::kCorruption) return;
    for (std::byte& byte : bytes) {
      if (random_.below(100) == 0) byte ^= static_cast<std::byte>(1 + random_.below(255));
    }
  }

  LockstepUart line_;
  SplitMix64 random_{kSeed};
  Trouble trouble_ = Trouble::kNone;
  mavlink::Codec sent_{{1, 1}};
  mavlink::Codec given_{{1, 195}};
  std::uint8_t next_ = 0;
  std::uint32_t missing_ = 0;
  std::uint64_t given_bytes_ = 0;
};

/// A storage that is never full.
class CountingStorage final : public hal::Storage {
 public:
  std::optional<std::size_t> read(std::string_view /*name*/, std::size_t, std::span<std::byte>) override {
    return std::nullopt;
  }
  bool append(std::string_view /*name*/, std::span<const std::byte> bytes) override {
    bytes_ += bytes.size();
    return true;
  }
  bool remove(std::string_view /*name*/) override { return true; }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  std::uint64_t bytes_ = 0;
};

double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  double pages = 0;
  double resident = 0;
  file >> pages >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

struct Place {
  std::vector<std::byte> blob;
  BoxGraphView map;
  Vector3 start;  // on the ground, which lies below all that is free: nothing touches it in flight
};

Place make_place() {
  const World world = make_maze(1);
  const std::string bt = to_bt(world.grid);
  MapBuildOptions options;
  options.radius = kMapRadius;
  Place place;
  place.blob = build_map(*parse_octree("maze.bt", std::as_bytes(std::span(bt))), "maze.bt", options,
                         [](std::string_view, double) {})
                   ->blob;
  place.map = *BoxGraphView::open(place.blob);
  const std::array<double, 3> centre = world.grid.centre(world.main_start);
  place.start = {centre[0], centre[1], kGround};
  return place;
}

companion::Settings make_settings(const Place& place) {
  companion::Settings settings;
  settings.start = place.start;
  settings.engage_at_start = true;
  settings.takeoff.height = 1;
  settings.limits.v_max = 1.5;
  settings.limits.a_max = 2;
  settings.margins.map_error = 0;
  settings.margins.vehicle_radius = 0.149;
  return settings;
}

PixhawkSimSettings make_sim(const Place& place) {
  PixhawkSimSettings sim;
  sim.simulation.start = place.start;
  sim.simulation.seed = kSeed;
  sim.simulation.wind.mean = {1, 0.5, 0};
  sim.simulation.wind.gust = 2;
  sim.simulation.estimator.origin = {10, 20, 1};
  sim.simulation.estimator.heading = 2;
  sim.link_delay = milliseconds(5);
  return sim;
}

class Soak {
 public:
  explicit Soak(const Place& place)
      : place_(place),
        sim_(make_sim(place)),
        line_(sim_),
        companion_(make_settings(place), place.map, memory_->memory(), {line_, worker_, begin_log()}) {
    sim_.simulation().set_ground(kGround);
  }

  void step() {
    give_words();
    make_trouble();
    line_.advance(milliseconds(10));
    companion_.step(sim_.time());
    ++steps_;
    const companion::Telemetry& t = companion_.telemetry();
    const bool counts = t.phase == companion::Phase::kMission && is_usable(t.estimate);
    worst_error_ = std::max(worst_error_, counts ? t.tracking_error : Real(0));
    if (t.goals_reached != reached_) last_goal_ = seconds();
    reached_ = t.goals_reached;
  }

  /// What is wrong; nullptr when nothing is.
  [[nodiscard]] const char* find_fault() const {
    const companion::Telemetry& t = companion_.telemetry();
    if (t.link.unsent_frames != 0) return "frames were not sent";
    if (line_.missing_frames() != 0) return "the frames that were sent are not numbered in a row";
    if (t.link.received_bytes != line_.given_bytes()) return "received bytes were lost";
    if (t.codec.frames != line_.given_frames()) return "received frames were lost";
    if (t.link.dropped_events != 0) return "received texts, commands or outcomes were lost";
    if (log_->full()) return "the log is full";
    if (seconds() - last_goal_ > kLongestWithoutGoal) return "no goal was reached for ten minutes";
    return nullptr;
  }

  void print() const {
    const companion::Telemetry& t = companion_.telemetry();
    std::printf("%.0f s flown: %u goals, %u plans, %u troubles of the line, %u engaged anew; error %.3f m at most\n",
                seconds(), reached_, t.plan.id, troubles_, engaged_, static_cast<double>(worst_error_));
    std::printf("  %u frames sent, %u received, %u bad checksums, %u lost by the line; %.1f MB logged\n",
                line_.sent_frames(), t.codec.frames, t.codec.bad_checksum, t.link.lost_frames,
                static_cast<double>(storage_.bytes()) / 1e6);
  }
  [[nodiscard]] double seconds() const { return static_cast<double>(steps_) / 100; }

 private:
  companion::FlightLog* begin_log() {
    (void)log_->begin("soak.ulg", 0, {"soak", "soak", "{}", place_.map.header().crc32});
    return log_.get();
  }

  [[nodiscard]] Vector3 random_point() {
    const BlobHeader& header = place_.map.header();
    Vector3 point = Vector3::Zero();
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double share = static_cast<double>(random_.below(10'000)) / 10'000;
      point[k] = header.origin[static_cast<std::size_t>(k)] + share * kSide;
    }
    return point;
  }

  void give_words() {
    const companion::Telemetry& t = companion_.telemetry();
    if (t.goals_waiting == 0 && t.phase == companion::Phase::kMission && steps_ % 10 == 0) {
      (void)companion_.add_goal(random_point());
    }
    // A damaged position that passes its checksum, one in 65,536, is a jump: only the operator's word ends that hold.
    const bool waits = seconds() - last_goal_ > kPatience || t.state == FlightState::kYielded;
    if (waits && steps_ % 500 == 0) {
      (void)companion_.engage(true);
      ++engaged_;
    }
    if (steps_ % 1500 == 1000) {
      const Vector3 corner = random_point();
      (void)companion_.block(1, {corner, corner + Vector3(0.5, 0.5, 0.5)});
    }
    if (steps_ % 1500 == 1400) (void)companion_.unblock(1);
  }

  /// Half a second of some trouble, of a second of loss or corruption, every five seconds.
  void make_trouble() {
    const std::uint64_t phase = steps_ % 500;
    if (phase == 300) {
      trouble_ = static_cast<Trouble>(1 + random_.below(static_cast<std::size_t>(Trouble::kCount) - 1));
      line_.set(trouble_);
      ++troubles_;
    }
    if (phase == (trouble_ == Trouble::kHoldUp ? 340U : 400U)) line_.set(Trouble::kNone);
  }

  static constexpr double kSide = 10.24;  // [m] of the maze

  const Place& place_;
  std::unique_ptr<PlannerStorage<kCapacity>> planner_memory_ = std::make_unique<PlannerStorage<kCapacity>>();
  std::unique_ptr<companion::CompanionStorage<kCapacity>> memory_ =
      std::make_unique<companion::CompanionStorage<kCapacity>>();
  CountingStorage storage_;
  std::unique_ptr<companion::FlightLog> log_ = std::make_unique<companion::FlightLog>(storage_);
  PixhawkSim sim_;
  RoughLine line_;
  companion::InlineWorker worker_{planner_memory_->spans()};
  companion::Companion companion_;
  SplitMix64 random_{kSeed};
  Trouble trouble_ = Trouble::kNone;
  std::uint64_t steps_ = 0;
  std::uint32_t reached_ = 0;
  std::uint32_t troubles_ = 0;
  std::uint32_t engaged_ = 0;
  double last_goal_ = 0;
  Real worst_error_ = 0;
};

int run(double duration) {
  using Clock = std::chrono::steady_clock;
  const Place place = make_place();
  const auto soak = std::make_unique<Soak>(place);
  const Clock::time_point begin = Clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  double next_report = 60;
  while (elapsed() < duration) {
    for (int i = 0; i < 1000; ++i) soak->step();
    if (const char* fault = soak->find_fault()) {
      soak->print();
      std::printf("FAILED: %s\n", fault);
      return 1;
    }
    if (elapsed() < duration / 4) continue;  // warming up
    least = std::min(least, resident_bytes());
    most = std::max(most, resident_bytes());
    if (elapsed() < next_report) continue;
    next_report += 60;
    soak->print();
    std::fflush(stdout);
  }
  soak->print();
  std::printf("  resident memory %.2f to %.2f MB after warm-up\n", least / 1e6, most / 1e6);
  if (most - least <= kGrowth) return 0;
  std::printf("FAILED: memory grows\n");
  return 1;
}

}  // namespace
}  // namespace swiftlet::tools

int main(int argc, char** argv) { return swiftlet::tools::run(argc > 1 ? std::atof(argv[1]) : 60); }
