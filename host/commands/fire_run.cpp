#include "host/commands/fire_run.hpp"

#include <fmt/format.h>

#include "host/clock/machine_clock.hpp"
#include "host/commands/command.hpp"
#include "host/commands/commission_run.hpp"
#include "host/commands/drift_watch.hpp"
#include "host/commands/shot_text.hpp"
#include "host/commands/until_known.hpp"
#include "host/loop/series_runner.hpp"
#include "host/messages/lcm_link.hpp"
#include "host/web/commission.hpp"

namespace strobe::host {
namespace {

/// What has lasted for so long is told to a person who sees no screen.
constexpr Duration kLasting = std::chrono::seconds{2};

/// Prints, where there is no screen, what has lasted for two seconds.
class ActivityNotes {
 public:
  std::optional<std::string> update(const ShotSeries& series, HostTime now) {
    const std::string activity =
        series.blocking_reason().empty() ? series.activity() : "waiting: " + series.blocking_reason();
    if (activity != activity_) {
      activity_ = activity;
      since_ = now;
      reported_ = false;
    }
    if (reported_ || series.finished() || now - since_ < kLasting) return std::nullopt;
    reported_ = true;
    return activity_;
  }

 private:
  std::string activity_;
  HostTime since_;
  bool reported_ = false;
};

/// What a person reads of a series tells what its shots share.
AssemblySettings assembly_of(const FireRequest& request) {
  AssemblySettings settings = assembly_settings(request.rig);
  settings.budgets = request.style != Terminal::Style::json || request.options.web.on;
  return settings;
}

class FireRun final : private HostListener {
 public:
  /// page: null: none.
  FireRun(const FireRequest& request, const std::string& commissioned, SessionFolder& folder, Transport& link,
          Clock& clock, std::int64_t host_id, WebPage* page)
      : request_(request),
        page_(page),
        commissioned_(commissioned),
        folder_(folder),
        clock_(clock),
        stored_({request.rig.rig, assembly_of(request), host_id, true, request.key, false,
                 request.run.operator_name, request.run.until_known},
                request.series, folder, link, clock),
        loop_(stored_.loop()),
        runner_(stored_.runner()),
        terminal_(request.style, fmt::format("strobe fire   rig {}   session {}   {}", request.rig.rig,
                                             request.options.session, request.options.heading)),
        shot_text_(folder, clock, [this](std::int64_t host) { return shown(host); }),
        drift_watch_(loop_, [this](std::int64_t host) { return shown(host); }) {
    loop_.person_acted(request.asked);
    loop_.add_listener(terminal_);
    loop_.add_listener(shot_text_);
    if (!request.wanted.empty()) {
      until_known_.emplace(request.wanted, std::make_shared<const RigFile>(request.rig), request.earlier);
      loop_.add_listener(*this);  // after those that show the shot
    }
    loop_.add_listener(drift_watch_);
    terminal_.show_only([this](std::int64_t host) { return shown(host); });
    terminal_.model().thesis = request.condition;
    terminal_.model().all = request.options.all;
    runner_.set_on_begin([this] { record_run(); });
    if (page_) serve();
  }

  HostLoop& loop() { return loop_; }

  int run() try {
    if (const auto& error = stored_.former_error()) return bad_input(error->message);
    return fire();
  } catch (const std::exception&) {
    terminal_.close();
    stored_.abandon();
    throw;
  }

 private:
  int fire() {
    terminal_.open();
    tell(fmt::format("session {}, rig {} on {}", request_.options.session, request_.rig.rig,
                     request_.options.paths.url));
    if (!request_.rig_remark.empty()) tell(request_.rig_remark);
    if (!commissioned_.empty()) tell(commissioned_);
    if (!request_.options.heading.empty()) loop_.notify(request_.options.heading);
    if (runner_.taking_in())
      tell("looking for shots that earlier runs in this session left without a result");
    if (!request_.train_remark.empty()) loop_.notify(request_.train_remark);
    bool receiving = true;
    while (!runner_.finished() && (receiving = stored_.run_once())) {
      obey_signals();
      obey_page();
      check_output();
      check_key();
      show();
    }
    if (!receiving) loop_.notify("LCM cannot receive any more");
    loop_.end_photographs();
    stored_.close();
    show();  // on the page, too: how it ended
    report_missing_events();
    terminal_.close();
    return conclude();
  }

  /// This run's, and those that it takes over from earlier ones.
  bool shown(std::int64_t host) const {
    return host == loop_.settings().host_id || loop_.session().adopted(host);
  }

  /// Ends the series as soon as enough is known, or can never be.
  void on_shot_result(const Shot& result) override {
    if (!shown(result.host_id) || result.rejected || result.dry) return;
    until_known_->add(result);
    const std::string never = until_known_->why_never();
    if (!never.empty()) {
      ended_by_ = never;
      never_known_ = true;
      return runner_.end_after_shot(never);
    }
    loop_.notify(until_known_->line());
    if (!until_known_->enough()) return;
    runner_.settle();
  }

  /// For a person, now and in the session.
  void tell(const std::string& text) {
    terminal_.note(text);
    shot_text_.add(text);
  }

  /// Before its first shot.
  void record_run() {
    RunRecord run = request_.run;
    run.utc = utc_for_table(clock_.read().wall);
    run.host_id = loop_.settings().host_id;
    run.plan_file = folder_.plan_file();
    run.session_shots = run.until ? run.shots : runner_.counted_before() + run.shots;
    folder_.add(run);
    recorded_ = true;
    const std::string known =
        run.until_known.empty() ? "" : fmt::format(", at most, until known: {}", run.until_known);
    shot_text_.add(
        fmt::format("{} fires {} {}{}", run.operator_name, run.until ? "until" : "shots:", run.shots, known));
  }

  /// The first finishes the shot under way; the second, or Ctrl-\, ends all at once.
  void obey_signals() {
    const int asked = ends_asked_for();
    if (asked == obeyed_) return;
    obeyed_ = asked;
    if (asked == 1) return end_after_shot("interrupted");
    if (left_by_ && asked >= *left_by_) return runner_.leave();
    left_by_ = asked + 1;
    loop_.notify("stopping at once; once more to leave without the rig's confirmation");
    end_at_once("interrupted");
  }

  void end_after_shot(const std::string& why) {
    ended_by_ = why;
    if (runner_.firing() && runner_.series().shot_under_way()) {
      loop_.notify(fmt::format("finishing shot {}; press Ctrl-C again to stop at once",
                               runner_.series().shot_number()));
      return runner_.end_after_shot(why);
    }
    if (!runner_.stop("the operator (" + why + ")"))
      loop_.notify("fetching lost events; press Ctrl-C again to stop at once");
  }

  void end_at_once(const std::string& why) {
    ended_by_ = why;
    runner_.stop_at_once("the operator (" + why + ")");
  }

  void serve() {
    page_->attach(loop_, clock_, [this](std::int64_t host) { return shown(host); });
    terminal_.model().title += "   page " + page_->url();
    terminal_.on_notification(page_->address_remark());
  }

  /// Stopping does as the first Ctrl-C, disarming as the second.
  void obey_page() {
    if (!page_) return;
    for (const web::LiveCommand& command : page_->take_commands()) {
      if (command.kind == web::LiveCommand::Kind::disarm) {
        loop_.notify("to be disarmed from the page by " + command.from);
        end_at_once("disarmed from the page");
      } else if (ended_by_.empty()) {
        loop_.notify("stopped from the page by " + command.from);
        end_after_shot("stopped from the page");
      }
    }
  }

  /// Readouts that nobody gets are no reason to throw on.
  void check_output() {
    if (const auto problem = terminal_.output_problem()) runner_.end_after_shot(*problem);
  }

  /// Where strobed has another key than this host nothing of it can be believed, not even its status.
  void check_key() {
    if (key_reported_ || loop_.session().status() ||
        loop_.unverified()[authentication::Unverified::other_key] == 0)
      return;
    key_reported_ = true;
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
    if (!recovery_reported_ && runner_.recovering_for() > kLasting) {
      recovery_reported_ = true;
      terminal_.note(fmt::format("fetching {} events that were lost on the way", missing_events()));
    }
    terminal_.show(loop_);
    if (!page_) return;
    const bool can_stop = ended_by_.empty() && (runner_.firing() || runner_.taking_in());
    page_->step(loop_, terminal_.model(), {series.good(), request_.series.shots, can_stop});
  }

  std::int64_t missing_events() const { return loop_.session().ledger().missing(); }

  void report_missing_events() {
    if (runner_.finished() && missing_events() > 0)
      terminal_.note(fmt::format("{} events are still missing here", missing_events()));
  }

  void print_series() {
    if (request_.style == Terminal::Style::json || terminal_.model().series.counted() == 0) return;
    print(render_series(terminal_.model().series, request_.condition, kPlainWidth, request_.options.all));
    if (request_.series.counted > 0)
      print({fmt::format("  These are this run's shots. All of the session's: strobe series {}",
                         request_.options.session)});
  }

  /// "3 of 9 shots counted", "12 shots counted, so that e ± 0.0029 of 0.003 wanted"
  std::string counted_words() const {
    const ShotSeries& series = runner_.series();
    const int shots = until_known_ ? series.good() : request_.series.shots;
    const std::string words = fmt::format("{} {}", shots == 1 ? "shot" : "shots",
                                          request_.series.plan.dry ? "fired dry" : "counted");
    if (!until_known_) return fmt::format("{} of {} {}", series.good(), shots, words);
    return fmt::format("{} {}{}", shots, words,
                       until_known_->enough() ? ", enough to know " + until_known_->line() : "");
  }

  int conclude() {
    const ShotSeries& series = runner_.series();
    const bool dry = request_.series.plan.dry;
    if (!dry) print_series();
    const bool succeeded = series.succeeded() && (!until_known_ || until_known_->enough());
    const std::string summary = fmt::format("{}, {} fired again; session in {}", counted_words(),
                                            series.refired(), request_.options.session);
    std::string problem = succeeded ? "" : series.blocking_reason();
    if (!ended_by_.empty() && !succeeded) problem = ended_by_;
    if (series.succeeded() && !succeeded)
      problem = fmt::format("not known after the {} shots that are the most: {}", series.good(),
                            until_known_->line());
    if (loop_.disarming())
      problem += (problem.empty() ? "" : "; ") +
                 std::string("DISARM NOT CONFIRMED: the rig may still be armed; press the e-stop");
    for (const std::string& line : stored_.unstored()) problem += (problem.empty() ? "" : "; ") + line;
    if (succeeded && problem.empty()) {
      std::fprintf(stderr, "strobe: %s\n", summary.c_str());
      return kDone;
    }
    const std::string how_on =
        series.succeeded() || !request_.options.protocol.empty() || dry || !recorded_ || never_known_
            ? ""
            : fmt::format("; go on with: strobe fire --resume --session {}", request_.options.session);
    return failed(summary + (problem.empty() ? "" : ": " + problem) + how_on);
  }

  const FireRequest& request_;
  WebPage* const page_;              ///< null: none
  const std::string& commissioned_;  ///< what a person should know of the rig's commissioning
  SessionFolder& folder_;
  Clock& clock_;
  StoredSeries stored_;
  HostLoop& loop_;
  SeriesRunner& runner_;
  Terminal terminal_;
  ShotText shot_text_;
  DriftWatch drift_watch_;
  int obeyed_ = 0;              ///< of ends_asked_for()
  std::optional<int> left_by_;  ///< of ends_asked_for(): then nothing is waited for any more
  std::string ended_by_;        ///< why the series ends before its time; empty: it does not
  bool recorded_ = false;       ///< there is a run to go on with
  std::optional<UntilKnown> until_known_;
  bool never_known_ = false;
  bool key_reported_ = false;
  ActivityNotes activity_;
  bool recovery_reported_ = false;
};

/// Whether what a run that is gone on with wants is known already.
bool known_already(const FireRequest& request) {
  if (request.wanted.empty() || !request.options.resume) return false;
  return UntilKnown(request.wanted, nullptr, request.earlier).enough();
}

/// Whether the session holds all shots that are wanted, and nothing is left to take in.
Result<bool> already_there(const FireRequest& request) {
  const ShotSeriesSettings& series = request.series;
  const bool enough = series.counted >= series.shots || known_already(request);
  if (!series.whole_session || !enough) return false;
  const auto former = read_former_runs(request.options.session, request.rig.rig, request.key);
  if (!former) return tl::unexpected(former.error());
  return !former->may_lack_results();
}

}  // namespace

int run_fire(const FireRequest& request) {
  const auto there = already_there(request);
  if (!there) return bad_input(there.error().message);
  if (*there) {
    const bool known = known_already(request);
    const std::string wanted = known ? ", enough to know " + request.run.until_known
                                     : fmt::format(", of {} wanted", request.series.shots);
    std::fprintf(stderr, "strobe: session %s holds %d shots that count%s: nothing is fired\n",
                 request.options.session.c_str(), request.series.counted, wanted.c_str());
    return request.wanted.empty() || known ? kDone : kFailed;
  }
  auto page = WebPage::open(request.options.web,
                            {"fire", request.run.version, request.options.session,
                             request.options.paths.key_file, request.condition},
                            request.rig, [&](web::Router& router, web::EventHub&) {
                              web::add_record_route(router, request.run.rig_file);
                            });
  if (!page) return bad_input(page.error().message);
  MachineClock clock;
  auto folder = SessionFolder::open(
      request.options.session, utc_for_file(clock.read().wall), request.rig.text, request.plan_text,
      {request.rig.camera.calibration.value_or(""), request.rig.calibration_text},
      {kept_ball_file(request.rig.ball), request.rig.ball_text});
  if (!folder) return bad_input(folder.error().message);
  const auto commissioned =
      keep_commission_record(request.run.rig_file, request.rig, request.options.session, clock.read().wall);
  if (!commissioned) return bad_input(commissioned.error().message);
  auto link = LcmLink::open(request.options.paths.url, request.rig.rig);
  if (!link) return failed(link.error().message);
  catch_signals();
  FireRun run(request, *commissioned, **folder, **link, clock, random_host_id(), page->get());
  PhotographOptions photograph_options = request.options.photographs;
  photograph_options.exposure_s = to_seconds(request.series.plan.exposure);
  auto photographs = open_pipeline(request.rig, photograph_options, request.options.session,
                                   run.loop().settings().host_id, run.loop().session().clock(), clock.read());
  if (!photographs) return bad_input(photographs.error().message);
  run.loop().set_photographs(std::move(*photographs));
  return run.run();
}

}  // namespace strobe::host
