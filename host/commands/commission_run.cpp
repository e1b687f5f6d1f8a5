#include "host/commands/commission_run.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <optional>

#include "common/config/files.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/commands/command.hpp"
#include "host/commission/commissioning.hpp"
#include "host/commission/steps.hpp"
#include "host/messages/lcm_link.hpp"
#include "host/session/run_lock.hpp"
#include "host/session/session_folder.hpp"
#include "host/web/commission.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;
using commission::Act;
using commission::Answer;
using commission::Commissioning;
using commission::Prompt;
using commission::StepResult;
using commission::StepState;
using commission::StepView;

constexpr Duration kShowEvery = milliseconds{100};

void tell(const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); }

const char* answers_of(const Prompt& prompt) {
  switch (prompt.kind) {
    case Prompt::Kind::begin:
      return prompt.moves ? "y: begin   s: leave it out   q: end" : "Enter: begin   s: leave it out   q: end";
    case Prompt::Kind::question:
      return "y or n";
    case Prompt::Kind::after_failure:
      return "Enter: again   n: go on   q: end";
  }
  return "";
}

/// "passed         lamp_a          lamp A flashes 12.1 ± 0.1 us after its pulse (rig file: 12.0)"
std::string result_line(const StepResult& result) {
  const std::string line =
      fmt::format("{:<14} {:<15} {}", commission::in_words(result.state), result.id, result.words);
  return result.advice.empty() ? line : fmt::format("{}\n{:31}{}", line, "", result.advice);
}

/// What a person at the console sees and says. Never waits.
class CommissionConsole final : public commission::CommissioningListener {
 public:
  explicit CommissionConsole(bool json) : json_(json) {}

  void on_prompt(const commission::StepView& step, const commission::Prompt& prompt) override;
  void on_waiting(const commission::StepView& step, const std::string& words, commission::Act act) override;
  void on_result(const commission::StepView& step) override;

  /// Takes what has been typed: answers, or more time for what is waited for. An end of the input ends it.
  void read(commission::Commissioning& commissioning);

 private:
  void on_line(const std::string& line, commission::Commissioning& commissioning);

  bool json_;
  bool ended_ = false;  ///< the input
  std::string typed_;
};

void CommissionConsole::on_prompt(const StepView& step, const Prompt& prompt) {
  // What was typed before the question was there answers none.
  typed_.clear();
  ::tcflush(STDIN_FILENO, TCIFLUSH);
  if (prompt.kind == Prompt::Kind::begin) tell(fmt::format("\n{}: {}", step.info.id, step.info.title));
  tell("  " + prompt.words);
  tell(fmt::format("  [{}]", answers_of(prompt)));
}

void CommissionConsole::on_waiting(const StepView& step, const std::string& words, Act act) {
  tell(fmt::format("  {}: {}{}", step.info.id, words, act == Act::none ? "" : "   [Enter: a minute more]"));
}

void CommissionConsole::on_result(const StepView& step) {
  std::printf("%s\n", json_ ? commission::result_json(step.info.title, *step.result).c_str()
                            : result_line(*step.result).c_str());
  std::fflush(stdout);
}

void CommissionConsole::read(Commissioning& commissioning) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  if (ended_ || ::poll(&input, 1, 0) <= 0) return;
  std::array<char, 256> bytes{};
  const ssize_t count = ::read(STDIN_FILENO, bytes.data(), bytes.size());
  if (count <= 0) {
    ended_ = true;
    if (commissioning.prompt()) commissioning.answer(Answer::end);
    return;
  }
  typed_.append(bytes.data(), static_cast<std::size_t>(count));
  for (std::size_t end = typed_.find('\n'); end != std::string::npos; end = typed_.find('\n')) {
    on_line(typed_.substr(0, end), commissioning);
    typed_.erase(0, end + 1);
  }
}

void CommissionConsole::on_line(const std::string& line, Commissioning& commissioning) {
  if (const auto& prompt = commissioning.prompt()) {
    if (const auto answer = commission::answer_of(*prompt, line)) return commissioning.answer(*answer);
    return tell(fmt::format("  [{}]", answers_of(*prompt)));
  }
  commissioning.stretch();
  tell("  a minute more");
}

/// The step that is under way or asks; empty: none.
std::string current_step(const Commissioning& commissioning) {
  for (const StepView& view : commissioning.views())
    if (view.state == StepState::running || view.state == StepState::waiting) return view.info.id;
  for (const StepView& view : commissioning.views())
    if (commission::over(view.state) && !commission::is_settled(view.state) && commissioning.prompt())
      return view.info.id;
  return "";
}

/// The page beside the console: shows the run, takes confirmations of what moves nothing, stops.
class CommissionPage final : public HostListener {
 public:
  /// Does nothing if the page is not asked for. Fails as WebPage::open().
  static Result<std::unique_ptr<CommissionPage>> open(const WebOptions& options, const WebSetup& setup,
                                                      const RigFile& rig);

  /// The loop and the commissioning must outlive the page; the page's address is told.
  void attach(HostLoop& loop, Clock& clock);
  /// After each turn: shows what is new, does what viewers ask for.
  void step(HostLoop& loop, commission::Commissioning& commissioning, const web::RunView& frame);

 private:
  CommissionPage() = default;
  void on_shot_result(const Shot& result) override { model_.add(result); }
  void on_notification(const std::string& text) override { model_.add_notification(text); }
  void do_as_asked(HostLoop& loop, commission::Commissioning& commissioning);
  void show(const commission::Commissioning& commissioning, web::RunView view);

  std::optional<web::CommissionRun> run_;  // before the page, whose routes refer to it
  std::unique_ptr<WebPage> page_;
  ViewModel model_;
  HostTime shown_;
};

Result<std::unique_ptr<CommissionPage>> CommissionPage::open(const WebOptions& options, const WebSetup& setup,
                                                             const RigFile& rig) {
  std::unique_ptr<CommissionPage> made(new CommissionPage());
  auto page = WebPage::open(options, setup, rig, [&made](web::Router& router, web::EventHub& hub) {
    made->run_.emplace(hub);
    web::add_run_routes(router, *made->run_);
  });
  if (!page) return tl::unexpected(page.error());
  made->page_ = std::move(*page);
  return made;
}

void CommissionPage::attach(HostLoop& loop, Clock& clock) {
  if (!page_) return;
  loop.add_listener(*this);
  page_->attach(loop, clock);
  std::fprintf(stderr, "strobe: %s\n", page_->address_remark().c_str());
}

void CommissionPage::step(HostLoop& loop, Commissioning& commissioning, const web::RunView& frame) {
  if (!page_) return;
  do_as_asked(loop, commissioning);
  if (loop.now() - shown_ < kShowEvery) return;
  shown_ = loop.now();
  model_.activity = commissioning.waiting();
  static_cast<void>(model_.update(loop.session(), loop.now()));
  page_->step(loop, model_, {0, std::nullopt, !commissioning.finished()});
  show(commissioning, frame);
}

void CommissionPage::show(const Commissioning& commissioning, web::RunView view) {
  view.running = !commissioning.finished();
  view.steps = commissioning.views();
  view.prompt = commissioning.prompt();
  if (view.prompt) view.prompted_step = current_step(commissioning);
  view.waiting = commissioning.waiting();
  run_->show(view);
}

/// What is asked at the console is answered there alone, whatever the routes have let through.
void CommissionPage::do_as_asked(HostLoop& loop, Commissioning& commissioning) {
  for (const web::LiveCommand& command : page_->take_commands()) {
    loop.notify("ended from the page by " + command.from);
    // Whoever armed it: another host may fire.
    if (command.kind == web::LiveCommand::Kind::disarm) loop.disarm("the page at " + command.from);
    commissioning.stop("the page at " + command.from);
  }
  for (const web::CommissionRun::Asked& asked : run_->take_asked()) {
    if (asked.kind == web::CommissionRun::Asked::Kind::more_time) {
      commissioning.stretch();
      continue;
    }
    const auto& prompt = commissioning.prompt();
    if (!prompt || web::asks_at_console(*prompt) || current_step(commissioning) != asked.step) continue;
    loop.notify(fmt::format("{} confirmed from the page by {}", asked.step, asked.from));
    commissioning.answer(Answer::yes);
  }
}

/// Keeps each result, on the disk before the next step begins.
class RecordKeeper final : public commission::CommissioningListener {
 public:
  RecordKeeper(RecordFile& file, const RigFile& rig, Clock& clock)
      : file_(file), rig_(rig), clock_(clock), operator_(operator_name()) {}

  void on_result(const StepView& step) override {
    commission::RecordedStep line;
    line.utc = utc_for_table(clock_.read().wall);
    line.operator_name = operator_;
    line.version = STROBE_VERSION;
    line.rig = rig_.rig;
    line.tables_hash = commission::tables_hash(rig_, step.info.tables);
    line.title = step.info.title;
    line.result = *step.result;
    auto done = file_.append(commission::record_line(line), "a step");
    if (done) done = file_.sync();
    if (!done && problem_.empty()) problem_ = done.error().message;
  }
  const std::string& problem() const { return problem_; }

 private:
  RecordFile& file_;
  const RigFile& rig_;
  Clock& clock_;
  std::string operator_, problem_;
};

/// Keeps the session's files, as `strobe fire` does.
class SessionKeeper final : public HostListener {
 public:
  SessionKeeper(SessionFolder& folder, Clock& clock) : folder_(folder), clock_(clock) {}
  void on_shot(const strobe_msgs::shot_t& shot) override { folder_.add(shot); }
  void on_camera(const tether::OpenedEvent& camera) override {
    folder_.add_camera(tether::to_line(camera), utc_for_table(clock_.read().wall));
  }
  void on_shot_result(const Shot& result) override {
    if (!result.dry) folder_.add(result, utc_for_table(clock_.read().wall));
  }
  void on_notification(const std::string& text) override {
    std::fprintf(stderr, "strobe: %s\n", text.c_str());
  }

 private:
  SessionFolder& folder_;
  Clock& clock_;
};

commission::CommissioningSettings settings_of(const CommissionRequest& request, Clock& clock) {
  commission::CommissioningSettings settings;
  settings.rig = request.rig;
  settings.attended = !request.yes;
  settings.patience = from_seconds(request.wait_s);
  settings.only = request.only;
  settings.from = request.from;
  settings.skip = request.skip;
  settings.now = clock.read().wall;
  return settings;
}

int conclude(const CommissionRequest& request, const Commissioning& commissioning,
             const std::string& problem) {
  int passed = 0, failures = 0, not_told = 0, skipped = 0, open = 0;
  for (const StepView& view : commissioning.views()) {
    passed += view.state == StepState::passed;
    failures += view.state == StepState::failed;
    not_told += view.state == StepState::not_told;
    skipped += view.state == StepState::skipped;
    open += !commission::over(view.state);
  }
  const std::string summary = fmt::format(
      "{} steps passed, {} failed, {} not told apart from a limit, {} left out, {} to do; record in {}",
      passed, failures, not_told, skipped, open, request.record_path);
  if (!problem.empty()) return failed(summary + ": " + problem);
  const bool aborted = commissioning.stopped();
  if (failures == 0 && not_told == 0 && !aborted && (open == 0 || !request.only.empty())) {
    std::fprintf(stderr, "strobe: %s\n", summary.c_str());
    return kDone;
  }
  return failed(fmt::format("{}; go on with: strobe commission --rig {} --session {}", summary,
                            request.paths.rig_path, request.session));
}

int run(const CommissionRequest& request, SessionFolder& folder, RecordFile& record_file,
        const commission::Record& former, CommissionPage& page, Transport& link, Clock& clock) {
  LoggedTransport transport(link, folder, clock);
  HostLoopSettings loop_settings{
      request.rig.rig, assembly_settings(request.rig), random_host_id(), true, request.key, false,
      operator_name()};
  HostLoop loop(loop_settings, transport, clock);
  auto photographs = open_pipeline(request.rig, request.photographs, request.session, loop_settings.host_id,
                                   loop.session().clock(), clock.read());
  if (!photographs) return bad_input(photographs.error().message);
  loop.set_photographs(std::move(*photographs));
  SessionKeeper session(folder, clock);
  loop.add_listener(session);
  Commissioning commissioning(loop, settings_of(request, clock), commission::all_steps(), former);
  RecordKeeper record(record_file, request.rig, clock);
  CommissionConsole console(request.json);
  commissioning.add_listener(record);
  commissioning.add_listener(console);
  page.attach(loop, clock);
  web::RunView frame;
  frame.rig = request.rig.rig;
  frame.utc = utc_for_table(clock.read().wall);
  frame.operator_name = operator_name();
  frame.max_age_days = request.rig.commission.max_age_days;
  std::fprintf(stderr, "strobe: commissioning rig %s on %s; session %s, record %s\n", request.rig.rig.c_str(),
               request.paths.url.c_str(), request.session.c_str(), request.record_path.c_str());
  bool receiving = true;
  while (!commissioning.finished() && record.problem().empty() && (receiving = loop.run_once())) {
    if (interrupted()) commissioning.stop("the operator");
    if (!request.yes) console.read(commissioning);
    commissioning.step();
    page.step(loop, commissioning, frame);
    folder.tend();
  }
  loop.end_photographs();
  folder.close();
  std::string problem = record.problem();
  if (const auto kept =
          keep_commission_record(request.paths.rig_path, request.rig, request.session, clock.read().wall);
      !kept && problem.empty())
    problem = kept.error().message;
  if (!receiving) problem = "LCM cannot receive any more";
  for (const std::string& line : folder.unstored()) problem += (problem.empty() ? "" : "; ") + line;
  return conclude(request, commissioning, problem);
}

}  // namespace

int run_commission(const CommissionRequest& request) {
  MachineClock clock;
  const auto session_lock = RunLock::of_session(request.session, operator_name(), clock.read().wall);
  if (!session_lock) return bad_input(session_lock.error().message);
  const auto record_lock = RunLock::take(request.record_path + ".lock", operator_name(), clock.read().wall);
  if (!record_lock) return bad_input(record_lock.error().message);
  const auto former = commission::read_record(request.record_path);
  if (!former) return bad_input(former.error().message);
  for (const std::string& remark : former->remarks) std::fprintf(stderr, "strobe: %s\n", remark.c_str());
  auto page = CommissionPage::open(
      request.web, {"commission", STROBE_VERSION, request.session, request.paths.key_file, std::nullopt},
      request.rig);
  if (!page) return bad_input(page.error().message);
  auto record_file = RecordFile::open(request.record_path, RecordFile::Use::append);
  if (!record_file) return bad_input(record_file.error().message);
  // What a power cut tore stays a line of its own.
  if (former->torn)
    if (const auto ended = record_file->append("\n", "a line's end"); !ended)
      return bad_input(ended.error().message);
  auto folder = SessionFolder::open(
      request.session, utc_for_file(clock.read().wall), request.rig.text, plan_to_toml(request.rig.plan),
      {request.rig.camera.calibration.value_or(""), request.rig.calibration_text},
      {kept_ball_file(request.rig.ball), request.rig.ball_text});
  if (!folder) return bad_input(folder.error().message);
  auto link = LcmLink::open(request.paths.url, request.rig.rig);
  if (!link) return failed(link.error().message);
  catch_signals();
  return run(request, **folder, *record_file, *former, **page, **link, clock);
}

Result<std::string> keep_commission_record(const fs::path& rig_path, const RigFile& rig,
                                           const fs::path& session, WallTime now) {
  if (rig_path.empty()) return std::string();
  const fs::path path = commission::record_path(rig_path, rig.commission);
  commission::Record record;
  std::error_code error;
  const auto text = config::read_file_if_any(path);
  if (!text) return tl::unexpected(text.error());
  if (*text) {
    record = commission::parse_record(**text);
    const fs::path copy = session / commission::kRecordInSession;
    const bool same = fs::exists(copy, error) && config::read_file(copy.string()) == **text;
    if (!same)
      if (auto written = config::write_file(copy, **text); !written) return tl::unexpected(written.error());
  }
  const auto stands = commission::standing(record, commission::all_infos(), rig, now);
  if (stands.state == commission::Standing::State::good) return std::string();
  return "the rig is " + stands.words + " (see strobe commission)";
}

}  // namespace strobe::host
