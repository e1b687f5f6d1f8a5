#include "host/commands/session_options.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>

#include "host/clock/machine_clock.hpp"

namespace strobe::host {
namespace {

/// Every two seconds a line for a person.
class ReadingNotes {
 public:
  void operator()(double share) {
    constexpr Duration kEvery = std::chrono::seconds{2};
    const HostTime now = steady_now();
    if (now - told_ < kEvery || ::isatty(STDERR_FILENO) != 1) return;
    told_ = now;
    fmt::print(stderr, "strobe: {:.0f} % of the session read\n", 100.0 * share);
  }

 private:
  HostTime told_ = steady_now();
};

}  // namespace

void add_session_options(CLI::App& command, SessionOptions& options) {
  command.add_option("--rig", options.rig_path,
                     "rig file (default: those that the session keeps, each run's its own)");
  command.add_option(
      "--key-file", options.key_file,
      "the lab's key, to know the lab's messages (default: as `strobe key` tells); a session without "
      "its seal is shown as unverified");
}

Result<StoredSession> read_for(Terminal& terminal, const std::string& folder, const SessionOptions& options) {
  auto session = read_session(folder, {options.rig_path, options.key_file, ReadingNotes()});
  if (!session) return session;
  for (const std::string& remark : session->remarks) terminal.note(remark);
  return session;
}

}  // namespace strobe::host
