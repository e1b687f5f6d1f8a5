#include "host/commands/session_options.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>

#include "host/clock/machine_clock.hpp"

namespace strobe::host {

void add_session_options(CLI::App& command, SessionOptions& options) {
  command.add_option("--rig", options.rig_path,
                     "rig file (default: those that the session keeps, each run's its own)");
  command.add_option(
      "--key-file", options.key_file,
      "the lab's key, to know the lab's messages (default: as `strobe key` tells); a session without "
      "its seal is shown as unverified");
}

std::function<void(double share)> reading_notes(const std::string& name) {
  return [name, told = steady_now()](double share) mutable {
    constexpr Duration kEvery = std::chrono::seconds{2};
    const HostTime now = steady_now();
    if (now - told < kEvery || ::isatty(STDERR_FILENO) != 1) return;
    told = now;
    fmt::print(stderr, "strobe: {:.0f} % of {} read\n", 100.0 * share, name);
  };
}

Result<StoredSession> read_for(Terminal& terminal, const std::string& folder, const SessionOptions& options) {
  auto session = read_session(folder, {options.rig_path, options.key_file, reading_notes(folder)});
  if (!session) return session;
  for (const std::string& remark : session->remarks) terminal.note(remark);
  return session;
}

}  // namespace strobe::host
