// `swiftlet replay`: flies a log again and compares what is sent, planned and told, bit for bit.
#include <algorithm>
#include <iterator>
#include <memory>
#include <vector>

#include "board_config.hpp"
#include "cli/commands.hpp"
#include "cli/config_file.hpp"
#include "cli/map_file.hpp"
#include "cli/output.hpp"
#include "cli/planner_memory.hpp"
#include "cli/text.hpp"
#include "flight/replay.hpp"
#include "swiftlet/version.hpp"

namespace swiftlet::tools {
namespace {

struct ReplayOptions {
  std::string log;
  std::vector<std::string> maps;
};

companion::CompanionStorage<kBoard>
    companion_storage;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables): too large for a stack

std::string seconds(TimeUs time) { return to_text(static_cast<double>(time) / 1e6, 2) + " s"; }

/// Another version may well decide otherwise.
std::string version_remark(const Ulog& log) {
  const auto version = log.texts.find("ver_sw");
  if (version == log.texts.end() || version->second == kVersion) return {};
  return " (written by version " + version->second + ", this is " + kVersion + ")";
}

MapFile load_named_map(const std::string& log, const NamedMap& named) {
  constexpr const char* kElsewhere = "; --map names another place";
  MapFile map;
  try {
    map = load_map(named.file);
  } catch (const Failure& failure) {
    throw Failure{failure.status, log + ": its map " + failure.line + kElsewhere};
  }
  if (map.graph.header().crc32 == named.crc32) return map;
  throw Failure{ExitStatus::kBadFile, log + ": its map " + named.file + " is another one by now, with the CRC-32 " +
                                          crc32_text(map.graph) + kElsewhere};
}

std::vector<MapFile> load_maps(const ReplayOptions& options, const Ulog& log) {
  std::vector<MapFile> maps;
  for (const std::string& path : options.maps) maps.push_back(load_map(path));
  if (!maps.empty()) return maps;
  for (const NamedMap& named : unwrap(named_maps(log))) maps.push_back(load_named_map(options.log, named));
  return maps;
}

ExitStatus run_replay(const ReplayOptions& options) {
  const Ulog log = unwrap(read_ulog(options.log));
  const auto settings = log.texts.find("swiftlet_settings");
  if (settings == log.texts.end()) {
    throw Failure{ExitStatus::kBadFile, options.log + ": holds no settings: it was not written by a companion"};
  }
  const std::vector<MapFile> files = load_maps(options, log);
  std::vector<BoxGraphView> maps;
  std::transform(files.begin(), files.end(), std::back_inserter(maps), [](const MapFile& file) { return file.graph; });
  const ReplayWorld world{maps, parse_config(options.log + ", its settings", settings->second),
                          companion_storage.memory(), planner_memory()};
  const ReplayReport report = unwrap(replay(log, world));
  const std::string compared = std::to_string(report.steps) + " steps, " + std::to_string(report.plans) + " plans, " +
                               std::to_string(report.messages) + " messages";
  if (report.difference) {
    throw Failure{ExitStatus::kNoAnswer, options.log + ": differs at " + seconds(report.difference->time) + ", " +
                                             report.difference->what + version_remark(log)};
  }
  print_line(options.log + " replays equal: " + compared + (log.truncated ? "; it ends within a message" : ""));
  return ExitStatus::kDone;
}

}  // namespace

void add_replay_command(CLI::App& app, Command& chosen) {
  CLI::App* command = add_subcommand(app, "replay", "Fly a log again and compare, bit for bit");
  const auto options = std::make_shared<ReplayOptions>();
  command->add_option("log", options->log, "Flight log (.ulg) of 'companion --log' or 'swiftlet fly --log'")
      ->required();
  command
      ->add_option(
          "--map", options->maps,
          "Map that it was flown in, and further ones that it was given under way, in place of those the log names")
      ->allow_extra_args(false);
  command->callback([options, &chosen] { chosen = [options] { return run_replay(*options); }; });
}

}  // namespace swiftlet::tools
