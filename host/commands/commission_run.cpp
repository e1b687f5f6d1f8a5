#include "host/commands/commission_run.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "host/clock/machine_clock.hpp"
#include "host/commands/command.hpp"
#include "host/commands/commission_console.hpp"
#include "host/commands/commission_page.hpp"
#include "host/commands/kept_record.hpp"
#include "host/commands/operator_name.hpp"
#include "host/commands/terminal.hpp"
#include "host/commission/all_steps.hpp"
#include "host/commission/commissioning.hpp"
#include "host/messages/lcm_link.hpp"
#include "host/session/logged_transport.hpp"
#include "host/session/run_lock.hpp"

namespace strobe::host {
namespace {

using commission::Commissioning;
using commission::StepState;
using commission::StepView;

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
  void on_shot_result(const ShotResult& result) override {
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
  int passed = 0, failures = 0, skipped = 0, open = 0;
  for (const StepView& view : commissioning.views()) {
    passed += view.state == StepState::passed;
    failures += view.state == StepState::failed;
    skipped += view.state == StepState::skipped;
    open += !commission::over(view.state);
  }
  const std::string summary = fmt::format("{} steps passed, {} failed, {} left out, {} to do; record in {}",
                                          passed, failures, skipped, open, request.record_path);
  if (!problem.empty()) return failed(summary + ": " + problem);
  const bool aborted = commissioning.stopped();
  if (failures == 0 && !aborted && (open == 0 || !request.only.empty())) {
    std::fprintf(stderr, "strobe: %s\n", summary.c_str());
    return kDone;
  }
  return failed(fmt::format("{}; go on with: strobe commission --rig {} --session {}", summary,
                            request.rig_path, request.session));
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
               request.url.c_str(), request.session.c_str(), request.record_path.c_str());
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
          keep_commission_record(request.rig_path, request.rig, request.session, clock.read().wall);
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
      request.web, {"commission", STROBE_VERSION, request.session, request.key_file, std::nullopt},
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
      {request.rig.camera.calibration.value_or(""), request.rig.calibration_text});
  if (!folder) return bad_input(folder.error().message);
  auto link = LcmLink::open(request.url, request.rig.rig);
  if (!link) return failed(link.error().message);
  catch_signals();
  return run(request, **folder, *record_file, *former, **page, **link, clock);
}

}  // namespace strobe::host
