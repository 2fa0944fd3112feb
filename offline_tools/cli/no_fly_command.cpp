#include "cli/commands.hpp"

namespace swiftlet::tools {
namespace {

/// A build without the MAVLink link has nothing to fly with.
void add_absent(CLI::App& app, Command& chosen, const std::string& name) {
  CLI::App* command = add_subcommand(app, name, "Not in this build");
  command->allow_extras();
  command->callback([&chosen] {
    chosen = []() -> ExitStatus {
      throw Failure{ExitStatus::kUsage,
                    "this program was built without the MAVLink link; build with SWIFTLET_MAVLINK=ON"};
    };
  });
}

}  // namespace

void add_fly_command(CLI::App& app, Command& chosen) { add_absent(app, chosen, "fly"); }

void add_replay_command(CLI::App& app, Command& chosen) { add_absent(app, chosen, "replay"); }

}  // namespace swiftlet::tools
