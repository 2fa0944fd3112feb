#include <array>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "board_config.hpp"
#include "cli/case_file.hpp"
#include "cli/commands.hpp"
#include "cli/output.hpp"
#include "cli/plan_document.hpp"
#include "cli/progress_line.hpp"
#include "cli/stopwatch.hpp"
#include "swiftlet/certificate.hpp"
#include "swiftlet/trajectory_generator.hpp"

namespace swiftlet::tools {
namespace {

struct SolveOptions {
  std::string one;
  std::string json;
  std::string many;
  std::string jsonl;
};

/// Memory of the generator, as large as this board's.
struct Memory {
  TrajectoryStorage<kBoard.segments> trajectory;
  std::array<Segment, kBoard.segments> segments;
  std::array<Real, kBoard.segments> durations;
};
Memory memory;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables): large, so not on the stack

CertificateRequest certificate_request(const TrajectoryCase& problem) {
  constexpr Real kUnlimited = std::numeric_limits<Real>::infinity();
  return {.boxes = problem.boxes,
          .gates = problem.gates,
          .start = problem.start,
          .goal = problem.goal,
          .v_max = Vector3::Constant(problem.v_max),
          .a_max = Vector3::Constant(problem.a_max),
          .speed_max = kUnlimited,
          .acceleration_norm_max = kUnlimited};
}

std::string describe_blocking(const Blocking& blocking) {
  static constexpr std::array<const char*, 3> kBounds{"position", "velocity", "acceleration"};
  return std::string("no trajectory exists for these durations: the ") +
         kBounds[static_cast<std::size_t>(blocking.bound)] + " bound of box " + std::to_string(blocking.box) +
         " on axis " + "xyz"[blocking.axis] + " cannot be met" +
         (blocking.stretch > 0 ? "; longer durations would do" : "");
}

/// For a case that the default effort leaves unanswered: ten times the steps, and bounds to half of what is promised.
constexpr SolveEffort kSecondEffort{.tolerance = 5e-7, .steps_per_segment = 100};

bool is_answered(Status status) { return status != Status::kIterationLimit && status != Status::kNumericalTrouble; }

/// Rest to rest from gate to gate, straight, each leg in the duration given.
void stop_at_gates_on_time(const TrajectoryCase& problem, std::span<Segment> segments) {
  constexpr std::array<double, kQuinticTerms> kRestToRest{0, 0, 0, 10, -15, 6};
  Vector3 from = problem.start.position;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const bool last = i + 1 == segments.size();
    const Vector3 to = last ? problem.goal.position : from.cwiseMax(problem.gates[i].lo).cwiseMin(problem.gates[i].hi);
    segments[i].duration = problem.durations[i];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto row = static_cast<Eigen::Index>(axis);
      double power = 1;
      for (std::size_t j = 0; j < kQuinticTerms; ++j, power *= problem.durations[i]) {
        segments[i].coefficients[axis][j] = kRestToRest[j] * (to[row] - from[row]) / power;
      }
      segments[i].coefficients[axis][0] = from[row];
    }
    from = to;
  }
}

/// Solves and certifies: kOk, or why not.
Status solve_certified(const TrajectoryCase& problem, const TrajectoryProblem& posed, std::span<Segment> segments,
                       CaseAnswer& answer) {
  const Status status = generate_trajectory(posed, memory.trajectory.spans(), segments, answer.report);
  if (status != Status::kOk) return status;
  answer.certificate = certify(segments, certificate_request(problem));
  return answer.certificate.pass ? Status::kOk : Status::kNumericalTrouble;
}

/// The default effort, then the second one, then stopping at every gate where the durations leave time for it.
Status solve_or_stop(const TrajectoryCase& problem, TrajectoryProblem posed, std::span<Segment> segments,
                     CaseAnswer& answer) {
  Status status = solve_certified(problem, posed, segments, answer);
  if (is_answered(status)) return status;
  posed.effort = kSecondEffort;
  status = solve_certified(problem, posed, segments, answer);
  if (is_answered(status)) return status;
  stop_at_gates_on_time(problem, segments);
  answer.certificate = certify(segments, certificate_request(problem));
  if (!answer.certificate.pass) return status;
  answer.report.fallback_reason =
      status == Status::kIterationLimit ? FallbackReason::kIterations : FallbackReason::kNumerics;
  return Status::kFallback;
}

/// The answer's segments lie in `memory` until the next call.
CaseAnswer solve_case(const TrajectoryCase& problem) {
  CaseAnswer answer;
  answer.reason = problem.defect;
  if (!answer.reason.empty()) return answer;
  const std::size_t count = problem.boxes.size();
  if (count > kBoard.segments) {
    answer.status = Status::kCorridorCapacity;
    answer.reason = std::to_string(count) + " boxes; this board holds " + std::to_string(kBoard.segments);
    return answer;
  }
  const TrajectoryProblem posed{.boxes = problem.boxes,
                                .gates = problem.gates,
                                .durations = problem.durations,
                                .start = problem.start,
                                .goal = problem.goal,
                                .v_max = Vector3::Constant(problem.v_max),
                                .a_max = Vector3::Constant(problem.a_max),
                                .margins = problem.margins};
  const std::span<Segment> segments(memory.segments.data(), count);
  const Stopwatch stopwatch;
  answer.status = solve_or_stop(problem, posed, segments, answer);
  if (answer.status == Status::kOk || answer.status == Status::kFallback) answer.segments = segments;
  answer.time_us = stopwatch.microseconds();
  if (answer.status == Status::kInfeasible) {
    answer.report.blocking.stretch = smallest_stretch(posed, memory.trajectory.spans(), segments, memory.durations);
    answer.reason = describe_blocking(answer.report.blocking);
  }
  if (answer.status == Status::kBadRequest) answer.reason = "a number is not finite or out of range";
  return answer;
}

std::string describe_unanswered(const TrajectoryCase& problem, const CaseAnswer& answer) {
  return "internal error, please report: case '" + problem.name.value_or("without a name") +
         "': " + describe(answer.status);
}

ExitStatus solve_one(const SolveOptions& options) {
  check_outputs({options.json}, {options.one});
  const TrajectoryCase problem = load_case(options.one);
  const CaseAnswer answer = solve_case(problem);
  if (!is_answered(answer.status)) throw Failure{ExitStatus::kInternal, describe_unanswered(problem, answer)};
  write_output(options.json, dump(case_document(problem, answer)) + '\n');
  if (!answer.segments.empty()) return ExitStatus::kDone;
  throw Failure{ExitStatus::kNoAnswer, std::string(describe(answer.status)) + ": " + answer.reason};
}

ExitStatus solve_many(const SolveOptions& options) {
  check_outputs({options.jsonl}, {options.many});
  const std::vector<TrajectoryCase> problems = load_cases(options.many);
  LineOutput output(options.jsonl);
  ProgressLine line(options.jsonl != kStandardOutput);
  std::size_t solved = 0;
  std::string unanswered;  // the first such case
  for (const TrajectoryCase& problem : problems) {
    const CaseAnswer answer = solve_case(problem);
    if (!is_answered(answer.status) && unanswered.empty()) unanswered = describe_unanswered(problem, answer);
    output.write_line(dump(case_document(problem, answer)));
    line.show("solve", static_cast<double>(++solved) / static_cast<double>(problems.size()));
  }
  output.close();
  if (!unanswered.empty()) throw Failure{ExitStatus::kInternal, unanswered};
  return ExitStatus::kDone;
}

}  // namespace

void add_solve_command(CLI::App& app, Command& chosen) {
  CLI::App* command =
      add_subcommand(app, "solve", "Generate the minimum-jerk trajectory of given boxes, gates and durations");
  const auto options = std::make_shared<SolveOptions>();
  CLI::Option* one = command->add_option("case", options->one, "swiftlet-case/1 file");
  CLI::Option* json = command->add_option("--json", options->json, "swiftlet-plan/1 to write; - is standard output");
  CLI::Option* many = command->add_option("--cases", options->many, "One swiftlet-case/1 a line");
  CLI::Option* jsonl = command->add_option("--jsonl", options->jsonl, "One answer a line; - is standard output");
  one->excludes(many)->excludes(jsonl);
  json->needs(one);
  many->needs(jsonl);
  jsonl->needs(many);
  command->callback([options, &chosen] {
    if (options->one.empty() && options->many.empty()) throw CLI::RequiredError("solve: CASE.json or --cases");
    chosen = [options] { return options->many.empty() ? solve_one(*options) : solve_many(*options); };
  });
}

}  // namespace swiftlet::tools
