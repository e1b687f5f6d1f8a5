// The options that several commands share, and what they do with them. Single-threaded.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/authentication/key.hpp"
#include "common/result.hpp"
#include "host/archive/read_session.hpp"
#include "host/commands/terminal.hpp"
#include "host/photographs/photograph_pipeline.hpp"

namespace CLI {
class App;
}

namespace strobe::host {

/// Of commands that work on a rig.
struct RigOptions {
  std::string rig_path;  ///< empty: the example that comes with strobe
  std::string url;       ///< LCM; empty: the rig file's, else this machine only
  std::string key_file;
};
/// Adds --lcm-url and --key-file.
void add_link_options(CLI::App& command, RigOptions& options);
/// As of --key-file, else the rig file's, else this user's. Fails with one line.
Result<authentication::Key> lab_key(const RigOptions& options, const RigFile& rig);

/// A file that an option names, whole. Fails with "--plan: FILE: what".
Result<std::string> read_option_file(const char* option, const std::string& file);

/// Adds --photographs and --effort.
void add_photograph_options(CLI::App& command, PhotographOptions& options);

struct SessionOptions {
  std::string rig_path;
  std::string key_file;
};

/// Adds --rig and --key-file.
void add_session_options(CLI::App& command, SessionOptions& options);

/// Adds --over: what shots of one mean may differ in, of kConditionKeys.
void add_over_option(CLI::App& command, std::vector<std::string>& over);

/// Tells a person at a terminal every two seconds how much of the session has been read.
std::function<void(double share)> reading_notes(const std::string& name);

/// The session, with its remarks told; at a terminal also how far the reading is, if it takes long.
Result<StoredSession> read_for(Terminal& terminal, const std::string& folder, const SessionOptions& options);

}  // namespace strobe::host
