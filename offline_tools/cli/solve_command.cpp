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
  const TrajectorySpans spans = memory.trajectory.spans();
  const Stopwatch stopwatch;
  answer.status = generate_trajectory(posed, spans, segments, answer.report);
  if (answer.status == Status::kOk) {
    answer.segments = segments;
    answer.certificate = certify(segments, certificate_request(problem));
    if (!answer.certificate.pass) answer.status = Status::kNumericalTrouble;
  }
  answer.time_us = stopwatch.microseconds();
  if (answer.status == Status::kInfeasible) {
    answer.report.blocking.stretch = smallest_stretch(posed, spans, segments, memory.durations);
    answer.reason = describe_blocking(answer.report.blocking);
  }
  if (answer.status == Status::kBadRequest) answer.reason = "a number is not finite or out of range";
  return answer;
}

/// The contract knows three answers to a case; anything else is a defect of ours.
void check_answered(const TrajectoryCase& problem, const CaseAnswer& answer) {
  if (answer.status != Status::kIterationLimit && answer.status != Status::kNumericalTrouble) return;
  throw Failure{ExitStatus::kInternal, "internal error, please report: case '" +
                                           problem.name.value_or("without a name") + "': " + describe(answer.status)};
}

ExitStatus solve_one(const SolveOptions& options) {
  check_outputs({options.json}, {options.one});
  const TrajectoryCase problem = load_case(options.one);
  const CaseAnswer answer = solve_case(problem);
  check_answered(problem, answer);
  write_output(options.json, dump(case_document(problem, answer)) + '\n');
  if (answer.status == Status::kOk) return ExitStatus::kDone;
  throw Failure{ExitStatus::kNoAnswer, std::string(describe(answer.status)) + ": " + answer.reason};
}

ExitStatus solve_many(const SolveOptions& options) {
  check_outputs({options.jsonl}, {options.many});
  const std::vector<TrajectoryCase> problems = load_cases(options.many);
  LineOutput output(options.jsonl);
  for (const TrajectoryCase& problem : problems) {
    const CaseAnswer answer = solve_case(problem);
    check_answered(problem, answer);
    output.write_line(dump(case_document(problem, answer)));
  }
  output.close();
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
