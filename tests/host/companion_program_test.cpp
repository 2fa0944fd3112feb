// The program `companion` on a real device: a pseudo-terminal with the simulated autopilot at its other end, in real
// time, and what it refuses.
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "board_config.hpp"
#include "cli/config_file.hpp"
#include "cli/failure.hpp"
#include "flight/memory_storage.hpp"
#include "flight/replay.hpp"
#include "linux/flight_loop.hpp"
#include "linux/port.hpp"
#include "linux/signing_time.hpp"
#include "linux/thread_storage.hpp"
#include "linux/thread_worker.hpp"
#include "map/file_io.hpp"
#include "map/map_builder.hpp"
#include "map/voxel_map.hpp"
#include "sim/pixhawk_sim.hpp"
#include "swiftlet/hal/posix_uart.hpp"
#include "world/worlds.hpp"

namespace swiftlet::tools {
namespace {

using Clock = std::chrono::steady_clock;

std::string write_file(const std::string& name, std::string_view bytes) {
  std::string path = testing::TempDir() + "companion_" + std::to_string(::getpid()) + "_" + name;
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

std::string map_path(double radius, const std::string& name = "room.swm") {
  const std::string bt = to_bt(make_classroom(1).grid);
  MapBuildOptions options;
  options.radius = radius;
  const std::vector<std::byte> blob = build_map(*parse_octree("room.bt", std::as_bytes(std::span(bt))), "room.bt",
                                                options, [](std::string_view, double) {})
                                          ->blob;
  return write_file(name, {reinterpret_cast<const char*>(blob.data()), blob.size()});
}

const char* const kConfig = R"({"format": "swiftlet-config/1", "start_m": [0.48, 0.48, 0], "land_at_end": true,
  "margins": {"vehicle_radius_m": 0.1, "map_error_m": 0.03}, "takeoff": {"height_m": 0.8, "standing_s": 0.5}})";

/// A child process with its standard input and its output.
class Program {
 public:
  explicit Program(std::vector<std::string> arguments) {
    std::array<int, 2> in{};
    std::array<int, 2> out{};
    if (::pipe(in.data()) != 0 || ::pipe(out.data()) != 0) return;
    process_ = ::fork();
    if (process_ == 0) {
      ::dup2(in[0], 0);
      ::dup2(out[1], 1);
      ::dup2(out[1], 2);
      for (const int each : {in[0], in[1], out[0], out[1]}) ::close(each);
      arguments.insert(arguments.begin(), COMPANION_PROGRAM);
      std::vector<char*> pointers;
      pointers.reserve(arguments.size() + 1);
      for (std::string& argument : arguments) pointers.push_back(argument.data());
      pointers.push_back(nullptr);
      ::execv(pointers[0], pointers.data());
      ::_exit(127);
    }
    ::close(in[0]);
    ::close(out[1]);
    input_ = in[1];
    output_ = out[0];
  }
  ~Program() {
    if (process_ > 0) ::kill(process_, SIGKILL);
    (void)wait();
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void say(const std::string& line) const {
    ASSERT_EQ(::write(input_, line.data(), line.size()), static_cast<ssize_t>(line.size()));
  }
  /// Ends its input, reads what it says until it ends; its exit status.
  int wait() {
    if (process_ <= 0) return -1;
    ::close(input_);
    std::array<char, 4096> buffer{};
    for (ssize_t n = ::read(output_, buffer.data(), buffer.size()); n > 0;
         n = ::read(output_, buffer.data(), buffer.size())) {
      text.append(buffer.data(), static_cast<std::size_t>(n));
    }
    ::close(output_);
    int status = 0;
    ::waitpid(process_, &status, 0);
    process_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string text;

 private:
  pid_t process_ = -1;
  int input_ = -1;
  int output_ = -1;
};

/// The simulated autopilot at the other end, a millisecond at a time by the wall clock; notes when set-points come.
struct FarEnd {
  PixhawkSim sim;
  hal::PseudoTerminal line;
  mavlink::Codec reader{{1, 99}};
  Clock::time_point last_setpoint{};
  std::vector<double> gaps;  // [ms] between set-points in flight
  std::uint64_t received_bytes = 0;
  std::uint64_t sent_bytes = 0;

  explicit FarEnd(const PixhawkSimSettings& settings) : sim(settings) {}

  template <typename Condition>
  bool run_until(double seconds, const Condition& condition) {
    const Clock::time_point start = Clock::now() - sim.time();
    const auto end = sim.time() + std::chrono::duration<double>(seconds);
    std::array<std::byte, 4096> buffer{};
    while (sim.time() < end) {
      std::this_thread::sleep_until(start + sim.time() + Simulation::kStep);
      for (std::size_t n = line.read(buffer); n > 0; n = line.read(buffer)) {
        sim.receive(std::span(buffer).first(n));
        watch(std::span(buffer).first(n));
      }
      const std::vector<std::byte> bytes = sim.step();
      sent_bytes += bytes.size();
      (void)line.write(bytes);
      if (condition()) return true;
    }
    return false;
  }

 private:
  void watch(std::span<const std::byte> bytes) {
    received_bytes += bytes.size();
    while (const auto frame = reader.receive(bytes)) {
      if (frame->id != mavlink::SetAttitudeTarget::kId) continue;
      const Clock::time_point now = Clock::now();
      const std::chrono::duration<double, std::milli> gap = now - last_setpoint;
      if (gap.count() < 1000) gaps.push_back(gap.count());
      last_setpoint = now;
    }
  }
};

/// Share-quantile of how far the gaps are from 10 ms.
double jitter(const std::vector<double>& gaps, double share) {
  std::vector<double> off;
  off.reserve(gaps.size());
  for (const double gap : gaps) off.push_back(std::abs(gap - 10));
  std::sort(off.begin(), off.end());
  return off.empty() ? 0 : off[static_cast<std::size_t>(share * static_cast<double>(off.size() - 1))];
}

/// What the program logged and what a companion does that is given the same, in the maps that the log names.
void expect_replays_equal(const std::string& log_path, const std::vector<std::string>& maps) {
  static PlannerStorage<kBoard> planner;
  static companion::CompanionStorage<kBoard> memory;
  const auto log = read_ulog(log_path);
  ASSERT_TRUE(log) << log.error().message;
  EXPECT_FALSE(log->truncated);
  const auto named = named_maps(*log);
  ASSERT_TRUE(named) << named.error().message;
  std::list<std::vector<std::byte>> blobs;
  std::vector<BoxGraphView> views;
  for (std::size_t i = 0; i < named->size(); ++i) {
    EXPECT_EQ((*named)[i].file, maps.at(i));
    blobs.push_back(*read_file((*named)[i].file));
    views.push_back(*BoxGraphView::open(blobs.back()));
    EXPECT_EQ((*named)[i].crc32, views.back().header().crc32);
  }
  ASSERT_EQ(views.size(), maps.size());
  const auto report = replay(
      *log, {views, parse_config("the log's", log->texts.at("swiftlet_settings")), memory.memory(), planner.spans()});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_FALSE(report->difference) << report->difference->time << ": " << report->difference->what;
  EXPECT_GT(report->steps, 1000U);
  EXPECT_GE(report->plans, 1U);
  std::printf("log: %zu bytes, %zu steps, %zu plans, %zu messages\n", log->bytes.size(), report->steps, report->plans,
              report->messages);
}

TEST(CompanionProgram, FliesOverAPseudoTerminalInRealTime) {
  PixhawkSimSettings settings;
  settings.simulation.start = {0.48, 0.48, 0};
  FarEnd far_end(settings);
  ASSERT_TRUE(far_end.line.open());
  const std::string map = map_path(0.3);
  const std::string logs = testing::TempDir() + "companion_" + std::to_string(::getpid()) + "_logs";
  std::filesystem::create_directory(logs);
  for (const char* other : {"/flight_0041.ulg", "/flight_.ulg", "/notes.txt"}) std::ofstream(logs + other) << "kept";
  const std::string other = map_path(0.29, "other.swm");
  Program program({"--map", std::filesystem::relative(map), "--port", far_end.line.peer_path() + ":921600", "--config",
                   write_file("config.json", kConfig), "--log", logs});
  program.say("map " + other + "\nengage\ngoal 2 2.6 1\n");
  const auto& autopilot = far_end.sim.simulation().autopilot();
  const auto& truth = far_end.sim.simulation().truth();
  ASSERT_TRUE(far_end.run_until(15, [&] { return autopilot.armed(); }));
  const auto goal = Vector3{2, 2.6, 1};
  ASSERT_TRUE(far_end.run_until(30, [&] { return (truth.position - goal).norm() < 0.2; }));
  EXPECT_TRUE(far_end.run_until(30, [&] { return !autopilot.armed(); }));
  EXPECT_LT((truth.position - goal).head<2>().norm(), 0.4);
  EXPECT_LT(far_end.sim.simulation().quadrotor().impact_speed(), 0.6);
  far_end.run_until(1.5, [] { return false; });  // a HEARTBEAT may be late
  program.say("status\nquit\n");
  EXPECT_EQ(program.wait(), 0);
  EXPECT_NE(program.text.find("goal 2.00 2.60 1.00 reached"), std::string::npos) << program.text;
  EXPECT_NE(program.text.find("landed: disarmed"), std::string::npos) << program.text;
  const double seconds = std::chrono::duration<double>(far_end.sim.time()).count();
  std::printf("set-points: %zu, off 10 ms by %.2f ms (50 %%), %.2f ms (99 %%), %.2f ms at most\n", far_end.gaps.size(),
              jitter(far_end.gaps, 0.5), jitter(far_end.gaps, 0.99), jitter(far_end.gaps, 1));
  std::printf("line: %.0f B/s to the companion, %.0f B/s from it\n%s",
              static_cast<double>(far_end.sent_bytes) / seconds, static_cast<double>(far_end.received_bytes) / seconds,
              program.text.c_str());
  const std::string here = std::filesystem::current_path().string() + "/";
  expect_replays_equal(logs + "/flight_0042.ulg", {here + std::filesystem::relative(map).string(), other});
  EXPECT_EQ(std::filesystem::file_size(logs + "/flight_0041.ulg"), 4U);
  std::filesystem::remove_all(logs);
}

TEST(CompanionProgram, SaysWhatHappensWhileItEnds) {
  PixhawkSimSettings settings;
  settings.simulation.start = {0.48, 0.48, 0};
  FarEnd far_end(settings);
  ASSERT_TRUE(far_end.line.open());
  std::string config = kConfig;
  config.replace(config.find("0.5"), 3, "9");  // it stands and stays on the ground
  Program program(
      {"--map", map_path(0.3), "--port", far_end.line.peer_path(), "--config", write_file("standing.json", config)});
  program.say("engage\n");
  ASSERT_TRUE(far_end.run_until(15, [&] { return far_end.sim.simulation().autopilot().armed(); }));
  program.say("quit\n");
  EXPECT_EQ(program.wait(), 0);
  EXPECT_NE(program.text.find("idle: released by the operator"), std::string::npos) << program.text;
}

TEST(CompanionProgram, RefusesAMapThatDoesNotCoverTheMarginsAndSaysSo) {
  Program program({"--map", map_path(0.2), "--port", "/dev/null", "--config", write_file("config.json", kConfig)});
  EXPECT_EQ(program.wait(), 1);
  EXPECT_NE(program.text.find("its radius of 0.200 m is smaller than the margins' 0.281 m"), std::string::npos)
      << program.text;
}

TEST(CompanionProgram, RefusesBadInputWithOneLineAndTheContractsStatus) {
  const std::string map = map_path(0.3);
  const std::string config = write_file("bad.json", R"({"format": "swiftlet-config/1", "yaw": {"mod": "path"}})");
  const struct {
    std::vector<std::string> arguments;
    int status;
    const char* words;
  } cases[] = {
      {{"--port", "/dev/null"}, 2, "--map is required"},
      {{"--map", map, "--port", "/dev/null", "--fast"}, 2, "--fast"},
      {{"--map", map, "--port", ""}, 2, "--port"},
      {{"--map", map, "--port", ":57600"}, 2, "--port"},
      {{"--map", map, "--port", "udp:99999"}, 2, "'99999' is not a number"},
      {{"--map", map, "--port", "/dev/null:0"}, 2, "'0' is not a number"},
      {{"--map", map, "--port", "/dev/null:fast", "--config", write_file("config.json", kConfig)},
       3,
       "/dev/null:fast: cannot be opened"},
      {{"--map", "/nowhere.swm", "--port", "/dev/null"}, 3, "/nowhere.swm"},
      {{"--map", config, "--port", "/dev/null"}, 3, "bad.json"},
      {{"--map", map, "--port", "/dev/null", "--config", config}, 3, "'yaw.mod' is not a known key"},
      {{"--map", map, "--port", "/nowhere", "--config", write_file("config.json", kConfig)}, 3, "/nowhere: cannot be"},
      {{"--map", map, "--port", "/dev/null", "--key", config}, 3, "64 hexadecimal digits"},
      {{"--map", map, "--port", "udp:34567", "--config", write_file("config.json", kConfig), "--log", "/no/folder"},
       3,
       "/no/folder: no log can be kept there"},
      {{"--map", map, "--port", "udp:34567", "--config", write_file("config.json", kConfig), "--log", "/proc"},
       3,
       "/proc/flight_0001.ulg: cannot be written"},
  };
  for (const auto& each : cases) {
    Program program(each.arguments);
    EXPECT_EQ(program.wait(), each.status) << program.text;
    EXPECT_NE(program.text.find(each.words), std::string::npos) << program.text;
    EXPECT_EQ(std::count(program.text.begin(), program.text.end(), '\n'), 1) << program.text;
  }
}

// ---- The steps

TEST(FlightLoop, NeverMakesTwoStepsWithinHalfAPeriodHoweverLateOneWas) {
  using board::FlightLoop;
  using std::chrono::microseconds;
  const microseconds step{1'000'000};
  const auto after = [step](int late) {
    return (FlightLoop::step_after(step, step + microseconds(late)) - step).count();
  };
  EXPECT_EQ(after(100), 10'000);
  EXPECT_EQ(after(10'000), 10'000);
  EXPECT_EQ(after(14'999), 10'000);  // at once, and the rhythm stays
  EXPECT_EQ(after(15'001), 20'000);
  EXPECT_EQ(after(24'000), 20'000);
  EXPECT_EQ(after(3'000'000), 3'000'000);
  for (int late = 0; late < 200'000; late += 7) {
    const microseconds now = step + microseconds(late);
    const microseconds next = FlightLoop::step_after(step, now);
    EXPECT_EQ((next - step) % FlightLoop::kPeriod, microseconds(0));
    const microseconds begun = std::max(now, next);  // what comes after it is half a period away at least
    EXPECT_GE(FlightLoop::step_after(next, begun) - begun, FlightLoop::kPeriod / 2) << late;
  }
}

// ---- The planner's thread

constexpr Capacity kSmall{.segments = 64, .search_nodes = 4096};

companion::PlanJob job_in(const BoxGraphView& map) {
  companion::PlanJob job{map, {}};
  job.request.start.position = {0.6, 0.6, 0.8};
  job.request.goal.position = {3.5, 2.5, 0.8};
  job.request.v_max = 1;
  job.request.a_max = 2;
  return job;
}

TEST(ThreadWorker, MakesThePlansThatThePlannerMakesAndWakesWhoeverWaits) {
  const std::vector<std::byte> blob = *read_file(map_path(0.3));
  const auto memory = std::make_unique<PlannerStorage<kSmall>>();
  const auto other_memory = std::make_unique<PlannerStorage<kSmall>>();
  Planner planner(other_memory->spans());
  companion::PlanJob job = job_in(*BoxGraphView::open(blob));
  constexpr std::chrono::seconds kForEver{60};
  board::ThreadWorker worker(memory->spans(), kForEver);
  for (const Vector3& goal : {Vector3{3.5, 2.5, 0.8}, Vector3{-9, 0, 0}, Vector3{2, 2.6, 1}}) {
    job.request.goal.position = goal;
    const Clock::time_point begin = Clock::now();
    worker.start(job);
    ASSERT_TRUE(worker.done());
    EXPECT_LT(Clock::now() - begin, kForEver / 2);
    EXPECT_LE(worker.duration(), Clock::now() - begin);
    const Plan& expected = planner.plan(job.map, job.request);
    const Plan& plan = worker.result();
    EXPECT_EQ(plan.status, expected.status);
    ASSERT_EQ(plan.segments.size(), expected.segments.size());
    EXPECT_EQ(total_duration(plan.segments), total_duration(expected.segments));
  }
  EXPECT_EQ(worker.result().status, Status::kOk);
  EXPECT_GT(worker.duration().count(), 0);
}

TEST(ThreadWorker, AnswersWithoutPatienceAndEndsWithAPlanUnderWay) {
  const std::vector<std::byte> blob = *read_file(map_path(0.3));
  const auto memory = std::make_unique<PlannerStorage<kSmall>>();
  const companion::PlanJob job = job_in(*BoxGraphView::open(blob));
  board::ThreadWorker worker(memory->spans(), std::chrono::microseconds(0));
  worker.start(job);
  while (!worker.done()) std::this_thread::yield();
  EXPECT_EQ(worker.result().status, Status::kOk);
  worker.start(job);
}

TEST(ThreadWorker, WaitsForAPlanOnceHoweverOftenItIsAsked) {
  const std::vector<std::byte> blob = *read_file(map_path(0.3));
  const auto memory = std::make_unique<PlannerStorage<kSmall>>();
  companion::PlanJob job = job_in(*BoxGraphView::open(blob));
  job.request.start.velocity = {0.45, 0.35, 0};  // from there all ways fail, after 5.6 million units of work
  job.request.start.acceleration = {-0.4, -0.8, 0};
  constexpr std::chrono::milliseconds kPatience{5};
  board::ThreadWorker worker(memory->spans(), kPatience);
  worker.start(job);
  ASSERT_FALSE(worker.done());
  Clock::duration quickest = kPatience;
  for (int i = 0; i < 10; ++i) {
    const Clock::time_point begin = Clock::now();
    ASSERT_FALSE(worker.done());
    quickest = std::min(quickest, Clock::now() - begin);
  }
  EXPECT_LT(quickest, kPatience / 2);
}

// ---- The port

/// A serial adapter: a pseudo-terminal under a path that stays the same when another takes its place.
struct Adapter {
  std::string path = testing::TempDir() + "companion_" + std::to_string(::getpid()) + "_adapter";
  std::optional<hal::PseudoTerminal> line;

  Adapter() { plug_in(); }
  ~Adapter() { pull_out(); }
  Adapter(const Adapter&) = delete;
  Adapter& operator=(const Adapter&) = delete;

  void plug_in() {
    pull_out();
    ASSERT_TRUE(line.emplace().open());
    std::filesystem::create_symlink(line->peer_path(), path);
  }
  void pull_out() {
    line.reset();
    std::filesystem::remove(path);
  }
};

TEST(Port, HasColonsInItsPathOrABaudRateBehindIt) {
  const std::string path = "/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0";
  EXPECT_EQ(board::parse_port(path).device, path);
  EXPECT_EQ(board::parse_port(path).baud, 921'600U);
  EXPECT_EQ(board::parse_port(path + ":57600").device, path);
  EXPECT_EQ(board::parse_port(path + ":57600").baud, 57'600U);
  EXPECT_EQ(board::parse_port("/dev/ttyS0:115200").device, "/dev/ttyS0");
  EXPECT_EQ(board::parse_port("/dev/ttyS0").device, "/dev/ttyS0");
  const board::PortName udp = board::parse_port("udp:14540:10.0.0.2:14550");
  EXPECT_EQ(udp.device, "");
  EXPECT_EQ(udp.local_port, 14'540);
  EXPECT_EQ(udp.host, "10.0.0.2");
  EXPECT_EQ(udp.remote_port, 14'550);
  EXPECT_THROW(board::parse_port("/dev/ttyS0:"), Failure);
}

TEST(Port, OpensADeviceAgainThatWasGone) {
  using board::Port;
  using std::chrono::microseconds;
  using std::chrono::seconds;
  Adapter adapter;
  Port port(board::parse_port(adapter.path));
  std::array<std::byte, 8> buffer{};
  EXPECT_EQ(port.keep(seconds(10)), Port::Change::kNone);
  adapter.pull_out();
  EXPECT_EQ(port.read(buffer), 0U);  // notices
  EXPECT_EQ(port.keep(seconds(20)), Port::Change::kGone);
  EXPECT_EQ(port.keep(seconds(21)), Port::Change::kNone);  // still gone
  adapter.plug_in();
  EXPECT_EQ(port.keep(seconds(22) - microseconds(1)), Port::Change::kNone);  // not before a second is over
  EXPECT_EQ(port.write(buffer), 0U);
  EXPECT_EQ(port.keep(seconds(22)), Port::Change::kBack);
  EXPECT_EQ(port.keep(seconds(23)), Port::Change::kNone);
  EXPECT_EQ(port.write(buffer), buffer.size());
  std::array<std::byte, 16> received{};
  EXPECT_EQ(adapter.line->read(received), buffer.size());
}

TEST(CompanionProgram, SpeaksAgainOverAnAdapterThatWasPulledOut) {
  Adapter adapter;
  Program program({"--map", map_path(0.3), "--port", adapter.path, "--config", write_file("config.json", kConfig)});
  const auto hears_program = [&adapter] {
    pollfd waiting{adapter.line->descriptor(), POLLIN, 0};
    std::array<std::byte, 64> buffer{};
    return ::poll(&waiting, 1, 5000) > 0 && adapter.line->read(buffer) > 0;
  };
  EXPECT_TRUE(hears_program());
  adapter.plug_in();
  EXPECT_TRUE(hears_program());
  program.say("quit\n");
  EXPECT_EQ(program.wait(), 0);
  EXPECT_NE(program.text.find("! the port has gone"), std::string::npos) << program.text;
  EXPECT_NE(program.text.find("! the port is open again"), std::string::npos) << program.text;
}

// ---- The time of signatures

std::uint64_t kept_time(const std::string& key) {
  std::ifstream file(key + ".time");
  std::uint64_t time = 0;
  file >> time;
  return time;
}

TEST(SigningTime, GoesOnWhereItEndedWhateverTheClockSays) {
  using board::SigningTime;
  const std::string key = write_file("key", "");
  std::filesystem::remove(key + ".time");
  {
    SigningTime time(key);
    EXPECT_EQ(time.first(5'000'000'000), 5'000'000'000U);
    time.keep(5'000'000'000);
    EXPECT_EQ(kept_time(key), 5'000'000'000 + SigningTime::kAhead);
    time.keep(5'000'000'000 + SigningTime::kAhead / 2);
    EXPECT_EQ(kept_time(key), 5'000'000'000 + SigningTime::kAhead);
    time.keep(5'000'000'000 + SigningTime::kAhead / 2 + 1);
    EXPECT_GT(kept_time(key), 5'000'000'000 + SigningTime::kAhead);
  }
  const std::uint64_t kept = kept_time(key);  // the power went
  SigningTime time(key);
  EXPECT_EQ(time.first(0), kept);
  EXPECT_EQ(time.first(kept + 1), kept + 1);
  time.keep(kept);
  time.end(kept + 7);
  EXPECT_EQ(SigningTime(key).first(0), kept + 7);
  for (const char* bad : {"", "\n", "12", "-1\n", "12 \n", "99999999999999999999\n", "281474976710656\n"}) {
    std::ofstream(key + ".time") << bad;
    EXPECT_THROW(SigningTime{key}, Failure) << bad;
  }
  EXPECT_THROW(SigningTime("/proc/key").keep(1), Failure);
}

/// Signing time of the first frame that the program sends.
std::uint64_t first_signing_time(hal::PseudoTerminal& line) {
  std::array<std::byte, 512> buffer{};
  std::size_t size = 0;
  const auto wanted = [&] { return size < 2 ? 2 : 12 + std::to_integer<std::size_t>(buffer[1]) + 13; };
  while (size < wanted()) {
    pollfd waiting{line.descriptor(), POLLIN, 0};
    if (::poll(&waiting, 1, 5000) <= 0) return 0;
    size += line.read(std::span(buffer).subspan(size, wanted() - size));
  }
  std::uint64_t time = 0;
  for (std::size_t i = 0; i < 6; ++i) time |= std::to_integer<std::uint64_t>(buffer[wanted() - 12 + i]) << (8 * i);
  return time;
}

TEST(CompanionProgram, SignsWithATimeThatIsKept) {
  const std::string key = write_file("key", std::string(64, 'a') + "\n");
  constexpr std::uint64_t kYears = 200'000'000'000'000;  // ahead of the clock
  std::ofstream(key + ".time") << kYears << "\n";
  hal::PseudoTerminal line;
  ASSERT_TRUE(line.open());
  Program program({"--map", map_path(0.3), "--port", line.peer_path(), "--config", write_file("config.json", kConfig),
                   "--key", key});
  const std::uint64_t first = first_signing_time(line);
  EXPECT_GT(first, kYears);
  EXPECT_LT(first, kYears + board::SigningTime::kAhead);
  EXPECT_EQ(kept_time(key), kYears + board::SigningTime::kAhead);
  program.say("quit\n");
  EXPECT_EQ(program.wait(), 0) << program.text;
  EXPECT_GE(kept_time(key), first);
  EXPECT_LT(kept_time(key), kYears + board::SigningTime::kAhead);
}

// ---- The log's thread

/// Refuses at will, and waits while it is told to.
class SlowStorage final : public hal::Storage {
 public:
  std::optional<std::size_t> read(std::string_view name, std::size_t offset, std::span<std::byte> into) override {
    return memory.read(name, offset, into);
  }
  bool append(std::string_view name, std::span<const std::byte> bytes) override {
    while (waits) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return !refuses && memory.append(name, bytes);
  }
  bool remove(std::string_view /*name*/) override { return false; }
  MemoryStorage memory;
  std::atomic<bool> waits{false};
  std::atomic<bool> refuses{false};
};

TEST(ThreadStorage, StoresInOrderWhateverIsAppendedAndNeverWaits) {
  SlowStorage disk;
  const auto storage = std::make_unique<board::ThreadStorage>(disk);
  std::vector<std::byte> all;
  disk.waits = true;
  const auto append = [&](std::size_t size) {
    std::vector<std::byte> bytes(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>((all.size() + i) * 7 / 5);
    all.insert(all.end(), bytes.begin(), bytes.end());
    return storage->append("a.ulg", bytes);
  };
  for (int round = 0; round < 3; ++round) {
    disk.waits = true;
    for (std::size_t n = 1; n < board::ThreadStorage::kRing / 1000; ++n) ASSERT_TRUE(append(n));
    disk.waits = false;
    ASSERT_TRUE(storage->drain());
  }
  EXPECT_EQ(disk.memory.bytes(), all);
}

TEST(ThreadStorage, IsFullWhenTheDiskIsTooSlowOrRefuses) {
  const std::vector<std::byte> half(board::ThreadStorage::kRing / 2 + 1);
  SlowStorage slow;
  {
    slow.waits = true;
    const auto storage = std::make_unique<board::ThreadStorage>(slow);
    EXPECT_TRUE(storage->append("a.ulg", half));
    EXPECT_FALSE(storage->append("a.ulg", half));
    slow.waits = false;
    EXPECT_FALSE(storage->append("a.ulg", std::span(half).first(1)));  // there is a gap now
  }
  EXPECT_EQ(slow.memory.bytes().size(), half.size());
  SlowStorage broken;
  broken.refuses = true;
  const auto storage = std::make_unique<board::ThreadStorage>(broken);
  EXPECT_TRUE(storage->append("a.ulg", std::span(half).first(1)));
  EXPECT_FALSE(storage->drain());
  EXPECT_FALSE(storage->append("a.ulg", std::span(half).first(1)));
}

// ---- swiftlet-config/1

TEST(ConfigFile, WhatIsWrittenIsReadBackBitForBit) {
  companion::Settings settings;
  settings.form = SetpointForm::kRates;
  settings.start = {0.1, -2.0 / 3, 1e-9};
  settings.limits.vehicle = Vehicle{1.1, 0, 21, 3};
  settings.takeoff.patience = 12'345'679;
  settings.margins.heading_accuracy = 0.0123;
  settings.yaw.mode = YawMode::kTowards;
  settings.control.rates.k_position.x() = 6.1;
  settings.planning.budget.deadline = 12'345;
  const std::string text = config_text(settings);
  const companion::Settings read = parse_config("text", text);
  EXPECT_EQ(config_text(read), text);
  EXPECT_EQ(read.start, settings.start);
  EXPECT_EQ(read.takeoff.patience, settings.takeoff.patience);
  EXPECT_EQ(read.planning.budget.deadline, 12'345U);
  EXPECT_EQ(read.margins.heading_accuracy, 0.0123);
  EXPECT_EQ(read.control.rates.k_position.x(), 6.1);
  EXPECT_EQ(read.limits.vehicle->thrust_max, 21);
}

TEST(ConfigFile, AHoverThrustThatIsNotGivenIsAskedFor) {
  const auto read = [](const char* group) {
    return parse_config("text", std::string(R"({"format": "swiftlet-config/1")") + group + "}");
  };
  EXPECT_TRUE(read("").asks_hover_thrust);
  EXPECT_TRUE(read(R"(, "hover_thrust": {"most": 0.7})").asks_hover_thrust);
  EXPECT_TRUE(read(R"(, "hover_thrust": {"initial": null})").asks_hover_thrust);
  const companion::Settings given = read(R"(, "hover_thrust": {"initial": 0.4})");
  EXPECT_FALSE(given.asks_hover_thrust);
  EXPECT_EQ(given.hover_thrust.initial, 0.4);
  for (const companion::Settings& settings : {given, companion::Settings{}}) {
    const companion::Settings again = parse_config("text", config_text(settings));
    EXPECT_EQ(again.asks_hover_thrust, settings.asks_hover_thrust);
    EXPECT_EQ(again.hover_thrust.initial, settings.hover_thrust.initial);
  }
}

TEST(ConfigFile, NumbersOutOfRangeAreRefused) {
  EXPECT_NO_THROW((void)parse_config("text", R"({"format": "swiftlet-config/1"})"));
  const std::pair<const char*, const char*> cases[] = {
      {R"("system_id": 0)", "system id"},
      {R"("start_m": [0, 1e7, 0])", "start"},
      {R"("arrival_tolerance_m": 0)", "arrival tolerance"},
      {R"("margins": {"tube_rates_m": -0.1})", "margins"},
      {R"("margins": {"heading_accuracy_rad": 1.1})", "heading accuracy"},
      {R"("takeoff": {"height_m": 0.1})", "take-off tolerance"},
      {R"("takeoff": {"tolerance_m": 1})", "take-off tolerance"},
      {R"("takeoff": {"standing_s": 10})", "standing"},
      {R"("takeoff": {"patience_s": 0})", "take-off patience"},
      {R"("planning": {"search_weight": 0.5})", "search weight"},
      {R"("planning": {"latency_s": -1})", "a time"},
      {R"("predictor": {"longest_s": 61})", "a time"},
      {R"("yaw": {"rate_max_rad_s": 0})", "yaw limits"},
      {R"("yaw": {"least_distance_m": -1})", "yaw distances"},
      {R"("yaw": {"angle_rad": 1e9})", "yaw angle"},
      {R"("control": {"attitude": {"k_position": [12, -1, 12]}})", "control: a gain"},
      {R"("control": {"rates": {"k_velocity_form": [1, 1, -1]}})", "control: a gain"},
      {R"("control": {"rates": {"drag_1_s": -1}})", "control: feedback or drag"},
      {R"("control": {"attitude": {"mass_kg": 0}})", "control: mass"},
      {R"("control": {"rates": {"tilt_max_rad": 2}})", "control: tilt"},
      {R"("control": {"attitude": {"thrust_min_m_s2": 20}})", "control: thrust bounds"},
      {R"("control": {"attitude": {"thrust_max_m_s2": 9}})", "control: thrust bounds"},
      {R"("control": {"rates": {"rate_max_rad_s": [3, 3, 0]}})", "control: rates"},
      {R"("predictor": {"disturbance_time_s": 0})", "predictor: disturbance time"},
      {R"("hover_thrust": {"initial": 50})", "hover thrust"},
      {R"("hover_thrust": {"least": 0.6, "most": 0.55})", "hover thrust"},
      {R"("hover_thrust": {"window_s": 0})", "hover thrust: a time"},
      {R"("supervisor": {"odometry_age_max_s": 0})", "supervisor: a time"},
      {R"("supervisor": {"blocked_patience_s": -1})", "supervisor: blocked patience"},
      {R"("supervisor": {"setpoint_age_yield_s": 0.2})", "supervisor: yields before"},
      {R"("supervisor": {"deadline_misses_max": 0})", "supervisor: no missed deadline"},
      {R"("supervisor": {"position_jump_m": -1})", "supervisor: position jump"},
  };
  for (const auto& [member, words] : cases) {
    try {
      (void)parse_config("text", R"({"format": "swiftlet-config/1", )" + std::string(member) + "}");
      ADD_FAILURE() << member;
    } catch (const Failure& failure) {
      EXPECT_NE(failure.line.find(words), std::string::npos) << failure.line;
    }
  }
}

TEST(ConfigFile, FaultsAreNamed) {
  const std::pair<const char*, const char*> cases[] = {
      {R"({"format": "swiftlet-config/1", "limit": {}})", "'limit' is not a known key"},
      {R"({"format": "swiftlet-config/1", "limits": 3})", "'limits' is not a JSON object"},
      {R"({"format": "swiftlet-config/1", "limits": {"vmax_m_s": -1}})", "limits"},
      {R"({"format": "swiftlet-config/1", "limits": {"vmax": 1}})", "'limits.vmax' is not a known key"},
      {R"({"format": "swiftlet-config/1", "setpoint": "thrust"})", "'setpoint' is none of position, attitude, rates"},
      {R"({"format": "swiftlet-config/1", "start_m": [0, 0]})", "'start_m' has 2 numbers, not 3"},
      {R"({"format": "swiftlet-config/1", "control": {"rates": {"k": 1}}})", "'control.rates.k' is not a known key"},
      {R"({"format": "swiftlet-config/1", "system_id": 1.5})", "'system_id'"},
      {R"({"format": "swiftlet-config/1", "takeoff": {"patience_s": 1e9}})", "'takeoff.patience_s' is out of range"},
      {R"({"format": "swiftlet-config/2"})", "swiftlet-config/1"},
      {"[]", "is not a JSON object"},
      {"{", "not valid JSON"},
  };
  for (const auto& [text, words] : cases) {
    try {
      (void)parse_config("text", text);
      ADD_FAILURE() << text;
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.status, ExitStatus::kBadFile);
      EXPECT_NE(failure.line.find(words), std::string::npos) << failure.line;
    }
  }
}

}  // namespace
}  // namespace swiftlet::tools
