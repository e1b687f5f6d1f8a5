#include "host/commands/fire_run.hpp"

#include <fmt/format.h>

#include "host/clock/machine_clock.hpp"
#include "host/commands/command.hpp"
#include "host/loop/stored_series.hpp"
#include "host/messages/lcm_link.hpp"

namespace strobe::host {
namespace {

/// What has lasted for so long is told to a person who sees no screen.
constexpr Duration kLasting = std::chrono::seconds{2};

/// Whether strobed has another key than this host: nothing of it can be believed, not even its status.
class KeyCheck {
 public:
  /// Returns true once, when the keys turn out to differ.
  bool update(const HostLoop& loop) {
    if (told_ || loop.session().status() || loop.unverified()[authentication::Unverified::other_key] == 0)
      return false;
    return told_ = true;
  }

 private:
  bool told_ = false;
};

/// Prints, where there is no screen, what has lasted for two seconds.
class ActivityNotes {
 public:
  std::optional<std::string> update(const ShotSeries& series, HostTime now) {
    const std::string activity =
        series.blocking_reason().empty() ? series.activity() : "waiting: " + series.blocking_reason();
    if (activity != activity_) {
      activity_ = activity;
      since_ = now;
      told_ = false;
    }
    if (told_ || series.finished() || now - since_ < kLasting) return std::nullopt;
    told_ = true;
    return activity_;
  }

 private:
  std::string activity_;
  HostTime since_;
  bool told_ = false;
};

/// What a person reads of a series tells what its shots share.
AssemblySettings assembly_of(const FireRequest& request) {
  AssemblySettings settings = assembly_settings(request.rig);
  settings.budgets = request.style != Terminal::Style::json;
  return settings;
}

class FireRun {
 public:
  FireRun(const FireRequest& request, SessionFolder& folder, Transport& link, Clock& clock,
          std::int64_t host_id)
      : request_(request),
        stored_({request.rig.rig, assembly_of(request), host_id, true, request.key}, request.series, folder,
                link, clock),
        loop_(stored_.loop()),
        runner_(stored_.runner()),
        terminal_(request.style,
                  fmt::format("strobe fire   rig {}   session {}", request.rig.rig, request.session)) {
    loop_.add_listener(terminal_);
    terminal_.show_only(host_id);
    terminal_.model().thesis = request.condition;
    terminal_.model().all = request.all;
  }

  HostLoop& loop() { return loop_; }

  int run() try { return fire(); } catch (const std::exception&) {
    terminal_.close();
    stored_.abandon();
    throw;
  }

 private:
  int fire() {
    terminal_.open();
    terminal_.note(fmt::format("session {}, rig {} on {}", request_.session, request_.rig.rig, request_.url));
    if (!request_.train_remark.empty()) loop_.notify(request_.train_remark);
    bool receiving = true;
    while (!runner_.finished() && (receiving = stored_.run_once())) {
      if (interrupted()) stop();
      check_output();
      check_key();
      show();
    }
    if (!receiving) loop_.notify("LCM cannot receive any more");
    loop_.end_photographs();
    stored_.close();
    report_missing_events();
    terminal_.close();
    return conclude();
  }

  void stop() {
    if (runner_.stop()) loop_.notify("interrupted: disarming");
  }

  /// Readouts that nobody gets are no reason to throw on.
  void check_output() {
    if (const auto problem = terminal_.output_problem()) runner_.end_after_shot(*problem);
  }

  void check_key() {
    if (!key_.update(loop_)) return;
    terminal_.note(
        fmt::format("a firmware here has another key than this host, and is not believed: it tells its key's "
                    "fingerprint at its start, this host's is {} (see strobe key, --key-file)",
                    request_.key.fingerprint()));
  }

  void show() {
    const ShotSeries& series = runner_.series();
    terminal_.model().activity = series.activity();
    terminal_.model().blocking_reason = series.blocking_reason();
    if (const auto note = activity_.update(series, loop_.now())) terminal_.note(*note);
    if (!recovery_told_ && runner_.recovering_for() > kLasting) {
      recovery_told_ = true;
      terminal_.note(fmt::format("fetching {} events that were lost on the way", missing_events()));
    }
    terminal_.show(loop_);
  }

  std::int64_t missing_events() const { return loop_.session().ledger().missing(); }

  void report_missing_events() {
    if (runner_.finished() && missing_events() > 0)
      terminal_.note(fmt::format("{} events are still missing here", missing_events()));
  }

  int conclude() {
    const ShotSeries& series = runner_.series();
    if (request_.style != Terminal::Style::json && !request_.series.plan.dry)
      print(render_series(terminal_.model().series, request_.condition, kPlainWidth, request_.all));
    const std::string summary =
        fmt::format("{} of {} shots came, {} fired again; session in {}", series.good(),
                    request_.series.shots, series.refired(), request_.session);
    std::string problem = series.succeeded() ? "" : series.blocking_reason();
    for (const std::string& line : stored_.unstored()) problem += (problem.empty() ? "" : "; ") + line;
    if (!series.succeeded() || !problem.empty())
      return failed(summary + (problem.empty() ? "" : ": " + problem));
    std::fprintf(stderr, "strobe: %s\n", summary.c_str());
    return kDone;
  }

  const FireRequest& request_;
  StoredSeries stored_;
  HostLoop& loop_;
  SeriesRunner& runner_;
  Terminal terminal_;
  KeyCheck key_;
  ActivityNotes activity_;
  bool recovery_told_ = false;
};

}  // namespace

int run_fire(const FireRequest& request) {
  MachineClock clock;
  auto folder = SessionFolder::open(
      request.session, utc_for_file(clock.read().wall), request.rig.text, request.plan_text,
      {request.rig.camera.calibration.value_or(""), request.rig.calibration_text});
  if (!folder) return bad_input(folder.error().message);
  auto link = LcmLink::open(request.url, request.rig.rig);
  if (!link) return failed(link.error().message);
  catch_signals();
  FireRun run(request, **folder, **link, clock, random_host_id());
  auto photographs = open_pipeline(request.rig, request.photographs, request.session,
                                   run.loop().settings().host_id, run.loop().session().clock(), clock.read());
  if (!photographs) return bad_input(photographs.error().message);
  run.loop().set_photographs(std::move(*photographs));
  return run.run();
}

}  // namespace strobe::host
