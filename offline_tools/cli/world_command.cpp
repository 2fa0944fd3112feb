#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>

#include "cli/arguments.hpp"
#include "cli/commands.hpp"
#include "cli/output.hpp"
#include "cli/progress_line.hpp"
#include "world/worlds.hpp"

namespace swiftlet::tools {
namespace {

constexpr std::size_t kQueryCount = 100;

struct WorldOptions {
  std::string kind;
  std::uint64_t seed = 0;
  std::uint64_t scale = 1;
  std::string out;
  std::string query;
};

World make_world(const WorldOptions& options) {
  constexpr std::array<std::uint64_t, 4> kScales{1, 2, 4, 8};
  if (std::find(kScales.begin(), kScales.end(), options.scale) == kScales.end()) {
    throw Failure{ExitStatus::kUsage, "--scale " + std::to_string(options.scale) + " is none of 1, 2, 4 and 8"};
  }
  if (options.scale != 1 && options.kind != "office") {
    throw Failure{ExitStatus::kUsage, "--scale is for the office alone; leave it out for '" + options.kind + "'"};
  }
  if (options.kind == "maze") return make_maze(options.seed);
  if (options.kind == "classroom") return make_classroom(options.seed);
  if (options.kind == "office") return make_office(options.seed, options.scale);
  if (options.kind == "forest") return make_forest(options.seed);
  throw Failure{ExitStatus::kUsage,
                "there is no world '" + options.kind + "'; maze, classroom, office and forest exist"};
}

ExitStatus run_world(const WorldOptions& options) {
  check_outputs({options.out, options.query}, {});
  ProgressLine line;
  line.show("world", 0);
  const World world = make_world(options);
  write_output(options.out, to_bt(world.grid));
  if (!options.query.empty()) {
    const auto queries =
        make_queries(world, options.seed, kQueryCount, [&](double done) { line.show("queries", done); });
    write_output(options.query, queries_csv(world, queries));
  }
  return ExitStatus::kDone;
}

}  // namespace

void add_world_command(CLI::App& app, Command& chosen) {
  CLI::App* command = add_subcommand(app, "world", "Write a generated world as an OctoMap");
  const auto options = std::make_shared<WorldOptions>();
  command->add_option("kind", options->kind, "maze, classroom, office or forest")->required();
  add_count(*command, "--seed", options->seed, 0, std::numeric_limits<std::uint64_t>::max(), "Same seed, same bytes")
      ->required();
  add_count(*command, "--scale", options->scale, 1, 8, "Office alone: area as a multiple, 1, 2, 4 or 8");
  command->add_option("-o,--out", options->out, "OctoMap to write (.bt)")->required();
  command->add_option("--query", options->query, "CSV of 100 connected start and goal pairs to write");
  command->callback([options, &chosen] { chosen = [options] { return run_world(*options); }; });
}

}  // namespace swiftlet::tools
