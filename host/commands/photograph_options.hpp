// The options of commands that take the camera's photographs. No I/O; single-threaded.
#pragma once

#include "host/photographs/photograph_pipeline.hpp"

namespace CLI {
class App;
}

namespace strobe::host {

/// Adds --photographs and --effort.
void add_photograph_options(CLI::App& command, PhotographOptions& options);

}  // namespace strobe::host
