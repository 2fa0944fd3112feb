#include <array>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "board_config.hpp"
#include "cli/arguments.hpp"
#include "cli/commands.hpp"
#include "cli/map_file.hpp"
#include "cli/output.hpp"
#include "cli/plan_document.hpp"
#include "cli/planner_memory.hpp"
#include "cli/progress_line.hpp"
#include "cli/query_file.hpp"
#include "cli/stopwatch.hpp"
#include "cli/text.hpp"
#include "cli/vehicle_file.hpp"
#include "report/plan_report.hpp"
#include "swiftlet/planner.hpp"

namespace swiftlet::tools {
namespace {

constexpr std::uint64_t kNotGiven = std::numeric_limits<std::uint64_t>::max();

struct PlanOptions {
  std::string map;
  PlanRequest request;
  std::string norm = "axis";
  std::string corridor = "extents";
  std::string relax = "on";
  std::string search = "default";
  std::string vehicle;
  std::uint64_t refine_us = kNotGiven;
  std::uint64_t deadline_us = kNotGiven;
  std::string queries;
  std::string json;
  std::string csv;
  std::string report;
  std::string jsonl;
};

struct TimedPlan {
  const Plan* plan;
  PlanTimes times;
  std::string reason;  ///< why there is no trajectory, for people; empty when there is one
};

std::string describe_blocking(const Blocking& blocking) {
  const std::string where = "corridor box " + std::to_string(blocking.box) + " on axis " + "xyz"[blocking.axis];
  std::array<char, 32> missing{};
  std::snprintf(missing.data(), missing.size(), "%.3g", blocking.missing);
  switch (blocking.bound) {
    case BoundKind::kPosition:
      return std::string("the room in ") + where + " is " + missing.data() +
             " m too short for this motion; raise --amax or slow down first";
    case BoundKind::kVelocity:
      return std::string("the speed in ") + where + " is " + missing.data() +
             " m/s beyond its limit; raise --vmax or slow down first";
    default:
      return std::string("the acceleration in ") + where + " is " + missing.data() +
             " m/s^2 beyond its limit; raise --amax or fly more gently first";
  }
}

std::string explain(const MapFile& map, Obstacles& obstacles, const PlanRequest& request, const Plan& plan) {
  switch (plan.status) {
    case Status::kOk:
    case Status::kFallback:
      return {};
    case Status::kStartNotFree:
      return explain_not_free(map, obstacles, "start", request.start.position);
    case Status::kGoalNotFree:
      return explain_not_free(map, obstacles, "goal", request.goal.position);
    case Status::kNoPath:
      return explain_no_path(map, plan.start.position, plan.goal.position);
    case Status::kSearchCapacity:
      return "the search used up its " + std::to_string(kBoard.search_nodes) +
             " nodes; a coarser map or a larger --search-weight needs fewer";
    case Status::kCorridorCapacity:
      return "the corridor has more than " + std::to_string(kBoard.segments) + " boxes; a coarser map has fewer";
    case Status::kInfeasible:
      return describe_blocking(plan.trajectory.blocking);
    default:
      return "the request holds a number that is not finite or out of range";
  }
}

/// Statuses that no valid map and no request can lead to.
void check_answered(const MapFile& map, const Plan& plan) {
  if (plan.status == Status::kBlobInconsistent) {
    throw Failure{ExitStatus::kBadFile, map.path + ": " + describe(plan.status) + "; build it again"};
  }
  if (plan.status == Status::kNumericalTrouble || plan.status == Status::kIterationLimit) {
    throw Failure{ExitStatus::kInternal, std::string("internal error, please report: ") + describe(plan.status)};
  }
}

TimedPlan run_planner(const MapFile& map, Obstacles& obstacles, const PlanRequest& request) {
  static Planner planner(planner_memory());
  TimedPlan timed{&planner.result(), {}, {}};
  const Stopwatch stopwatch;
  const bool found = planner.find_corridor(map.graph, request) == Status::kOk;
  timed.times.search = stopwatch.microseconds();
  if (found) {
    (void)planner.fit_trajectory(request);
    timed.times.trajectory = stopwatch.microseconds() - timed.times.search;
  }
  timed.times.total = stopwatch.microseconds();
  check_answered(map, *timed.plan);
  timed.reason = explain(map, obstacles, request, *timed.plan);
  return timed;
}

std::string milliseconds(double microseconds) { return to_text(microseconds / 1000, 3) + " ms"; }

/// The short table for people.
void print_summary(const TimedPlan& timed, const PlanRequest& request) {
  const Plan& plan = *timed.plan;
  const Certificate& proof = plan.certificate;
  const auto row = [](const char* name, const std::string& value) {
    std::fprintf(stderr, "%-12s %s\n", name, value.c_str());
  };
  row("status", describe(plan.status));
  const auto moved = [&](const char* name, const State& from, const State& to) {
    const double distance = (to.position - from.position).norm();
    if (distance > 0) row(name, "moved " + to_text(distance, 3) + " m to (" + to_text(to.position) + ")");
  };
  moved("start", request.start, plan.start);
  moved("goal", request.goal, plan.goal);
  row("corridor", std::to_string(plan.boxes.size()) + " boxes");
  row("length", to_text(arc_length(plan.segments), 2) + " m");
  row("duration", to_text(total_duration(plan.segments), 2) + " s");
  row("search", milliseconds(timed.times.search) + ", " + std::to_string(plan.search.expanded) + " windows expanded");
  row("trajectory",
      milliseconds(*timed.times.trajectory) + ", " + std::to_string(plan.trajectory.qp_iterations) + " QP iterations");
  row("certificate", "passes: speed " + to_text(proof.max_speed.maxCoeff(), 3) + " m/s, acceleration " +
                         to_text(proof.max_acceleration.maxCoeff(), 3) + " m/s^2 on the fastest axis");
}

std::string report_page(const MapFile& map, Obstacles& obstacles, const PlanRequest& request, const Json& document) {
  const GridBoxes boxes{map.graph.header().origin, map.graph.unit(), map.graph.header().resolution, obstacles.boxes()};
  const std::string title = std::filesystem::path(map.path).stem().string() + ": " + to_text(request.start.position) +
                            " to " + to_text(request.goal.position);
  return plan_report_html({document, boxes, title});
}

ExitStatus plan_one(const PlanOptions& options) {
  check_outputs({options.json, options.csv, options.report}, {options.map, options.vehicle});
  const MapFile map = load_map(options.map);
  Obstacles obstacles(map);
  const TimedPlan timed = run_planner(map, obstacles, options.request);
  const Json document = plan_document(map, options.request, *timed.plan, timed.times, timed.reason);
  write_output(options.json, dump(document) + '\n');
  if (!options.report.empty()) write_output(options.report, report_page(map, obstacles, options.request, document));
  if (!timed.reason.empty()) {
    throw Failure{ExitStatus::kNoAnswer, std::string(describe(timed.plan->status)) + ": " + timed.reason};
  }
  if (!options.csv.empty()) write_output(options.csv, trajectory_csv(timed.plan->segments));
  print_summary(timed, options.request);
  return ExitStatus::kDone;
}

ExitStatus plan_many(const PlanOptions& options) {
  check_outputs({options.jsonl}, {options.map, options.queries, options.vehicle});
  const std::vector<Query> queries = load_queries(options.queries);
  const MapFile map = load_map(options.map);
  Obstacles obstacles(map);
  LineOutput output(options.jsonl);
  ProgressLine line(options.jsonl != kStandardOutput);
  std::size_t answered = 0;
  for (const Query& query : queries) {
    PlanRequest request = options.request;
    request.start.position = query.start;
    request.goal.position = query.goal;
    const TimedPlan timed = run_planner(map, obstacles, request);
    output.write_line(dump(plan_document(map, request, *timed.plan, timed.times, timed.reason)));
    line.show("plan", static_cast<double>(++answered) / static_cast<double>(queries.size()));
  }
  output.close();
  return ExitStatus::kDone;
}

constexpr std::uint64_t kLongestBudget = 1'000'000'000;  // [us]

/// Budgets are counts of work inside the core: the same numbers give the same plan, whatever the machine's load.
std::uint64_t to_work(std::uint64_t microseconds) {
  return static_cast<std::uint64_t>(static_cast<double>(microseconds) * kWorkPerMicrosecond);
}

void apply_choices(PlanOptions& options) {
  options.request.norm = options.norm == "axis" ? LimitNorm::kAxis : LimitNorm::kEuclidean;
  options.request.corridor = options.corridor == "extents" ? CorridorKind::kExtents : CorridorKind::kCells;
  options.request.relax = options.relax == "on";
  if (options.refine_us != kNotGiven) options.request.budget.refinement = to_work(options.refine_us);
  if (options.deadline_us != kNotGiven) options.request.budget.deadline = to_work(options.deadline_us);
  options.request.search.mode = options.search == "plain"       ? SearchMode::kPlain
                                : options.search == "landmarks" ? SearchMode::kLandmarks
                                                                : SearchMode::kDefault;
}

void add_planning_options(CLI::App& command, PlanOptions& options) {
  const NumberRange limits{kLeastLimit, kLargestLimit};
  PlanRequest& request = options.request;
  add_number(command, "--vmax", request.v_max, limits, "Speed limit [m/s]")->required();
  add_number(command, "--amax", request.a_max, limits, "Acceleration limit [m/s^2]")->required();
  add_choice(command, "--norm", options.norm, {"axis", "euclidean"}, "What the limits bound");
  add_vector(command, "--start-velocity", request.start.velocity, "Velocity at the start [m/s]");
  add_vector(command, "--start-acceleration", request.start.acceleration, "Acceleration at the start [m/s^2]");
  add_number(command, "--jmax", request.j_max, limits, "Jerk limit [m/s^3]");
  command.add_option("--vehicle", options.vehicle, "swiftlet-vehicle/1 file: thrust and body rates to keep");
  add_choice(command, "--corridor", options.corridor, {"extents", "cells"}, "Large boxes, or the paper's cells");
  add_choice(command, "--relax", options.relax, {"on", "off"}, "Relax windows of a corridor of cells");
  add_choice(command, "--search", options.search, {"default", "landmarks", "plain"}, "Graph and heuristic");
  add_number(command, "--search-weight", request.search.weight, {1, 1e6}, "Trade path length for search time");
  add_number(command, "--snap", request.snap_distance, {0, 1e6}, "Move an end that is not free so far at most [m]");
  add_count(command, "--refine-us", options.refine_us, 0, kLongestBudget,
            "Work spent on refining the times [us]; 0 leaves that out");
  add_count(command, "--deadline-us", options.deadline_us, 0, kLongestBudget,
            "Work after which the best answer so far is taken [us]");
}

}  // namespace

void add_plan_command(CLI::App& app, Command& chosen) {
  CLI::App* command = add_subcommand(app, "plan", "Plan certified trajectories on a map");
  const auto options = std::make_shared<PlanOptions>();
  command->add_option("map", options->map, "Map made by 'swiftlet map build'")->required();
  CLI::Option* start = add_vector(*command, "--start", options->request.start.position, "Start position [m]");
  CLI::Option* goal = add_vector(*command, "--goal", options->request.goal.position, "Goal position [m]");
  add_planning_options(*command, *options);
  CLI::Option* json = command->add_option("--json", options->json, "swiftlet-plan/1 to write; - is standard output");
  CLI::Option* csv = command->add_option("--csv", options->csv, "Trajectory at 100 Hz to write; - is standard output");
  CLI::Option* report = command->add_option("--report", options->report,
                                            "Page with the plan in 3-D to write (.html); - is standard output");
  CLI::Option* queries = command->add_option("--queries", options->queries, "CSV with columns x0,y0,z0,x1,y1,z1");
  CLI::Option* jsonl = command->add_option("--jsonl", options->jsonl, "One plan a line; - is standard output");
  start->needs(goal);
  goal->needs(start);
  queries->needs(jsonl);
  jsonl->needs(queries);
  for (CLI::Option* single : {start, goal, json, csv, report}) single->excludes(queries);
  command->callback([options, start, &chosen] {
    if (start->count() == 0 && options->queries.empty()) throw CLI::RequiredError("--start and --goal, or --queries");
    apply_choices(*options);
    chosen = [options] {
      if (!options->vehicle.empty()) {
        const VehicleModel model = load_vehicle(options->vehicle).model;
        options->request.vehicle = Vehicle{model.mass, model.thrust_min, model.thrust_max, model.rate_max};
      }
      return options->queries.empty() ? plan_one(*options) : plan_many(*options);
    };
  });
}

}  // namespace swiftlet::tools
