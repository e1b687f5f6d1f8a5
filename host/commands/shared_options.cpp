#include "host/commands/shared_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "common/authentication/key_file.hpp"
#include "common/config/files.hpp"
#include "common/wire/lcm_url.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/series/select.hpp"

namespace strobe::host {

void add_link_options(CLI::App& command, RigOptions& options) {
  command.add_option("--lcm-url", options.url, "LCM URL (default: the rig file's, else this computer only)")
      ->check(wire::lcm_url_problem);
  command.add_option("--key-file", options.key_file,
                     "the lab's key (default: the rig file's, $STROBE_KEY_FILE, ~/.config/strobe/lab.key)");
}

Result<authentication::Key> lab_key(const RigOptions& options, const RigFile& rig) {
  const auto found = authentication::find_key({options.key_file, rig.key_file.value_or("")});
  if (!found) return tl::unexpected(found.error());
  return found->key;
}

Result<std::string> read_option_file(const char* option, const std::string& file) {
  return config::read_file(file).map_error(
      [option](const Error& error) { return Error{fmt::format("{}: {}", option, error.message)}; });
}

void add_photograph_options(CLI::App& command, PhotographOptions& options) {
  command.add_option("--photographs", options.folder,
                     "folder where the camera's photographs arrive (default: the rig file's camera.folder)");
  command
      .add_option("--effort", options.effort,
                  "how photographs are digitized: fast, standard or thorough (default standard)")
      ->check(CLI::IsMember({"fast", "standard", "thorough"}));
}

void add_session_options(CLI::App& command, SessionOptions& options) {
  command.add_option("--rig", options.rig_path,
                     "rig file (default: those that the session keeps, each run's its own)");
  command.add_option(
      "--key-file", options.key_file,
      "the lab's key, to know the lab's messages (default: as `strobe key` tells); a session without "
      "its seal is shown as unverified");
}

void add_over_option(CLI::App& command, std::vector<std::string>& over) {
  command
      .add_option(
          "--over", over,
          "what shots of one mean may differ in, as operator,temperature_c (default: nothing of spin, "
          "angle, surface, ball, operator, temperature, rig, calibration and plan)")
      ->delimiter(',')
      ->type_name("NOTES")
      ->check([](const std::string& word) {
        const bool known = std::ranges::find(kConditionKeys, note_key(word)) != kConditionKeys.end();
        return known ? std::string()
                     : fmt::format("no \"{}\" among {}", word, fmt::join(kConditionKeys, " "));
      })
      ->allow_extra_args(false);
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
  for (const std::string& advice : session->advice) terminal.note(advice);
  return session;
}

}  // namespace strobe::host
