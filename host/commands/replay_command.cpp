#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <system_error>

#include "host/commands/command.hpp"
#include "host/commands/terminal.hpp"
#include "host/config/rig_file.hpp"
#include "host/loop/session_monitor.hpp"
#include "host/messages/message_decoder.hpp"

namespace strobe::host {
namespace {

struct ReplayOptions {
  std::string log;
  std::string rig_path;
  bool json = false;
};

/// --rig, else the rig file kept beside the log, else the shipped example.
std::string rig_path(const ReplayOptions& options) {
  if (!options.rig_path.empty()) return options.rig_path;
  const auto beside = std::filesystem::path(options.log).parent_path() / "rig.toml";
  std::error_code error;
  return std::filesystem::exists(beside, error) ? beside.string() : std::string();
}

int run_replay(const ReplayOptions& options) {
  const auto rig = load_rig(rig_path(options));
  if (!rig) return bad_input(rig.error().message);
  std::error_code error;
  if (!std::filesystem::is_regular_file(options.log, error)) return bad_input(options.log + ": no such file");
  lcm::LogFile log(options.log, "r");
  if (!log.good()) return bad_input(options.log + ": cannot be read");
  SessionMonitor monitor(assembly_settings(*rig), 0, "");
  MessageDecoder decoder(rig->rig, monitor);
  Terminal terminal(options.json ? Terminal::Style::json : Terminal::Style::plain);
  monitor.on_shot_result = [&](const ShotResult& shot_result) { terminal.shot_result(shot_result); };
  monitor.on_notification = [&](const std::string& text) { terminal.notify(text); };
  std::int64_t messages = 0;
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    ++messages;
    const std::int64_t now_ns = event->timestamp * 1000;
    monitor.time(now_ns);
    decoder.receive(event->channel, event->data, static_cast<std::size_t>(event->datalen), now_ns);
  }
  monitor.end();
  if (messages == 0) return bad_input(options.log + ": not an LCM log, or an empty one");
  if (!options.json) print(render_series(monitor.model().series, std::nullopt, kPlainWidth));
  if (monitor.shot_results() == 0) {
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
  command->add_flag("--json", options->json,
                    "one JSON object per readout on standard output, nothing else there");
  command->footer("Example: strobe replay run1/host-20260131T093000Z.lcmlog --json");
  command->callback([options, &exit_status] { exit_status = run_replay(*options); });
}

}  // namespace strobe::host
