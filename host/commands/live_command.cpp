#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <memory>
#include <optional>

#include "common/authentication/key_file.hpp"
#include "host/commands/command.hpp"
#include "host/commands/terminal.hpp"
#include "host/commands/watched_photographs.hpp"
#include "host/config/rig_file.hpp"
#include "host/loop/session_monitor.hpp"
#include "host/messages/command_factory.hpp"
#include "host/messages/lcm_link.hpp"
#include "host/messages/message_decoder.hpp"
#include "host/view/timing.hpp"

namespace strobe::host {
namespace {

// A firmware that is there would have been heard by then.
constexpr std::int64_t kSilent_ns = 2'000'000'000;

struct LiveOptions {
  std::string rig_path;
  std::string url;
  std::string key_file;
  PhotographOptions photographs;
  bool json = false;
  bool plain = false;
  bool timing = false;
  int shots = 0;
  double idle_exit_s = 0.0;
};

Terminal::Style style_of(const LiveOptions& options) {
  if (options.json) return Terminal::Style::json;
  return options.plain ? Terminal::Style::plain : Terminal::Style::screen;
}

/// After each shot, once the firmware has told of it: its next heartbeat counts the shot's flashes.
class TimingReport {
 public:
  void shot_done(int shot_id, std::int64_t heard_ns) {
    after_shot_ = shot_id;
    heard_ns_ = heard_ns;
  }
  bool due() const { return after_shot_.has_value(); }
  void print_when_told(SessionMonitor& monitor, const Model& model, bool json) {
    if (!due() || !model.status || monitor.session().status_heard_ns() <= heard_ns_) return;
    if (json) {
      print({timing_json(*model.status, model.clock, *after_shot_)});
    } else {
      print(render_timing(*model.status));
    }
    after_shot_.reset();
  }

 private:
  std::optional<int> after_shot_;
  std::int64_t heard_ns_ = 0;  ///< the newest heartbeat when the shot was done with
};

/// Asks strobed for what did not come, also for what was before this listener joined.
class Asking {
 public:
  Asking(const authentication::Key& key, const std::string& rig, std::int64_t host_id)
      : factory_(host_id), sealer_(key, rig) {}
  void turn(Session& session, LcmLink& link, std::int64_t now_ns) {
    if (!session.status()) return;
    for (const EventRange& range : session.ledger().due(now_ns)) {
      if (const auto sealed = sealer_.seal(factory_.resend(session.status()->boot_id, range)))
        link.publish_command(*sealed);
    }
  }

 private:
  CommandFactory factory_;
  CommandSealer sealer_;
};

/// Says what is missing once it is no longer on its way.
class MissingWords {
 public:
  std::optional<std::string> turn(std::int64_t missing, std::int64_t now_ns) {
    constexpr std::int64_t kOnItsWay_ns = 5'000'000'000;
    if (missing != missing_) since_ns_ = now_ns;
    missing_ = missing;
    if (missing <= said_ || now_ns - since_ns_ < kOnItsWay_ns) return std::nullopt;
    said_ = missing;
    return fmt::format("{} events did not arrive here", missing);
  }

 private:
  std::int64_t missing_ = 0, said_ = 0, since_ns_ = 0;
};

int run_live(const LiveOptions& options) {
  const auto rig = load_rig(options.rig_path);
  if (!rig) return bad_input(rig.error().message);
  const std::string url = lcm_url(options.url, *rig);
  const auto key = authentication::find_key({options.key_file, rig->key_file.value_or("")});
  const std::int64_t host_id = random_host_id();
  SessionMonitor monitor(assembly_settings(*rig), 0, key.has_value(),
                         fmt::format("strobe live   rig {}", rig->rig));
  std::optional<Asking> asking;
  if (key) asking.emplace(key->key, rig->rig, host_id);
  WatchedPhotographs photographs(*rig, options.photographs, "", host_id, monitor);
  if (auto watched = photographs.open(); !watched) return bad_input(watched.error().message);
  MessageDecoder decoder(rig->rig, photographs.sink());
  std::int64_t last_message_ns = steady_now_ns();
  auto link =
      LcmLink::open(url, rig->rig, [&](const std::string& channel, const void* data, std::size_t size) {
        if (photographs.own_frame(channel, data, size)) return;
        last_message_ns = steady_now_ns();
        decoder.receive(channel, data, size, last_message_ns);
      });
  if (!link) return failed(link.error().message);
  catch_signals();
  Terminal terminal(style_of(options));
  terminal.notify(fmt::format("listening to rig {} on {}", rig->rig, url));
  TimingReport timing;
  monitor.on_shot_result = [&](const ShotResult& shot_result) {
    if (options.shots == 0 || monitor.shot_results() <= options.shots) terminal.shot_result(shot_result);
    if (options.timing) timing.shot_done(shot_result.shot_id, monitor.session().status_heard_ns());
  };
  monitor.on_notification = [&](const std::string& text) { terminal.notify(text); };
  for (const std::string& text : photographs.opening_words()) monitor.notify(text);
  if (!key) monitor.notify("what is lost on the way cannot be asked for: " + key.error().message);
  const auto idle_ns = static_cast<std::int64_t>(options.idle_exit_s * 1e9);
  MissingWords missing;
  while (!interrupted()) {
    if (!(*link)->wait(50, photographs.descriptors()) || !(*link)->drain())
      return failed("LCM cannot receive any more");
    for (const auto& frame : photographs.turn(steady_now_ns())) {
      photographs.sink().frame(frame, steady_now_ns());
      (*link)->publish(frame);
    }
    for (const std::string& text : photographs.take_notifications()) monitor.notify(text);
    const std::int64_t now_ns = steady_now_ns();
    monitor.time(now_ns);
    monitor.local_clocks(read_clocks());
    const Model& shown = monitor.shown(now_ns);
    terminal.show(shown, now_ns);
    if (!terminal.owns_screen()) timing.print_when_told(monitor, shown, options.json);
    if (asking) asking->turn(monitor.session(), **link, now_ns);
    if (const auto words = missing.turn(monitor.model().events_missing, now_ns)) terminal.notify(*words);
    const bool silent = now_ns - monitor.session().status_heard_ns() > kSilent_ns;
    const bool told = !timing.due() || terminal.owns_screen() || silent;
    if (options.shots > 0 && monitor.shot_results() >= options.shots && told) break;
    if (idle_ns > 0 && now_ns - last_message_ns > idle_ns) break;
  }
  terminal.close();
  if (!options.json && monitor.model().series.shots() > 0) {
    print(render_series(monitor.model().series, std::nullopt, kPlainWidth));
  }
  return options.shots > 0 && monitor.shot_results() < options.shots ? kFailed : kDone;
}

}  // namespace

void add_live_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<LiveOptions>();
  CLI::App* command =
      app.add_subcommand("live", "Watch a session: each shot's readout, the series, the firmware");
  command->add_option("--rig", options->rig_path, "rig file (default: the example that comes with strobe)");
  command->add_option("--lcm-url", options->url, "LCM URL (default: the rig file's, else this machine only)");
  command->add_option("--key-file", options->key_file,
                      "the lab's key, to ask strobed for what did not come (default: as `strobe key` tells)");
  add_photograph_options(*command, options->photographs);
  command->add_flag("--json", options->json,
                    "one JSON object per readout on standard output, nothing else there");
  command->add_flag("--plain", options->plain, "lines of text instead of a screen");
  command->add_flag(
      "--timing", options->timing,
      "after each shot also how all flashes since the firmware's start were timed, and its clock; "
      "with --json one more object (on a screen they are always shown)");
  command->add_option("--shots", options->shots, "end after this many shots (default 0: never)")
      ->check(CLI::Range(0, 1000000));
  command
      ->add_option("--idle-exit", options->idle_exit_s,
                   "end when nothing was heard for this many seconds (default 0: never)")
      ->check(CLI::Range(0.0, 1e6));
  command->footer(
      "Example: strobe live --rig rig.toml\n         strobe live --rig rig.toml --json --shots 9 > "
      "readouts.jsonl");
  command->callback([options, &exit_status] { exit_status = run_live(*options); });
}

}  // namespace strobe::host
