#include "cli/commands.hpp"

namespace swiftlet::tools {

/// A build without the MAVLink link has nothing to fly with.
void add_fly_command(CLI::App& app, Command& chosen) {
  CLI::App* command = add_subcommand(app, "fly", "Not in this build");
  command->allow_extras();
  command->callback([&chosen] {
    chosen = []() -> ExitStatus {
      throw Failure{ExitStatus::kUsage,
                    "this program was built without the MAVLink link; build with SWIFTLET_MAVLINK=ON"};
    };
  });
}

}  // namespace swiftlet::tools
