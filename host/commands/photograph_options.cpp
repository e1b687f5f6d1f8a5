#include "host/commands/photograph_options.hpp"

#include <CLI/CLI.hpp>

namespace strobe::host {

void add_photograph_options(CLI::App& command, PhotographOptions& options) {
  command.add_option("--photographs", options.folder,
                     "folder where the camera's photographs arrive (default: the rig file's camera.folder)");
  command
      .add_option("--effort", options.effort,
                  "how photographs are digitized: fast, standard or thorough (default standard)")
      ->check(CLI::IsMember({"fast", "standard", "thorough"}));
}

}  // namespace strobe::host
