#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <memory>
#include <optional>

#include "common/authentication/key_file.hpp"
#include "common/command_line/command_line.hpp"
#include "common/config/default_rig.hpp"
#include "common/wire/lcm_url.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/commands/command.hpp"
#include "host/commands/shared_options.hpp"
#include "host/commands/terminal.hpp"
#include "host/commands/web_page.hpp"
#include "host/config/rig_file.hpp"
#include "host/loop/host_loop.hpp"
#include "host/messages/lcm_link.hpp"
#include "host/view/timing.hpp"
#include "host/web/commission.hpp"

namespace strobe::host {
namespace {

struct LiveOptions {
  std::string rig_path;
  std::string url;
  std::string key_file;
  PhotographOptions photographs;
  bool json = false;
  bool plain = false;
  bool timing = false;
  bool unverified = false;
  bool all = false;
  int shots = 0;
  double idle_exit_s = 0.0;
  WebOptions web;
};

/// Prints the timing after each shot, as the first heartbeat after it tells: it counts the shot's flashes.
class TimingReport final : public HostListener {
 public:
  TimingReport(HostLoop& loop, Terminal& terminal, bool json)
      : loop_(loop), terminal_(terminal), json_(json) {}

  void on_shot_result(const Shot& result) override {
    after_shot_ = result.shot_id;
    status_heard_ = loop_.session().status_heard();
  }
  /// Whether one is still to be printed: not if the firmware is silent.
  bool due() const { return after_shot_ && loop_.live_status(); }
  void step() {
    const auto& status = loop_.session().status();
    if (!after_shot_ || !status || loop_.session().status_heard() <= status_heard_) return;
    if (json_) {
      print({timing_json(*status, terminal_.model().clock, *after_shot_, loop_.unverified())});
    } else {
      print(render_timing(*status));
    }
    after_shot_.reset();
  }

 private:
  HostLoop& loop_;
  Terminal& terminal_;
  bool json_;
  std::optional<int> after_shot_;
  HostTime status_heard_;  ///< of the newest heartbeat when the result came
};

/// Tells how many events are missing once nothing has changed for five seconds.
class MissingNotes {
 public:
  std::optional<std::string> update(std::int64_t missing, HostTime now) {
    constexpr Duration kSettled = std::chrono::seconds{5};
    if (missing != missing_) since_ = now;
    missing_ = missing;
    if (missing <= reported_ || now - since_ < kSettled) return std::nullopt;
    reported_ = missing;
    return fmt::format("{} events did not arrive here", missing);
  }

 private:
  std::int64_t missing_ = 0, reported_ = 0;
  HostTime since_;
};

void step(WebPage& page, HostLoop& loop, const ViewModel& model) {
  for (const web::LiveCommand& command : page.take_commands()) {
    if (command.kind == web::LiveCommand::Kind::disarm) loop.disarm("the page at " + command.from);
  }
  page.step(loop, model, {model.series.counted(), std::nullopt, false});
}

/// Not left before a DISARM is confirmed, unless the operator insists.
bool waits_for_disarm(const HostLoop& loop) { return loop.disarming() && ends_asked_for() < 2; }

/// Returns false if nothing can be received any more.
bool watch(HostLoop& loop, Terminal& terminal, TimingReport* timing, WebPage* page,
           const LiveOptions& options) {
  const Duration idle = from_seconds(options.idle_exit_s);
  MissingNotes missing;
  while (!interrupted() || waits_for_disarm(loop)) {
    if (!loop.run_once()) return false;
    terminal.show(loop);
    if (page) step(*page, loop, terminal.model());
    if (timing) timing->step();
    if (terminal.output_problem()) break;
    if (const auto note = missing.update(terminal.model().events_missing, loop.now())) terminal.note(*note);
    const bool enough = options.shots > 0 && terminal.model().shots >= options.shots;
    if (enough && !(timing && timing->due())) break;
    if (idle > Duration{} && loop.now() - loop.last_message() > idle) break;
  }
  return true;
}

int run_live(const LiveOptions& options) {
  const auto rig = load_rig(options.rig_path);
  if (!rig) return bad_input(rig.error().message);
  const std::string url = lcm_url(options.url, *rig);
  const auto key = authentication::find_key({options.key_file, rig->key_file.value_or("")});
  HostLoopSettings settings{rig->rig, assembly_settings(*rig), random_host_id()};
  settings.assembly.budgets = !options.json || options.web.on;
  if (key && !options.unverified) settings.key = key->key;
  auto page = WebPage::open(
      options.web, {"live", STROBE_VERSION, "", options.key_file}, *rig,
      [&](web::Router& router, web::EventHub&) { web::add_record_route(router, options.rig_path); });
  if (!page) return bad_input(page.error().message);
  MachineClock clock;
  auto link = LcmLink::open(url, rig->rig);
  if (!link) return failed(link.error().message);
  HostLoop loop(settings, **link, clock);
  auto photographs =
      open_pipeline(*rig, options.photographs, "", settings.host_id, loop.session().clock(), clock.read());
  if (!photographs) return bad_input(photographs.error().message);
  loop.set_photographs(std::move(*photographs));
  catch_signals();
  Terminal terminal(Terminal::style(options.json, options.plain),
                    fmt::format("strobe live   rig {}", rig->rig), options.shots);
  terminal.model().all = options.all;
  loop.add_listener(terminal);
  if (*page) {
    (*page)->attach(loop, clock);
    terminal.model().title += "   page " + (*page)->url();
    terminal.on_notification((*page)->address_remark());
  }
  terminal.open();
  TimingReport timing(loop, terminal, options.json);
  const bool with_timing = options.timing && !terminal.owns_screen();
  if (with_timing) loop.add_listener(timing);
  if (const auto words = config::example_remark(options.rig_path, "--rig"); !words.empty())
    terminal.note(words);
  terminal.note(fmt::format("listening to rig {} on {}", rig->rig, url));
  if (!loop.verifies()) {
    loop.notify("unverified: anybody's messages are shown, and what is lost on the way cannot be asked for" +
                (key ? "" : ": " + key.error().message));
  }
  const bool receiving = watch(loop, terminal, with_timing ? &timing : nullptr, page->get(), options);
  terminal.close();
  if (!receiving) return failed("LCM cannot receive any more");
  if (!options.json && terminal.model().series.counted() > 0)
    print(render_series(terminal.model().series, std::nullopt, kPlainWidth, options.all));
  if (terminal.output_problem()) return failed(*terminal.output_problem());
  return terminal.model().shots < options.shots ? kFailed : kDone;
}

}  // namespace

void add_live_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<LiveOptions>();
  CLI::App* command =
      app.add_subcommand("live", "Watch a session: each shot's readout, the series, the firmware");
  command->add_option("--rig", options->rig_path, "rig file (default: the example that comes with strobe)");
  command->add_option("--lcm-url", options->url, "LCM URL (default: the rig file's, else this computer only)")
      ->check(wire::lcm_url_problem);
  command->add_option(
      "--key-file", options->key_file,
      "the lab's key, to know its messages and to ask strobed for what did not come (default: as "
      "`strobe key` tells)");
  command->add_flag("--unverified", options->unverified,
                    "watch without a key: show everybody's messages, the lab's or not, marked as unverified");
  add_photograph_options(*command, options->photographs);
  command->add_flag("--json", options->json,
                    "one JSON object per readout on standard output, nothing else there");
  command->add_flag("--plain", options->plain, "lines of text instead of a screen");
  command->add_flag("--all", options->all, kAllHelp);
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
  add_web_options(*command, options->web);
  command_line::for_experts(*command, {"--effort", "--lcm-url", "--key-file", "--timing", "--idle-exit",
                                       "--unverified", "--all", "--sessions"});
  command->footer(
      "Example: strobe live --rig rig.toml --web\n         strobe live --rig rig.toml --json --shots 9 > "
      "readouts.jsonl");
  command->callback([options, &exit_status] { exit_status = run_live(*options); });
}

}  // namespace strobe::host
