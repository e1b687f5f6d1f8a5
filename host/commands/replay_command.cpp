#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <system_error>

#include "common/authentication/key_file.hpp"
#include "common/authentication/packet_seal.hpp"
#include "host/commands/command.hpp"
#include "host/commands/terminal.hpp"
#include "host/config/rig_file.hpp"
#include "host/loop/host_loop.hpp"

namespace strobe::host {
namespace {

struct ReplayOptions {
  std::string log;
  std::string rig_path;
  std::string key_file;
  bool json = false;
};

/// --rig, else the rig file kept beside the log, else the shipped example.
std::string rig_path(const ReplayOptions& options) {
  if (!options.rig_path.empty()) return options.rig_path;
  const auto beside = std::filesystem::path(options.log).parent_path() / "rig.toml";
  std::error_code error;
  return std::filesystem::exists(beside, error) ? beside.string() : std::string();
}

/// The clock of whoever wrote the log.
class LogClock final : public Clock {
 public:
  HostReading read() override { return {HostTime{now}, WallTime{now}, now}; }
  Duration now{};
};

/// Whether a log has a packet that is sealed with the lab's key. It is then reduced from those alone; a log
/// without, of another lab or of a journal, which is never sealed, as unverified.
bool is_sealed(const std::string& path, const std::string& rig, const authentication::Key& key) {
  const std::string channels = "STROBE/" + rig + "/";
  const authentication::PacketSeal seal(key);
  lcm::LogFile log(path, "r");
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    if (event->channel.starts_with(channels) &&
        seal.open(event->channel,
                  {static_cast<const std::uint8_t*>(event->data), static_cast<std::size_t>(event->datalen)}))
      return true;
  }
  return false;
}

HostLoopSettings loop_settings(const ReplayOptions& options, const RigFile& rig) {
  HostLoopSettings settings{rig.rig, assembly_settings(rig)};
  settings.replays = true;
  const auto key = authentication::find_key({options.key_file, rig.key_file.value_or("")});
  if (key && is_sealed(options.log, rig.rig, key->key)) settings.key = key->key;
  return settings;
}

int run_replay(const ReplayOptions& options) {
  const auto rig = load_rig(rig_path(options));
  if (!rig) return bad_input(rig.error().message);
  std::error_code error;
  if (!std::filesystem::is_regular_file(options.log, error)) return bad_input(options.log + ": no such file");
  lcm::LogFile log(options.log, "r");
  if (!log.good()) return bad_input(options.log + ": cannot be read");
  LogClock clock;
  NullTransport transport;
  HostLoop loop(loop_settings(options, *rig), transport, clock);
  Terminal terminal(Terminal::style(options.json, true));
  loop.add_listener(terminal);
  if (!loop.verifies()) terminal.note("unverified: the log has no seal of this host's key (see strobe key)");
  std::int64_t messages = 0;
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    ++messages;
    clock.now =
        std::max(clock.now, Duration{microseconds{event->timestamp}});  // a wall clock may have been set
    loop.step();
    loop.receive(event->channel,
                 {static_cast<const std::uint8_t*>(event->data), static_cast<std::size_t>(event->datalen)});
  }
  loop.end_session();
  if (messages == 0) return bad_input(options.log + ": not an LCM log, or an empty one");
  if (!options.json) print(render_series(terminal.model().series, std::nullopt, kPlainWidth));
  if (terminal.model().shots == 0) {
    return failed(fmt::format("{}: no shot of rig {} in {} messages", options.log, rig->rig, messages));
  }
  return kDone;
}

}  // namespace

void add_replay_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App* command = app.add_subcommand("replay", "Compute the readouts of a recorded session again");
  command->add_option("LOG", options->log, "LCM log: a host's, a journal with frames, or lcm-logger's")
      ->required();
  command->add_option("--rig", options->rig_path,
                      "rig file (default: rig.toml beside the log, else the example that comes with strobe)");
  command->add_option(
      "--key-file", options->key_file,
      "the lab's key, to know the lab's messages (default: as `strobe key` tells); a log without "
      "its seal is shown as unverified");
  command->add_flag("--json", options->json,
                    "one JSON object per readout on standard output, nothing else there");
  command->footer("Example: strobe replay run1/host-20260131T093000Z.lcmlog --json");
  command->callback([options, &exit_status] { exit_status = run_replay(*options); });
}

}  // namespace strobe::host
