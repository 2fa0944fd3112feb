#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "board_config.hpp"
#include "cli/arguments.hpp"
#include "cli/commands.hpp"
#include "cli/config_file.hpp"
#include "cli/flight_document.hpp"
#include "cli/map_file.hpp"
#include "cli/output.hpp"
#include "cli/planner_memory.hpp"
#include "cli/text.hpp"
#include "cli/vehicle_file.hpp"
#include "flight/memory_storage.hpp"
#include "map/file_io.hpp"
#include "report/flight_report.hpp"
#include "swiftlet/version.hpp"

namespace swiftlet::tools {
namespace {

constexpr NumberRange kLimits{kLeastLimit, kLargestLimit};
constexpr NumberRange kYaws{-7, 7};          // [rad]
constexpr NumberRange kGusts{0, 100};        // [m/s]
constexpr NumberRange kDelays{0, 10};        // [s]
constexpr NumberRange kHeadingNoises{0, 1};  // [rad]
constexpr double kLargestCoordinate = 1e6;   // [m]
constexpr double kStrongestWind = 100;       // [m/s]
constexpr std::uint64_t kLargestSeed = std::numeric_limits<std::uint64_t>::max() / 16;

struct FlyOptions {
  std::string map;
  FlightRequest flight;
  std::string setpoint;
  double v_max = 0;  // 0: as configured
  double a_max = 0;
  double j_max = 0;
  double link_delay = 0;
  std::string vehicle;
  std::string config;
  std::string json;
  std::string report;
  std::string log;
};

companion::CompanionStorage<kBoard>
    companion_storage;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables): too large for a stack

double finite(const std::string& name, std::string_view text, double largest) {
  const std::optional<double> number = parse_number(text);
  if (!number || !std::isfinite(*number)) {
    throw CLI::ValidationError(name, "'" + std::string(text) + "' is not a finite number");
  }
  if (std::abs(*number) > largest) throw CLI::ValidationError(name, "'" + std::string(text) + "' is out of range");
  return *number;
}

Vector3 parse_goal(const std::string& text) {
  const std::vector<std::string_view> pieces = split_at_commas(text);
  if (pieces.size() != 3) throw CLI::ValidationError("--goal", "'" + text + "' is not three numbers X,Y,Z");
  return {finite("--goal", pieces[0], kLargestCoordinate), finite("--goal", pieces[1], kLargestCoordinate),
          finite("--goal", pieces[2], kLargestCoordinate)};
}

/// "X,Y,Z", or the speed of a wind towards the east.
Vector3 parse_wind(const std::string& text) {
  const std::vector<std::string_view> pieces = split_at_commas(text);
  if (pieces.size() != 1 && pieces.size() != 3) {
    throw CLI::ValidationError("--wind", "'" + text + "' is neither a speed nor three numbers X,Y,Z");
  }
  Vector3 wind = Vector3::Zero();
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    wind[static_cast<Eigen::Index>(i)] = finite("--wind", pieces[i], kStrongestWind);
  }
  return wind;
}

FlightFault parse_fault_option(const std::string& text) {
  const std::optional<FlightFault> fault = parse_flight_fault(text);
  if (!fault) {
    throw CLI::ValidationError("--fault", "'" + text + "' is no fault: KIND@T or KIND@T+D, in seconds");
  }
  return *fault;
}

SetpointForm form_of(const std::string& word) {
  return word == "position" ? SetpointForm::kPosition
         : word == "rates"  ? SetpointForm::kRates
                            : SetpointForm::kAttitude;
}

/// The simulated vehicle may be as large as the map's radius leaves room for beside the tracking tube; a map of a
/// smaller radius than that tube is flown with a smaller one.
void fit_margins(companion::Settings& settings, double map_radius) {
  companion::Margins& margins = settings.margins;
  margins.map_error = 0;  // the simulated world is the map
  const double room = map_radius - margins.numeric_margin;
  for (Real* tube : {&margins.tubes.position, &margins.tubes.attitude, &margins.tubes.rates}) {
    *tube = std::min(*tube, room);
  }
  margins.vehicle_radius = std::max(room - tube_of(margins.tubes, settings.form), 0.0);
}

void apply_vehicle(FlyOptions& options) {
  if (options.vehicle.empty()) return;
  const VehicleFile file = load_vehicle(options.vehicle);
  const VehicleModel& model = file.model;
  FlightRequest& flight = options.flight;
  flight.sim.simulation.vehicle = model;
  flight.sim.simulation.hover_thrust = file.hover_thrust;
  flight.companion.limits.vehicle = Vehicle{model.mass, model.thrust_min, model.thrust_max, model.rate_max};
  for (ControllerSettings* control : {&flight.companion.control.attitude, &flight.companion.control.rates}) {
    control->mass = model.mass;
  }
}

void apply_options(FlyOptions& options, const MapFile& map) {
  companion::Settings& settings = options.flight.companion;
  if (!options.config.empty()) settings = load_config(options.config);
  if (!options.setpoint.empty()) settings.form = form_of(options.setpoint);
  if (options.v_max > 0) settings.limits.v_max = options.v_max;
  if (options.a_max > 0) settings.limits.a_max = options.a_max;
  if (options.j_max > 0) settings.limits.j_max = options.j_max;
  options.flight.sim.link_delay = std::chrono::round<Microseconds>(std::chrono::duration<double>(options.link_delay));
  apply_vehicle(options);
  if (options.config.empty()) fit_margins(settings, map.graph.header().radius);
  if (const char* fault = companion::find_fault(settings)) {
    throw Failure{ExitStatus::kUsage, std::string("the flight's settings cannot be: ") + fault};
  }
}

/// A way must lead from goal to goal; the flight plans anew from where it is. Throws Failure for one that does not
/// exist, after writing a report.
void check_goals(const FlyOptions& options, const MapFile& map, Obstacles& obstacles) {
  const FlightRequest& flight = options.flight;
  FlightPlanner planner(planner_memory(), FlightPlanner::Kind::kInline);
  Vector3 from = flight.start;
  for (std::size_t i = 0; i < flight.goals.size(); ++i) {
    companion::PlanJob job{map.graph, {}};
    job.request.start.position = from;
    job.request.goal.position = flight.goals[i];
    job.request.v_max = flight.companion.limits.v_max;
    job.request.a_max = flight.companion.limits.a_max;
    job.request.j_max = flight.companion.limits.j_max;
    job.request.norm = flight.companion.limits.norm;
    job.request.vehicle = flight.companion.limits.vehicle;
    planner.start(job);
    while (!planner.done()) continue;
    const Plan& plan = planner.result();
    if (plan.status == Status::kOk || plan.status == Status::kFallback) {
      from = flight.goals[i];
      continue;
    }
    const std::string name = "goal " + std::to_string(i + 1);
    std::string reason = describe(plan.status);
    if (plan.status == Status::kStartNotFree) reason = explain_not_free(map, obstacles, "start", from);
    if (plan.status == Status::kGoalNotFree) reason = explain_not_free(map, obstacles, name, flight.goals[i]);
    if (const std::size_t advice = reason.find(", or --snap"); advice != std::string::npos) reason.resize(advice);
    if (plan.status == Status::kNoPath) reason = explain_no_path(map, from, flight.goals[i]);
    FlightReport report;
    report.status = describe(plan.status);
    report.reason = reason;
    report.tracking_rms = report.tracking_max = report.clearance = std::numeric_limits<double>::quiet_NaN();
    const Json document =
        flight_document(map, flight, report, planner.plans(), plan_document(map, planner.plans().back()));
    write_output(options.json, dump(document) + '\n');
    throw Failure{ExitStatus::kNoAnswer, std::string(describe(plan.status)) + ": " + reason};
  }
}

/// The first plan that was flown, else the first that was made.
const FlownPlan* first_plan(const std::deque<FlownPlan>& plans) {
  const auto flown = std::find_if(plans.begin(), plans.end(), [](const FlownPlan& plan) { return plan.id > 0; });
  if (flown != plans.end()) return &*flown;
  return plans.empty() ? nullptr : &plans.front();
}

/// Numbers that do not exist are not finite.
std::string measured(double value, int decimals, const std::string& unit) {
  return std::isfinite(value) ? to_text(value, decimals) + unit : std::string("-");
}

void print_summary(const FlightReport& report, const FlightRequest& request, const std::deque<FlownPlan>& plans) {
  const auto row = [](const char* name, const std::string& value) {
    std::fprintf(stderr, "%-12s %s\n", name, value.c_str());
  };
  const auto percent = [](double share) { return to_text(100 * share, 1) + " %"; };
  row("status", report.status + (report.reason.empty() ? "" : " (" + report.reason + ")") + ", " +
                    describe(report.state) + (report.landed ? ", landed" : ""));
  row("goals", std::to_string(report.goals_reached) + " of " + std::to_string(request.goals.size()) + " reached");
  row("duration", to_text(report.duration, 2) + " s");
  row("tracking",
      measured(report.tracking_rms, 3, " m") + " RMS, " + measured(report.tracking_max, 3, " m") + " at most");
  row("clearance", measured(report.clearance, 3, " m") + " from the vehicle's centre");
  double slowest = 0;
  std::size_t committed = 0;
  for (const FlownPlan& plan : plans) {
    slowest = std::max(slowest, plan.total_us);
    committed += plan.id > 0 ? 1 : 0;
  }
  row("plans", std::to_string(committed) + " flown of " + std::to_string(plans.size()) + ", the slowest in " +
                   to_text(slowest / 1000, 3) + " ms");
  row("set-points", std::to_string(report.setpoints.count) + ", every " +
                        measured(1000 * report.setpoints.interval_p50, 2, " ms") + ", jitter " +
                        measured(1000 * report.setpoints.jitter_p99, 2, " ms") + " (99 %)");
  row("link", percent(report.load_in) + " of the line in, " + percent(report.load_out) + " out, " +
                  std::to_string(report.codec.bad_checksum) + " damaged frames");
  for (const FaultAnswer& answer : report.answers) {
    row("fault", answer.fault + " at " + to_text(answer.at, 2) + " s: " +
                     (answer.after ? answer.what + " after " + to_text(*answer.after, 3) + " s" : "flown through"));
  }
}

std::string page_title(const FlyOptions& options, const FlightReport& report) {
  const std::vector<Vector3>& goals = options.flight.goals;
  std::string title = std::filesystem::path(options.map).stem().string() + ": flight to " + to_text(goals.back());
  if (goals.size() == 2) title += " by way of a goal";
  if (goals.size() > 2) title += " by way of " + std::to_string(goals.size() - 1) + " goals";
  std::string outcome = report.status;
  std::replace(outcome.begin(), outcome.end(), '_', ' ');
  return title + ": " + outcome + (report.landed ? ", landed" : "");
}

void write_page(const FlyOptions& options, const MapFile& map, Obstacles& obstacles, FlightReport& report,
                const Json& document) {
  if (options.report.empty()) return;
  const BlobHeader& header = map.graph.header();
  report.record.obstacles = {header.origin, map.graph.unit(), header.resolution, obstacles.boxes()};
  write_output(options.report, flight_report_html({document, report.record, page_title(options, report)}));
}

/// The flight's log in memory, where one is asked for, or a fault fills it.
class Recorder {
 public:
  Recorder(const FlyOptions& options, const MapFile& map, const std::vector<Box>& boxes) {
    const auto fills = [](const FlightFault& fault) {
      const auto* own = std::get_if<CompanionFault>(&fault);
      return own != nullptr && own->kind == CompanionFaultKind::kStorageFull;
    };
    const FlightRequest& flight = options.flight;
    wanted_ = !options.log.empty() || std::any_of(flight.faults.begin(), flight.faults.end(), fills);
    if (!wanted_) return;
    const std::string settings = config_text(settings_of(flight, map.graph, boxes));
    const std::string file = absolute_path(map.path);
    (void)log_.begin("flight.ulg", 0, {kVersion, "simulated flight", settings, map.graph.header().crc32, file});
  }

  companion::FlightLog* log() { return wanted_ ? &log_ : nullptr; }
  FillableStorage* storage() { return &storage_; }
  /// Its bytes, when the flight is over.
  std::string_view end() {
    log_.end();
    return {reinterpret_cast<const char*>(memory_.bytes().data()), memory_.bytes().size()};
  }

 private:
  MemoryStorage memory_;
  FillableStorage storage_{memory_};
  companion::FlightLog log_{storage_};
  bool wanted_ = false;
};

ExitStatus run_fly(FlyOptions& options) {
  check_outputs({options.json, options.report, options.log}, {options.map, options.vehicle, options.config});
  const MapFile map = load_map(options.map);
  Obstacles obstacles(map);
  apply_options(options, map);
  check_goals(options, map, obstacles);

  const FlightRequest& flight = options.flight;
  FlightPlanner planner(planner_memory(),
                        flight.in_process ? FlightPlanner::Kind::kInline : FlightPlanner::Kind::kThread);
  const std::vector<Box> boxes = unwrap(occupied_boxes(map.graph));
  Recorder recorder(options, map, boxes);
  const FlightWorld world{map.graph, boxes, companion_storage.memory(), planner, recorder.log(), recorder.storage()};
  FlightReport report = unwrap(fly(flight, world));
  write_output(options.log, recorder.end());
  const FlownPlan* plan = first_plan(planner.plans());
  const Json document = flight_document(map, flight, report, planner.plans(),
                                        plan != nullptr ? plan_document(map, *plan) : Json(nullptr));
  write_output(options.json, dump(document) + '\n');
  write_page(options, map, obstacles, report, document);
  print_summary(report, flight, planner.plans());
  if (report.status == "arrived") return ExitStatus::kDone;
  throw Failure{ExitStatus::kNoAnswer, report.status + ": " + report.reason};
}

template <typename T>
void add_list(CLI::App& command, const std::string& name, std::vector<T>& list, T (*parse)(const std::string&),
              const std::string& type, const std::string& description, bool required = false) {
  const auto take = [&list, parse](const std::vector<std::string>& texts) {
    for (const std::string& text : texts) list.push_back(parse(text));
  };
  command.add_option_function<std::vector<std::string>>(name, take, description)
      ->type_name(type)
      ->allow_extra_args(false)
      ->required(required);
}

void add_disturbances(CLI::App& command, FlyOptions& options) {
  SimulationSettings& simulation = options.flight.sim.simulation;
  command
      .add_option_function<std::string>(
          "--wind", [&simulation](const std::string& text) { simulation.wind.mean = parse_wind(text); },
          "Mean wind [m/s], or its speed towards the east")
      ->type_name("X,Y,Z");
  add_number(command, "--gust", simulation.wind.gust, kGusts, "Speed that gusts reach [m/s]");
  add_number(command, "--heading-noise", simulation.estimator.attitude_sigma.z(), kHeadingNoises,
             "Error of the autopilot's heading [rad]; what it is off while the frames are aligned, stays");
  add_number(command, "--link-delay", options.link_delay, kDelays, "Delay of the link, each way [s]");
  add_list<FlightFault>(command, "--fault", options.flight.faults, parse_fault_option, "KIND@T[+D]",
                        "Something goes wrong; any number of them");
  add_count(command, "--seed", simulation.seed, 0, kLargestSeed, "Of all disturbances");
  command.footer("Faults, at T seconds, for D seconds:\n" + list_flight_faults());
}

}  // namespace

void add_fly_command(CLI::App& app, Command& chosen) {
  CLI::App* command = add_subcommand(app, "fly", "Fly the companion against a simulated vehicle and autopilot");
  const auto options = std::make_shared<FlyOptions>();
  FlightRequest& flight = options->flight;
  command->add_option("map", options->map, "Map made by 'swiftlet map build'")->required();
  add_vector(*command, "--start", flight.start, "Where the take-off ends [m]")->required();
  add_list<Vector3>(*command, "--goal", flight.goals, parse_goal, "X,Y,Z", "To fly to [m]; any number, in order", true);
  add_number(*command, "--yaw", flight.yaw, kYaws, "Heading at the start, from east [rad]");
  command->add_option("--setpoint", options->setpoint, "What is sent: position, attitude or rates")
      ->check(CLI::IsMember({"position", "attitude", "rates"}));
  add_number(*command, "--vmax", options->v_max, kLimits, "Speed limit [m/s]");
  add_number(*command, "--amax", options->a_max, kLimits, "Acceleration limit [m/s^2]");
  add_number(*command, "--jmax", options->j_max, kLimits, "Jerk limit [m/s^3]");
  command->add_option("--vehicle", options->vehicle, "swiftlet-vehicle/1 file: what flies");
  command->add_option("--config", options->config, "swiftlet-config/1 file: the companion's settings");
  add_disturbances(*command, *options);
  command->add_flag("--in-process", flight.in_process, "In lock-step, faster than real time, without a device");
  command->add_option("--json", options->json, "swiftlet-flight/1 to write; - is standard output");
  command->add_option("--report", options->report, "Page that replays the flight to write (.html)");
  command->add_option("--log", options->log, "Flight log to write (.ulg)");
  flight.in_process = false;
  command->callback([options, &chosen] { chosen = [options] { return run_fly(*options); }; });
}

}  // namespace swiftlet::tools
