#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/arguments.hpp"
#include "cli/commands.hpp"
#include "cli/json.hpp"
#include "cli/map_file.hpp"
#include "cli/output.hpp"
#include "cli/progress_line.hpp"
#include "cli/text.hpp"
#include "map/alternatives.hpp"
#include "map/audit.hpp"
#include "map/landmarks.hpp"
#include "map/map_builder.hpp"
#include "map/map_report.hpp"
#include "map/point_cloud.hpp"
#include "map/voxel_map.hpp"
#include "report/map_report_page.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kLargestRadius = 100;          // [m]
constexpr NumberRange kResolutions{1e-3, 100};  // [m]
constexpr std::uint64_t kLargestCoarsening = 256;
constexpr double kLongestDetour = 100;  // [m]

struct BuildCommand {
  std::string in;
  std::string out;
  std::string json;
  std::string unknown = "avoid";
  std::string partition = "boxes";
  std::uint64_t coarsen = 1;
  std::uint64_t landmarks = 0;
  CLI::Option* landmarks_given = nullptr;
  double sliver_tolerance = 0;
  CLI::Option* drop_slivers = nullptr;
  bool no_verify = false;
  MapBuildOptions build;
};

struct InfoCommand {
  std::string map;
  std::string json;
};

struct ShowCommand {
  std::string map;
  std::string report;
};

struct VerifyCommand {
  std::string map;
  std::string source;
};

struct ImportCommand {
  std::string cloud;
  std::string out;
  double resolution = 0;
  bool origin_rays = false;
};

void print_row(const char* name, const std::string& value) { std::fprintf(stderr, "%-14s %s\n", name, value.c_str()); }

/// What would join the free space that falls into pieces, as far as it was tried.
std::string advice_on_pieces(const MapReport& report) {
  const std::string pieces =
      "only " + to_text(100 * report.largest_component, 1) + " % of the free space hangs together";
  if (!report.alternatives) return pieces + "; 'swiftlet map build' tries what would connect it";
  if (report.alternatives->empty()) return pieces + "; no option is left that could connect it";
  const Alternative& last = report.alternatives->back();
  if (last.largest_component >= kGoodShare) {
    const bool trusts = last.option == "--unknown free";
    return pieces + "; with " + last.option + " it is " + to_text(100 * last.largest_component, 1) + " %" +
           (trusts ? ", for where unseen space is safe" : "");
  }
  std::string tried;
  for (const Alternative& other : *report.alternatives) {
    tried += (tried.empty() ? "" : ", ") + other.option + " (" + to_text(100 * other.largest_component, 1) + " %)";
  }
  return pieces + "; tried without connecting 90 %: " + tried;
}

std::string note_on_nothing(const MapReport& report) {
  if (report.lost_to_unknown > 0) {
    return "nothing is free; --unknown free gives " + to_text(report.lost_to_unknown, 2) +
           " m^3, for where unseen space is safe";
  }
  return "nothing is free; a smaller --radius may help";
}

/// What to know about a map before anything else; empty when all is well.
std::string note_on(const MapReport& report) {
  if (report.cells == 0) return note_on_nothing(report);
  return report.largest_component < kGoodShare ? advice_on_pieces(report) : "";
}

/// "holds it in 8.0 % of its map memory; a search reaches 34.6 % of the windows".
std::string describe_fit(const BoardFit& board, std::size_t blob_bytes) {
  const double share = 100 * static_cast<double>(blob_bytes) / static_cast<double>(board.memory.map_bytes);
  if (!board.holds_map) {
    return "too small: its map memory has " + std::to_string(board.memory.map_bytes) + " bytes; try --coarsen";
  }
  return "holds it in " + to_text(share, 1) + " % of its map memory; a search reaches " +
         (board.search_share < 1 ? "up to " + std::to_string(board.capacity.search_nodes) + " windows, " +
                                       to_text(100 * board.search_share, 1) + " % of them"
                                 : "every window");
}

/// "cells 96, record_offsets 32, ...": the blob's bytes.
std::string describe_sections(const MapReport& report) {
  const Json json = map_report_json(report);
  std::string text;
  for (const auto& [name, bytes] : json["section_bytes"].items()) {
    text += (text.empty() ? "" : ", ") + name + " " + dump(bytes);
  }
  return text;
}

/// The short table for people.
void print_report(const MapReport& report) {
  const auto& b = report.bounds;
  const auto& p = report.largest_component_point;
  print_row("source", report.source);
  print_row("bounds", "(" + to_text({b[0], b[1], b[2]}) + ") to (" + to_text({b[3], b[4], b[5]}) + ") m");
  print_row("resolution", to_text(report.resolution, 3) + " m, stored in steps of " + to_text(report.unit, 4) + " m");
  print_row("vehicle", "radius " + to_text(report.radius, 3) + " m, unknown space: " + describe(report.unknown));
  const double degree =
      report.cells == 0 ? 0 : 2.0 * static_cast<double>(report.windows) / static_cast<double>(report.cells);
  print_row("cells", std::to_string(report.cells) + ", joined by " + std::to_string(report.windows) + " windows, " +
                         to_text(degree, 1) + " a cell, " + std::to_string(report.degree_max) + " at most");
  print_row("blob", std::to_string(report.blob_bytes) + " bytes, crc32 " + report.crc32);
  print_row("bytes", describe_sections(report));
  print_row("search",
            std::to_string(report.landmarks) + " landmarks, " + std::to_string(report.landmark_bytes) +
                " bytes; by default over " +
                (report.searched_over_centres ? "window centres with them" : "points along the straight line"));
  print_row("free", to_text(report.free_volume, 2) + " m^3; lost " + to_text(report.lost_to_inflation, 2) +
                        " to inflation, " + to_text(report.lost_to_unknown, 2) + " to unknown space, " +
                        to_text(report.lost_to_coarsening, 2) + " to coarsening, " +
                        to_text(report.lost_to_slivers, 2) + " to slivers");
  print_row("worst loss", "free points within " + to_text(report.radius + report.worst_loss, 3) + " m of an obstacle");
  print_row("components", std::to_string(report.components));
  if (report.cells > 0) {
    print_row("largest", to_text(100 * report.largest_component, 1) + " % of the free space, around (" +
                             to_text({p[0], p[1], p[2]}) + ")");
  }
  for (const BoardFit& board : report.boards) print_row(board.name.c_str(), describe_fit(board, report.blob_bytes));
  if (const std::string note = note_on(report); !note.empty()) print_row("note", note);
  if (report.landmarks_too_far) {
    print_row("note", "no landmarks: a way is longer than 32,767 steps of " + to_text(report.unit, 4) + " m");
  }
}

AuditReport audit(const BoxGraphView& graph, const VoxelMap& source) {
  ProgressLine line;
  return audit_map(graph, source, [&](std::string_view stage, double done) { line.show(stage, done); });
}

BuiltMap build(const BuildCommand& command, const VoxelMap& source) {
  ProgressLine line;
  return unwrap(build_map(source, command.in, command.build,
                          [&](std::string_view stage, double done) { line.show(stage, done); }));
}

std::vector<Alternative> alternatives_to(const BuildCommand& command, const VoxelMap& source) {
  ProgressLine line;
  return try_alternatives(source, command.in, command.build,
                          [&](std::string_view stage, double done) { line.show(stage, done); });
}

/// A map that does not keep its promises is never written.
void check_built(const BuiltMap& built, const VoxelMap& source) {
  const Result<BoxGraphView> graph = BoxGraphView::open(built.blob);  // build_map has opened it before
  const AuditReport report = audit(*graph, source);
  if (report.defects == 0) return;
  for (const std::string& finding : report.findings) print_line(finding);
  throw Failure{ExitStatus::kInternal, "internal error, please report: the map that was built has " +
                                           std::to_string(report.defects) + " defects; nothing was written"};
}

ExitStatus run_build(const BuildCommand& command) {
  check_outputs({command.out, command.json}, {command.in});
  const VoxelMap source = unwrap(read_octree(command.in));
  BuiltMap built = build(command, source);
  if (!command.no_verify) check_built(built, source);
  write_output(command.out, {reinterpret_cast<const char*>(built.blob.data()), built.blob.size()});
  if (built.report.cells > 0 && built.report.largest_component < kGoodShare) {
    built.report.alternatives = alternatives_to(command, source);
  }
  write_output(command.json, dump(map_report_json(built.report)) + '\n');
  print_report(built.report);
  return ExitStatus::kDone;
}

ExitStatus run_verify(const VerifyCommand& command) {
  const MapFile map = load_map(command.map);
  const VoxelMap source = unwrap(read_octree(command.source));
  const AuditReport report = audit(map.graph, source);
  for (const std::string& finding : report.findings) print_line(finding);
  if (report.defects > 0) {
    throw Failure{ExitStatus::kNoAnswer, command.map + ": " + std::to_string(report.defects) +
                                             " defects; build it again with 'swiftlet map build'"};
  }
  const MapReport facts = map_info(map.graph);
  print_line(command.map + " keeps its promises: " + std::to_string(facts.cells) + " cells and " +
             std::to_string(facts.windows) + " windows, radius " + to_text(facts.radius, 3) +
             " m, unknown space: " + describe(facts.unknown));
  return ExitStatus::kDone;
}

ExitStatus run_info(const InfoCommand& command) {
  check_outputs({command.json}, {command.map});
  const MapFile map = load_map(command.map);
  const MapReport report = map_info(map.graph);
  write_output(command.json, dump(map_report_json(report)) + '\n');
  print_report(report);
  return ExitStatus::kDone;
}

std::vector<std::byte> to_octree(const PointCloud& cloud, const ImportCommand& command) {
  ProgressLine line;
  return unwrap(octree_of(cloud, command.cloud, command.resolution, command.origin_rays,
                          [&](std::string_view stage, double done) { line.show(stage, done); }));
}

ExitStatus run_import(const ImportCommand& command) {
  check_outputs({command.out}, {command.cloud});
  const PointCloud cloud = unwrap(read_point_cloud(command.cloud));
  const std::vector<std::byte> octree = to_octree(cloud, command);
  write_output(command.out, {reinterpret_cast<const char*>(octree.data()), octree.size()});
  print_line(command.cloud + ": " + std::to_string(cloud.points.size()) + " points" +
             (cloud.dropped > 0 ? ", " + std::to_string(cloud.dropped) + " without numbers dropped" : "") +
             (command.origin_rays ? "" : "; nothing is known to be free: build with '--unknown free'"));
  return ExitStatus::kDone;
}

ExitStatus run_show(const ShowCommand& command) {
  check_outputs({command.report}, {command.map});
  const MapFile map = load_map(command.map);
  Obstacles obstacles(map);
  const MapReport report = map_info(map.graph);
  const std::string title = std::filesystem::path(map.path).stem().string();
  write_output(command.report,
               map_report_html({map_report_json(report), map.graph, obstacles.boxes(), note_on(report), title}));
  return ExitStatus::kDone;
}

std::array<double, 6> parse_bounds(const std::string& text) {
  const std::vector<std::string_view> pieces = split_at_commas(text);
  std::array<double, 6> bounds{};
  bool usable = pieces.size() == bounds.size();
  for (std::size_t i = 0; usable && i < bounds.size(); ++i) {
    const std::optional<double> number = parse_number(pieces[i]);
    usable = number && std::isfinite(*number);
    bounds[i] = number.value_or(0);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) usable = usable && bounds[axis] < bounds[axis + 3];
  if (!usable) throw CLI::ValidationError("--bounds", "'" + text + "' is not x0,y0,z0,x1,y1,z1 with low below high");
  return bounds;
}

void apply_choices(BuildCommand& command) {
  command.build.unknown = command.unknown == "avoid"      ? UnknownPolicy::kAvoid
                          : command.unknown == "occupied" ? UnknownPolicy::kOccupied
                                                          : UnknownPolicy::kFree;
  command.build.partition = command.partition == "boxes" ? Partition::kBoxes : Partition::kOctree;
  command.build.coarsen = static_cast<int>(command.coarsen);
  if (*command.drop_slivers) command.build.sliver_tolerance = command.sliver_tolerance;
  if (*command.landmarks_given) command.build.landmarks = static_cast<std::uint32_t>(command.landmarks);
}

void add_build_command(CLI::App& map, Command& chosen) {
  CLI::App* app = add_subcommand(map, "build", "Flatten an OctoMap into a map that fits on a board");
  const auto command = std::make_shared<BuildCommand>();
  app->add_option("input", command->in, "OctoMap (.bt, .ot)")->required();
  app->add_option("-o,--out", command->out, "Map to write")->required();
  add_number(*app, "--radius", command->build.radius, {0, kLargestRadius}, "Radius of the vehicle [m]")->required();
  add_choice(*app, "--unknown", command->unknown, {"avoid", "occupied", "free"}, "What to do with unseen space");
  add_choice(*app, "--partition", command->partition, {"boxes", "octree"},
             "Merged boxes, or the paper's octree leaves");
  app->add_option_function<std::string>(
         "--bounds", [command](const std::string& text) { command->build.bounds = parse_bounds(text); },
         "Map only what lies inside [m]")
      ->type_name("x0,y0,z0,x1,y1,z1");
  add_count(*app, "--coarsen", command->coarsen, 1, kLargestCoarsening,
            "Keep only whole free blocks of so many voxels");
  command->drop_slivers =
      add_number(*app, "--drop-slivers", command->sliver_tolerance, {0, kLongestDetour},
                 "Drop cells one voxel thick that no way needs, or whose detour is at most so long [m]");
  command->landmarks_given =
      add_count(*app, "--landmarks", command->landmarks, 0, kMostLandmarks,
                "Landmarks of the search, 2 bytes a window each; as many as stay below 60 % of the rest unless given");
  app->add_flag("--no-verify", command->no_verify, "Skip the check of the map against its source");
  app->add_option("--json", command->json, "swiftlet-map/1 report to write; - is standard output");
  app->callback([command, &chosen] {
    apply_choices(*command);
    chosen = [command] { return run_build(*command); };
  });
}

void add_info_command(CLI::App& map, Command& chosen) {
  CLI::App* app = add_subcommand(map, "info", "Say what a map holds");
  const auto command = std::make_shared<InfoCommand>();
  app->add_option("map", command->map, "Map made by 'swiftlet map build'")->required();
  app->add_option("--json", command->json, "swiftlet-map/1 report to write; - is standard output");
  app->callback([command, &chosen] { chosen = [command] { return run_info(*command); }; });
}

void add_show_command(CLI::App& map, Command& chosen) {
  CLI::App* app = add_subcommand(map, "show", "Draw what a map holds");
  const auto command = std::make_shared<ShowCommand>();
  app->add_option("map", command->map, "Map made by 'swiftlet map build'")->required();
  app->add_option("--report", command->report, "Page to write (HTML)")->required();
  app->callback([command, &chosen] { chosen = [command] { return run_show(*command); }; });
}

void add_map_verify_command(CLI::App& map, Command& chosen) {
  CLI::App* app = add_subcommand(map, "verify", "Check a map against the OctoMap that it was built from");
  const auto command = std::make_shared<VerifyCommand>();
  app->add_option("map", command->map, "Map made by 'swiftlet map build'")->required();
  app->add_option("source", command->source, "OctoMap (.bt, .ot)")->required();
  app->callback([command, &chosen] { chosen = [command] { return run_verify(*command); }; });
}

void add_import_command(CLI::App& map, Command& chosen) {
  CLI::App* app = add_subcommand(map, "import", "Turn a point cloud into an OctoMap");
  const auto command = std::make_shared<ImportCommand>();
  app->add_option("cloud", command->cloud, "Points (.ply, .pcd, .xyz)")->required();
  add_number(*app, "--resolution", command->resolution, kResolutions, "Edge of a voxel [m]")->required();
  app->add_option("-o,--out", command->out, "OctoMap to write (.bt)")->required();
  app->add_flag("--origin-rays", command->origin_rays,
                "What lies between the sensor (a .pcd's viewpoint, else the origin) and its points is free");
  app->callback([command, &chosen] { chosen = [command] { return run_import(*command); }; });
}

}  // namespace

void add_map_commands(CLI::App& app, Command& chosen) {
  CLI::App* map = add_subcommand(app, "map", "Make maps and look at them");
  add_build_command(*map, chosen);
  add_info_command(*map, chosen);
  add_show_command(*map, chosen);
  add_map_verify_command(*map, chosen);
  add_import_command(*map, chosen);
}

}  // namespace swiftlet::tools
