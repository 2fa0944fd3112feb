// The program `pixhawk_sim`: a simulated vehicle with its autopilot on a pseudo-terminal or a UDP port, in real time.
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <limits>
#include <memory>
#include <thread>

#include "cli/arguments.hpp"
#include "cli/failure.hpp"
#include "cli/text.hpp"
#include "cli/vehicle_file.hpp"
#include "sim/pixhawk_sim.hpp"
#include "swiftlet/hal/posix_uart.hpp"
#include "swiftlet/version.hpp"

namespace swiftlet::tools {
namespace {

struct Options {
  bool pty = false;
  std::uint64_t udp = 0;
  std::string to;
  std::string vehicle;
  std::string map;
  std::vector<std::string> faults;
  double link_delay = 0;
  double duration = std::numeric_limits<double>::infinity();
  PixhawkSimSettings settings;
};

volatile std::sig_atomic_t interrupted = 0;  // NOLINT: a signal handler can reach nothing else

/// Host and port of "HOST:PORT".
std::pair<std::string, std::uint16_t> split_address(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  const std::optional<double> port = colon == std::string::npos ? std::nullopt : parse_number(text.substr(colon + 1));
  if (!port || !(*port >= 1 && *port <= 65535) || *port != static_cast<double>(static_cast<int>(*port))) {
    throw Failure{ExitStatus::kUsage, "--to: '" + text + "' is not ADDRESS:PORT"};
  }
  return {text.substr(0, colon), static_cast<std::uint16_t>(*port)};
}

std::vector<Fault> parse_faults(const std::vector<std::string>& texts) {
  std::vector<Fault> faults;
  for (const std::string& text : texts) {
    const std::optional<Fault> fault = parse_fault(text);
    if (!fault) {
      throw Failure{ExitStatus::kUsage, "--fault: '" + text + "' is no fault ('pixhawk_sim --help' lists them)"};
    }
    faults.push_back(*fault);
  }
  return faults;
}

void complete(Options& options) {
  PixhawkSimSettings& settings = options.settings;
  settings.faults = parse_faults(options.faults);
  settings.link_delay = std::chrono::round<Microseconds>(std::chrono::duration<double>(options.link_delay));
  if (!options.vehicle.empty()) {
    const VehicleFile file = load_vehicle(options.vehicle);
    settings.simulation.vehicle = file.model;
    settings.simulation.hover_thrust = file.hover_thrust;
  }
  if (!options.map.empty()) settings.simulation.obstacles = occupied_boxes(unwrap(read_octree(options.map)));
}

/// Steps with the wall clock until told to stop. What the device cannot take is lost, as on a serial line.
void run_in_real_time(PixhawkSim& sim, hal::PosixUart& uart, double duration) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  std::array<std::byte, 4096> buffer{};
  while (interrupted == 0 && std::chrono::duration<double>(sim.time()).count() < duration) {
    std::this_thread::sleep_until(start + sim.time() + Simulation::kStep);
    for (std::size_t count = uart.read(buffer); count > 0; count = uart.read(buffer)) {
      sim.receive(std::span(buffer).first(count));
    }
    const std::vector<std::byte> bytes = sim.step();
    (void)uart.write(bytes);
    for (const Fault& fault : sim.take_begun()) {
      std::fprintf(stderr, "%.3f s: %s\n", fault.at, describe(fault.kind));
    }
  }
}

void print_summary(const PixhawkSim& sim) {
  const Simulation& simulation = sim.simulation();
  std::fprintf(stderr, "time         %.3f s\n", std::chrono::duration<double>(sim.time()).count());
  std::fprintf(stderr, "position     %s m\n", to_text(simulation.truth().position).c_str());
  std::fprintf(stderr, "clearance    %.3f m\n", simulation.clearance());
  std::fprintf(stderr, "touch-down   %.3f m/s\n", simulation.quadrotor().impact_speed());
  std::fprintf(stderr, "received     %u frames, %u damaged\n", sim.counters().frames, sim.counters().bad_checksum);
}

void run(Options& options) {
  complete(options);
  const auto sim = std::make_unique<PixhawkSim>(options.settings);
  hal::PseudoTerminal pty;
  hal::UdpUart udp;
  hal::PosixUart* uart = &pty;
  if (options.udp != 0) {
    const auto [host, port] =
        options.to.empty() ? std::pair<std::string, std::uint16_t>{"127.0.0.1", 0} : split_address(options.to);
    if (!udp.open(static_cast<std::uint16_t>(options.udp), host.c_str(), port)) {
      throw Failure{ExitStatus::kBadFile, "UDP port " + std::to_string(options.udp) + " cannot be opened"};
    }
    uart = &udp;
  } else {
    if (!pty.open()) throw Failure{ExitStatus::kBadFile, "no pseudo-terminal can be opened"};
    std::printf("%s\n", pty.peer_path().c_str());
    std::fflush(stdout);
  }
  run_in_real_time(*sim, *uart, options.duration);
  print_summary(*sim);
}

void add_options(CLI::App& app, Options& options) {
  SimulationSettings& simulation = options.settings.simulation;
  CLI::Option* pty = app.add_flag("--pty", options.pty, "Open a pseudo-terminal and print its path (the default)");
  CLI::Option* udp = add_count(app, "--udp", options.udp, 1, 65535, "Listen on this port instead");
  app.add_option("--to", options.to, "ADDRESS:PORT to send to; else whoever sent the latest datagram")->needs(udp);
  pty->excludes(udp);
  app.add_option("--vehicle", options.vehicle, "swiftlet-vehicle/1 to fly");
  app.add_option("--map", options.map, "OctoMap whose least distance is reported at the end");
  add_vector(app, "--start", simulation.start, "Where it stands on the ground [m]");
  add_number(app, "--yaw", simulation.start_yaw, {-7, 7}, "Heading there, from east [rad]");
  add_vector(app, "--origin", simulation.estimator.origin, "Origin of the autopilot's local frame [m]");
  add_number(app, "--heading", simulation.estimator.heading, {-7, 7}, "Heading of the local frame's east [rad]");
  add_vector(app, "--wind", simulation.wind.mean, "Mean wind [m/s]");
  add_number(app, "--gust", simulation.wind.gust, {0, 100}, "Speed of gusts [m/s]");
  add_number(app, "--link-delay", options.link_delay, {0, 10}, "Delay of each direction [s]");
  app.add_option("--fault", options.faults, "KIND@T or KIND@T+D, any number of them")->allow_extra_args(false);
  add_count(app, "--seed", simulation.seed, 0, std::numeric_limits<std::uint64_t>::max() / 16, "Of all disturbances");
  add_number(app, "--duration", options.duration, {0, 1e6}, "End after so long [s]");
  app.footer("Faults, at T seconds, for D seconds:\n" + list_faults());
}

}  // namespace
}  // namespace swiftlet::tools

int main(int argc, char** argv) {
  using swiftlet::tools::ExitStatus;
  const auto exit_with = [](ExitStatus status, const std::string& line) {
    std::fprintf(stderr, "pixhawk_sim: %s\n", line.c_str());
    return static_cast<int>(status);
  };
  std::signal(SIGPIPE, SIG_IGN);
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { swiftlet::tools::interrupted = 1; });
  try {
    CLI::App app("Simulates a quadrotor and its PX4 autopilot at the far end of a MAVLink link.", "pixhawk_sim");
    app.set_version_flag("--version", std::string("pixhawk_sim ") + swiftlet::kVersion);
    swiftlet::tools::Options options;
    add_options(app, options);
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      const bool asked_for = error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success);
      return asked_for ? app.exit(error) : exit_with(ExitStatus::kUsage, error.what());
    }
    run(options);
    return static_cast<int>(ExitStatus::kDone);
  } catch (const swiftlet::tools::Failure& failure) {
    return exit_with(failure.status, failure.line);
  } catch (const std::exception& error) {
    return exit_with(ExitStatus::kInternal, std::string("internal error, please report: ") + error.what());
  }
}
