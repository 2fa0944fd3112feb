#pragma once
#include <CLI/CLI.hpp>
#include <functional>

#include "cli/failure.hpp"

namespace swiftlet::tools {

/// What the command line asked for, run once it is parsed. Throws Failure.
using Command = std::function<ExitStatus()>;

/// Each adds its subcommand with its options; parsing it sets `chosen`.
void add_map_commands(CLI::App& app, Command& chosen);
void add_plan_command(CLI::App& app, Command& chosen);
void add_solve_command(CLI::App& app, Command& chosen);
void add_verify_command(CLI::App& app, Command& chosen);
void add_fly_command(CLI::App& app, Command& chosen);
void add_replay_command(CLI::App& app, Command& chosen);
void add_world_command(CLI::App& app, Command& chosen);

/// A subcommand that answers --help and --version like the program itself.
CLI::App* add_subcommand(CLI::App& app, const std::string& name, const std::string& description);

/// Prints "swiftlet: line" on standard error.
void print_line(const std::string& line);

}  // namespace swiftlet::tools
