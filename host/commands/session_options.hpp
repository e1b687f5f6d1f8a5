// What the commands that read a session's folder share. Single-threaded.
#pragma once

#include <functional>
#include <string>

#include "common/result.hpp"
#include "host/archive/read_session.hpp"
#include "host/commands/terminal.hpp"

namespace CLI {
class App;
}

namespace strobe::host {

struct SessionOptions {
  std::string rig_path;
  std::string key_file;
};

/// Adds --rig and --key-file.
void add_session_options(CLI::App& command, SessionOptions& options);

/// Tells a person at a terminal every two seconds how much of the session has been read.
std::function<void(double share)> reading_notes(const std::string& name);

/// The session, with its remarks told; at a terminal also how far the reading is, if it takes long.
Result<StoredSession> read_for(Terminal& terminal, const std::string& folder, const SessionOptions& options);

}  // namespace strobe::host
