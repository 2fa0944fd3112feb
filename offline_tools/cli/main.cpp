// The program `swiftlet`: one binary, subcommands, the contract's exit statuses. Every failure prints one line.
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>

#include "cli/commands.hpp"
#include "cli/output.hpp"
#include "swiftlet/version.hpp"

namespace swiftlet::tools {
namespace {

constexpr const char* kVersionLine = "swiftlet ";

int exit_with(ExitStatus status, const std::string& line) {
  print_line(line);
  return static_cast<int>(status);
}

/// The command as far as it was recognised: "swiftlet map build".
std::string command_name(const CLI::App& app) {
  std::string name = app.get_name();
  for (const CLI::App* subcommand : app.get_subcommands()) name += " " + command_name(*subcommand);
  return name;
}

int refuse_usage(const CLI::App& app, const std::string& what) {
  return exit_with(ExitStatus::kUsage, what + " ('" + command_name(app) + " --help' shows how)");
}

int run(int argc, char** argv) {
  CLI::App app("Plans certified, smooth quadrotor trajectories through OctoMaps.", "swiftlet");
  app.set_version_flag("--version", std::string(kVersionLine) + kVersion);
  Command chosen;
  add_map_commands(app, chosen);
  add_plan_command(app, chosen);
  add_solve_command(app, chosen);
  add_verify_command(app, chosen);
  add_fly_command(app, chosen);
  add_replay_command(app, chosen);
  add_world_command(app, chosen);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const bool asked_for = error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success);  // --help, --version
    return asked_for ? app.exit(error) : refuse_usage(app, error.what());
  }
  if (!chosen) return refuse_usage(app, "a command is missing");
  return static_cast<int>(chosen());
}

}  // namespace

CLI::App* add_subcommand(CLI::App& app, const std::string& name, const std::string& description) {
  CLI::App* subcommand = app.add_subcommand(name, description);
  subcommand->set_version_flag("--version", std::string(kVersionLine) + kVersion);
  return subcommand;
}

void print_line(const std::string& line) {
  std::string one_line = line;
  std::replace_if(
      one_line.begin(), one_line.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; }, ' ');
  std::fprintf(stderr, "swiftlet: %s\n", one_line.c_str());
}

}  // namespace swiftlet::tools

int main(int argc, char** argv) {
  using swiftlet::tools::ExitStatus;
  std::signal(SIGPIPE, SIG_IGN);  // a closed pipe is an output that cannot be written, not a crash
  try {
    return swiftlet::tools::run(argc, argv);
  } catch (const swiftlet::tools::Failure& failure) {
    return swiftlet::tools::exit_with(failure.status, failure.line);
  } catch (const std::exception& error) {
    return swiftlet::tools::exit_with(ExitStatus::kInternal,
                                      std::string("internal error, please report: ") + error.what());
  }
}
