// The program `companion`: flies a vehicle over a MAVLink link, from goal to goal through a map.
#include <poll.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <list>
#include <memory>

#include "board_config.hpp"
#include "cli/config_file.hpp"
#include "cli/failure.hpp"
#include "cli/text.hpp"
#include "linux/console.hpp"
#include "linux/flight_loop.hpp"
#include "linux/port.hpp"
#include "linux/signing_time.hpp"
#include "linux/thread_storage.hpp"
#include "linux/thread_worker.hpp"
#include "map/file_io.hpp"
#include "swiftlet/hal/file_storage.hpp"
#include "swiftlet/hal/monotonic_clock.hpp"
#include "swiftlet/version.hpp"

namespace swiftlet::board {
namespace {

using tools::ExitStatus;
using tools::Failure;

static_assert(ThreadWorker::kPatience < FlightLoop::kPeriod);
constexpr int kLookPeriodMs = 100;
constexpr int kLooksToLetGo = 40;

struct Options {
  std::string map;
  std::string port;
  std::string config;
  std::string log;
  std::string key;
  bool autopilot_signs = false;
};

volatile std::sig_atomic_t interrupted = 0;  // NOLINT: a signal handler can reach nothing else

// ---- Files

struct LoadedMap {
  std::string file;              // with its whole path
  std::vector<std::byte> bytes;  // in memory: a file that is replaced under way harms nobody
  BoxGraphView graph;
};

LoadedMap load_map(const std::string& path) {
  LoadedMap map{tools::absolute_path(path), tools::unwrap(tools::read_file(path)), {}};
  const Result<BoxGraphView> graph = BoxGraphView::open(map.bytes);
  if (!graph.ok()) throw Failure{ExitStatus::kBadFile, path + ": " + describe(graph.status())};
  map.graph = *graph;
  return map;
}

std::uint8_t hex_digit(const std::string& path, std::byte digit) {
  const auto c = std::to_integer<char>(digit);
  if (c >= '0' && c <= '9') return static_cast<std::uint8_t>(c - '0');
  if (c >= 'a' && c <= 'f') return static_cast<std::uint8_t>(c - 'a' + 10);
  if (c >= 'A' && c <= 'F') return static_cast<std::uint8_t>(c - 'A' + 10);
  throw Failure{ExitStatus::kBadFile, path + ": is not a key: 64 hexadecimal digits are needed"};
}

/// [10 us since 2015], the unit of signing times.
std::uint64_t time_of_day() {
  constexpr std::chrono::seconds kStart{1'420'070'400};  // 1 January 2015
  const auto since = std::chrono::system_clock::now().time_since_epoch() - kStart;
  const auto ticks = std::chrono::duration_cast<std::chrono::microseconds>(since).count() / 10;
  return static_cast<std::uint64_t>(std::max<std::int64_t>(ticks, 0));
}

/// A key of 64 hexadecimal digits.
mavlink::Signing load_key(const std::string& path) {
  std::vector<std::byte> text = tools::unwrap(tools::read_file(path));
  while (!text.empty() && (text.back() == std::byte{'\n'} || text.back() == std::byte{'\r'})) text.pop_back();
  mavlink::Signing signing;
  if (text.size() != 2 * signing.key.size()) (void)hex_digit(path, std::byte{0});
  for (std::size_t i = 0; i < signing.key.size(); ++i) {
    signing.key[i] = static_cast<std::byte>(hex_digit(path, text[2 * i]) << 4U | hex_digit(path, text[2 * i + 1]));
  }
  return signing;
}

// ---- The log

/// The number after the largest of all logs in the folder: none is ever written over.
std::string next_log_name(const std::string& folder) {
  constexpr std::string_view kPrefix = "flight_";
  std::error_code error;
  std::uint32_t last = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename();
    if (!name.starts_with(kPrefix) || !name.ends_with(".ulg")) continue;
    const std::string digits = name.substr(kPrefix.size(), name.size() - kPrefix.size() - 4);
    const std::optional<double> number = tools::parse_number(digits);
    if (number && *number >= 1 && *number < 1e9) last = std::max(last, static_cast<std::uint32_t>(*number));
  }
  if (error) throw Failure{ExitStatus::kBadFile, folder + ": no log can be kept there: " + error.message()};
  std::string digits = std::to_string(last + 1);
  if (digits.size() < 4) digits.insert(0, 4 - digits.size(), '0');
  return std::string(kPrefix) + digits + ".ulg";
}

std::string board_name() {
  utsname names{};
  (void)::uname(&names);
  return std::string(names.sysname) + " " + names.machine;
}

/// The log of one start of the program, written by a thread of its own.
class KeptLog {
 public:
  KeptLog(const std::string& folder, const companion::Settings& settings, const LoadedMap& map)
      : files_(folder), storage_(files_), name_(next_log_name(folder)), log_(storage_) {
    const std::string text = tools::config_text(settings);
    const std::string board = board_name();
    const TimeUs now = hal::MonotonicClock().now().count();
    const std::uint32_t crc = map.graph.header().crc32;
    (void)log_.begin(name_, now, {kVersion, board, text, crc, map.file, settings.signing.has_value()});
    if (storage_.drain()) return;
    throw Failure{ExitStatus::kBadFile, folder + "/" + name_ + ": cannot be written: " + std::strerror(errno)};
  }
  /// After the last step.
  ~KeptLog() {
    log_.end();
    if (!storage_.drain()) std::fprintf(stderr, "companion: %s: there was no room for all of it\n", name_.c_str());
  }
  KeptLog(const KeptLog&) = delete;
  KeptLog& operator=(const KeptLog&) = delete;

  companion::FlightLog& log() { return log_; }

 private:
  hal::FileStorage files_;
  ThreadStorage storage_;
  std::string name_;
  companion::FlightLog log_;
};

// ---- The console

class Console {
 public:
  Console(FlightLoop& loop, const ThreadWorker& worker) : loop_(loop), worker_(worker) {}

  /// Shows what happened since the last time.
  FlightView show() {
    FlightView view = loop_.look();
    for (const companion::Note& note : view.notes) print(note);
    std::fflush(stdout);
    return view;
  }

  /// The same, then waits a while for lines; false when the program is to end.
  bool look() {
    const FlightView view = show();
    pollfd input{STDIN_FILENO, POLLIN, 0};
    const int ready = ::poll(&input, reads_ ? 1 : 0, kLookPeriodMs);
    if (ready > 0 && (input.revents & (POLLIN | POLLHUP)) != 0) read(view);
    return !quits_;
  }

 private:
  static void print(const companion::Note& note) {
    const bool warns = note.severity <= mavlink::Severity::kWarning;
    std::printf("%.2f %s%.*s\n", static_cast<double>(note.time) / 1e6, warns ? "! " : "",
                static_cast<int>(note.view().size()), note.view().data());
  }

  void read(const FlightView& view) {
    std::array<char, 512> buffer{};
    const ssize_t count = ::read(STDIN_FILENO, buffer.data(), buffer.size());
    if (count <= 0) {
      reads_ = false;  // no console: the flight goes on
      return;
    }
    pending_.append(buffer.data(), static_cast<std::size_t>(count));
    for (std::size_t end = pending_.find('\n'); end != std::string::npos; end = pending_.find('\n')) {
      obey(pending_.substr(0, end), view);
      pending_.erase(0, end + 1);
    }
  }

  void obey(const std::string& line, const FlightView& view) {
    const std::optional<ConsoleLine> parsed = parse_line(line);
    if (!parsed) {
      if (line.find_first_not_of(" \t\r") != std::string::npos)
        std::printf("not understood: '%s'; try help\n", line.c_str());
    } else if (const auto* word = std::get_if<companion::Word>(&*parsed)) {
      loop_.tell(*word);
    } else if (const auto* map = std::get_if<NewMap>(&*parsed)) {
      change_map(map->path);
    } else {
      answer(std::get<Query>(*parsed), view);
    }
  }

  void change_map(const std::string& path) {
    try {
      maps_.push_back(load_map(path));
      loop_.replace_map(maps_.back().graph, maps_.back().file);
    } catch (const Failure& failure) {
      std::printf("! %s\n", failure.line.c_str());
    }
  }

  void answer(Query query, const FlightView& view) {
    if (query == Query::kQuit) quits_ = true;
    if (query == Query::kHelp) std::printf("%s", kConsoleHelp);
    if (query == Query::kStatus) print_status(view);
  }

  void print_status(const FlightView& view) const {
    const companion::Telemetry& t = view.telemetry;
    std::printf("%s, %s (%s); mode %s, %s, %s\n", companion::describe(t.phase), describe(t.state), describe(t.reason),
                mavlink::name_of(t.mode), t.armed ? "armed" : "disarmed", t.aligned ? "aligned" : "not aligned");
    std::printf("at %s m, error %.3f m, hover thrust %.3f\n", tools::to_text(t.estimate.position).c_str(),
                static_cast<double>(t.tracking_error), static_cast<double>(t.hover_thrust));
    std::printf("goals: %u reached, %u waiting; plan %u, the last took %.1f ms; %u discarded\n", t.goals_reached,
                t.goals_waiting, t.plan.id, static_cast<double>(worker_.duration().count()) / 1000, t.plans_discarded);
    std::printf("link: %llu bytes in, %llu out, %u frames lost, %u damaged, %.1f ms one way\n",
                static_cast<unsigned long long>(t.link.received_bytes),
                static_cast<unsigned long long>(t.link.sent_bytes), t.link.lost_frames, t.codec.bad_checksum,
                static_cast<double>(t.link_delay) / 1000);
    std::printf("steps: %llu, late by %.1f ms (99 %%), %.1f ms at most\n",
                static_cast<unsigned long long>(view.lateness.count()), view.lateness.quantile(0.99),
                view.lateness.most());
  }

  FlightLoop& loop_;
  const ThreadWorker& worker_;
  std::string pending_;
  std::list<LoadedMap> maps_;
  bool reads_ = true;
  bool quits_ = false;
};

// ---- The program

companion::Settings read_settings(const Options& options) {
  companion::Settings settings;
  if (!options.config.empty()) settings = tools::load_config(options.config);
  if (!options.key.empty()) settings.signing = load_key(options.key);
  settings.autopilot_signs = options.autopilot_signs;
  return settings;
}

/// A map that is too tight for the margins is not flown, and nothing is started with it.
void check_margins_of(const LoadedMap& map, const std::string& path, const companion::Settings& settings) {
  const auto radius = static_cast<Real>(map.graph.header().radius);
  const MarginReport report = companion::margins_of(settings, radius);
  if (report.verdict == MarginVerdict::kCovered) return;
  throw Failure{
      ExitStatus::kNoAnswer,
      path + ": no flight: its radius of " + tools::to_text(radius, 3) + " m is smaller than the margins' " +
          tools::to_text(report.required, 3) +
          " m (vehicle, map error, tracking tube, numerics); build it with a larger --radius or configure 'margins'"};
}

/// A flight that is under way is left to the autopilot, which holds.
void let_go(FlightLoop& loop, Console& console) {
  loop.tell({.kind = companion::Word::Kind::kRelease});
  for (int i = 0; i < kLooksToLetGo; ++i) {
    console.look();
    if (console.show().telemetry.setpoints == Setpoints::kNone) return;
  }
}

/// A flight goes on when the time of its signatures cannot be kept.
void keep(std::optional<SigningTime>& signing_time, std::uint64_t used) {
  try {
    if (signing_time) signing_time->keep(used);
  } catch (const Failure& failure) {
    std::printf("! %s\n", failure.line.c_str());
    signing_time.reset();
  }
}

void run(const Options& options) {
  static PlannerStorage<kBoard> planner_memory;
  static companion::CompanionStorage<kBoard> memory;
  const PortName port_name = parse_port(options.port);
  companion::Settings settings = read_settings(options);
  std::optional<SigningTime> signing_time;
  if (settings.signing) settings.signing->time = signing_time.emplace(options.key).first(time_of_day());
  const LoadedMap map = load_map(options.map);
  check_margins_of(map, options.map, settings);
  Port port(port_name);
  std::unique_ptr<KeptLog> log;
  if (!options.log.empty()) log = std::make_unique<KeptLog>(options.log, settings, map);
  if (signing_time) signing_time->keep(settings.signing->time);
  ThreadWorker worker(planner_memory.spans());
  const companion::Devices devices{port, worker, log ? &log->log() : nullptr};
  const auto flight = std::make_unique<companion::Companion>(settings, map.graph, memory.memory(), devices);
  FlightLoop loop(*flight, port);
  Console console(loop, worker);
  while (interrupted == 0 && console.look()) {
    keep(signing_time, console.show().telemetry.signing_time);
  }
  let_go(loop, console);
  loop.end();
  const std::uint64_t used = console.show().telemetry.signing_time;
  if (signing_time && used > 0) signing_time->end(used);
}

void add_options(CLI::App& app, Options& options) {
  app.add_option("--map", options.map, "Map to fly in, of 'swiftlet map build'")->required();
  app.add_option("--port", options.port, "DEVICE[:BAUD] (921600), or udp:PORT[:HOST:PORT]")->required();
  app.add_option("--config", options.config, "swiftlet-config/1 file");
  app.add_option("--log", options.log, "Folder to keep a log of each start in, flight_0001.ulg and so on");
  CLI::Option* key = app.add_option("--key", options.key, "File with the key for signing, 64 hexadecimal digits");
  app.add_flag("--autopilot-signs", options.autopilot_signs, "Believe only signed messages of the autopilot")
      ->needs(key);
  app.footer(std::string("On standard input:\n") + kConsoleHelp);
}

}  // namespace
}  // namespace swiftlet::board

int main(int argc, char** argv) {
  using swiftlet::tools::ExitStatus;
  const auto exit_with = [](ExitStatus status, const std::string& line) {
    std::fprintf(stderr, "companion: %s\n", line.c_str());
    return static_cast<int>(status);
  };
  std::signal(SIGPIPE, SIG_IGN);
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { swiftlet::board::interrupted = 1; });
  try {
    CLI::App app("Flies a vehicle through a map over a MAVLink link.", "companion");
    app.set_version_flag("--version", std::string("companion ") + swiftlet::kVersion);
    swiftlet::board::Options options;
    swiftlet::board::add_options(app, options);
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      const bool asked_for = error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success);
      return asked_for ? app.exit(error) : exit_with(ExitStatus::kUsage, error.what());
    }
    swiftlet::board::run(options);
    return static_cast<int>(ExitStatus::kDone);
  } catch (const swiftlet::tools::Failure& failure) {
    return exit_with(failure.status, failure.line);
  } catch (const std::exception& error) {
    return exit_with(ExitStatus::kInternal, std::string("internal error, please report: ") + error.what());
  }
}
