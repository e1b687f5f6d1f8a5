#include "host/commission/commissioning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

namespace strobe::commission {
namespace {

constexpr Duration kDisarmTimeout = std::chrono::seconds{10};
constexpr Duration kStretch = std::chrono::seconds{60};
/// Of a photograph, beyond the rig file's time for one: it is still to be read.
constexpr Duration kReading = std::chrono::seconds{5};

StepState state_of(const RecordedStep& step) { return step.result.state; }

}  // namespace

std::optional<Answer> answer_of(const Prompt& prompt, std::string_view line) {
  if (line == "q") return Answer::end;
  if (line == "y") return Answer::yes;
  if (line == "n") return Answer::no;
  if (line == "s" && prompt.kind == Prompt::Kind::begin) return Answer::skip;
  if (line.empty() && prompt.kind != Prompt::Kind::question && !prompt.moves) return Answer::yes;
  return std::nullopt;
}

Commissioning::Commissioning(host::HostLoop& loop, CommissioningSettings settings,
                             std::vector<std::unique_ptr<Step>> steps, const Record& former)
    : loop_(loop), settings_(std::move(settings)), entered_(loop.now()) {
  for (auto& step : steps) {
    Work work;
    for (const StepInfo& info : step->infos()) {
      work.views.push_back(views_.size());
      views_.push_back({info, step->needs(), StepState::pending, std::nullopt});
    }
    work.step = std::move(step);
    work_.push_back(std::move(work));
  }
  choose_due(former);
  loop.add_listener(*this);
}

void Commissioning::choose_due(const Record& former) {
  bool reached = settings_.from.empty();
  for (Work& work : work_) {
    bool good = true, named = false, skips = false;
    for (const std::size_t i : work.views) {
      StepView& view = views_[i];
      const Standing stands = standing(former, std::span(&view.info, 1), settings_.rig, settings_.now);
      const Standing::Line& line = stands.lines.front();
      const bool proven =
          line.step != nullptr && state_of(*line.step) == StepState::passed && !line.changed && !line.old;
      if (proven) {
        view.result = line.step->result;
        view.state = StepState::passed;
      }
      good = good && proven;
      named = named || settings_.only.contains(view.info.id);
      skips = skips || settings_.skip.contains(view.info.id);
      reached = reached || view.info.id == settings_.from;
    }
    work.due = !settings_.only.empty() ? named : skips || (settings_.from.empty() ? !good : reached);
  }
}

void Commissioning::step() {
  if (phase_ == Phase::disarming && (!loop_.disarming() || loop_.now() - entered_ > kDisarmTimeout))
    phase_ = Phase::finished;
  if (phase_ == Phase::choosing) choose();
  if (phase_ == Phase::firing) go_on_firing();
  if (phase_ == Phase::running) run();
}

bool Commissioning::passed(const std::string& id) const {
  return std::ranges::any_of(
      views_, [&](const StepView& view) { return view.info.id == id && view.state == StepState::passed; });
}

/// What the step lacks; absent: nothing.
std::optional<std::string> Commissioning::why_not(const Work& work) const {
  const Needs needs = work.step->needs();
  if (!needs.machine) return std::nullopt;
  for (const char* const id : {"key", "key_wire", "estop", "estop_wire"})
    if (!passed(id)) return fmt::format("nothing is thrown before step {} has passed", id);
  return std::nullopt;
}

void Commissioning::choose() {
  while (current_ < work_.size() && !work_[current_].due) ++current_;
  if (current_ == work_.size()) {
    phase_ = Phase::finished;
    return;
  }
  const Work& work = work_[current_];
  for (const std::size_t i : work.views) {
    views_[i].state = StepState::pending;
    views_[i].result.reset();
  }
  for (const std::size_t i : work.views) {
    const auto skip = settings_.skip.find(views_[i].info.id);
    if (skip != settings_.skip.end()) return leave_out("left out: " + skip->second, "", StepState::skipped);
  }
  const Needs needs = work.step->needs();
  if (needs.photographs && loop_.photographs() == nullptr)
    return leave_out("no folder of the camera is known",
                     "name it in [camera] of the rig file, or with --photographs", StepState::skipped);
  if (const auto why = why_not(work))
    return leave_out(*why, "let key and e-stop pass first: strobe commission --from key", StepState::failed);
  ask({Prompt::Kind::begin, work.step->briefing(settings_.rig), needs.outputs || needs.machine});
}

void Commissioning::leave_out(const std::string& words, const std::string& advice, StepState state) {
  StepResult result = skipped(words, advice);
  result.state = state;
  finish_step(std::vector<StepResult>(work_[current_].views.size(), result));
}

void Commissioning::ask(Prompt prompt) {
  phase_ = Phase::asking;
  prompt_ = std::move(prompt);
  set_state(StepState::waiting);
  for (CommissioningListener* listener : listeners_) listener->on_prompt(view(), *prompt_);
  if (settings_.attended) return;
  answer(prompt_->kind == Prompt::Kind::after_failure ? Answer::no : Answer::yes);
}

void Commissioning::answer(Answer given) {
  if (phase_ != Phase::asking || !prompt_) return;
  const Prompt::Kind kind = prompt_->kind;
  prompt_.reset();
  if (given == Answer::end) return stop("the operator");
  loop_.person_acted();
  switch (kind) {
    case Prompt::Kind::begin:
      return given == Answer::yes
                 ? begin()
                 : leave_out("left out by the person at the console", "", StepState::skipped);
    case Prompt::Kind::question:
      work_[current_].step->on_answer(given == Answer::yes);
      phase_ = Phase::running;
      return set_state(StepState::running);
    case Prompt::Kind::after_failure:
      if (given != Answer::yes) return next_step();
      phase_ = Phase::choosing;
      return;
  }
}

void Commissioning::begin() {
  phase_ = Phase::running;
  waiting_.clear();
  set_state(StepState::running);
  work_[current_].step->begin(situation());
}

Situation Commissioning::situation() const {
  const host::Session& session = loop_.session();
  Situation now{loop_.now(), loop_.live_status(), settings_.rig, "", true, 0, false, true, {}};
  now.danger = session.danger();
  now.verified = loop_.verifies();
  now.other_key = loop_.unverified()[authentication::Unverified::other_key];
  now.camera = loop_.photographs() != nullptr;
  now.attended = settings_.attended;
  now.patience = settings_.patience + stretched_;
  return now;
}

void Commissioning::run() {
  Request request = work_[current_].step->step(situation());
  if (const auto* wanted = std::get_if<Wait>(&request)) return wait(wanted->words, wanted->act);
  if (const auto* wanted = std::get_if<Ask>(&request))
    return ask({Prompt::Kind::question, wanted->question, false});
  if (const auto* wanted = std::get_if<Fire>(&request)) return fire(*wanted);
  finish_step(std::move(std::get<Done>(request).results));
}

void Commissioning::wait(const std::string& words, Act act) {
  if (words == waiting_) return;
  waiting_ = words;
  stretched_ = {};
  set_state(act == Act::none ? StepState::running : StepState::waiting);
  for (CommissioningListener* listener : listeners_) listener->on_waiting(view(), words, act);
}

void Commissioning::stretch() { stretched_ += kStretch; }

void Commissioning::fire(const Fire& wanted) {
  wanted_ = wanted;
  result_.reset();
  host::ShotSeriesSettings series;
  series.plan = wanted.plan;
  series.notes = {{"commission", view().info.id}};
  series.blocked_timeout_s = to_seconds(settings_.patience + stretched_);
  series.photograph_timeout_s = settings_.rig.analysis.photograph_timeout_s;
  series_.emplace(series, loop_.commands());
  phase_ = Phase::firing;
  entered_ = loop_.now();
  wait(wanted.words, Act::none);
}

void Commissioning::go_on_firing() {
  if (result_) return deliver();
  const auto status = loop_.live_status();
  series_->on_danger(loop_.session().danger());
  series_->on_second_rig(loop_.second_rig());
  series_->on_unanswered(loop_.unanswered());
  if (status) series_->on_arming_of(loop_.session().host_name(status->arm_host_id), false);
  series_->step(status, loop_.now());
  for (const auto& command : series_->take_commands()) loop_.send(command);
  if (series_->take_disarm()) loop_.disarm("the shot's end");
  static_cast<void>(series_->take_notifications());  // its end is told as the step's result
  if (!series_->blocking_reason().empty() && !series_->finished())
    wait("waiting: " + series_->blocking_reason(), Act::none);
  if (!series_->finished() || result_) return;
  work_[current_].step->on_no_shot(series_->blocking_reason());
  phase_ = Phase::running;
  stopped_in_step_ = rig_stopped();
}

bool Commissioning::rig_stopped() const {
  const auto& status = loop_.session().status();
  return status &&
         (status->estop_active || !status->key_active || status->state == strobe_msgs::status_t::STOPPED);
}

void Commissioning::deliver() {
  const ShotKey key = result_->key();
  const auto* const photograph = photographs_.find(key);
  const Duration longest = from_seconds(settings_.rig.analysis.photograph_timeout_s) + kReading;
  if (wanted_.photograph && photograph == nullptr && loop_.now() - result_at_ < longest) return;
  phase_ = Phase::running;
  delivered_.put(key, true);
  const auto* const shot = shots_.find(key);
  if (shot == nullptr) return work_[current_].step->on_no_shot(result_->problem);
  result_->summary = *shot;
  if (photograph != nullptr) result_->photograph = *photograph;
  work_[current_].step->on_shot(std::move(*result_));
}

void Commissioning::finish_step(std::vector<StepResult> results) {
  bool settled = true;
  assert(results.size() == work_[current_].views.size());
  for (std::size_t i = 0; i < results.size(); ++i) {
    StepView& view = views_[work_[current_].views[i]];
    view.result = std::move(results[i]);
    view.result->id = view.info.id;
    view.state = view.result->state;
    settled = settled && is_settled(view.state);
    for (CommissioningListener* listener : listeners_) listener->on_result(view);
  }
  waiting_.clear();
  if (settled || !settings_.attended) return next_step();
  phase_ = Phase::asking;
  prompt_ = {Prompt::Kind::after_failure, "Do the step again?", false};
  for (CommissioningListener* listener : listeners_) listener->on_prompt(view(), *prompt_);
}

void Commissioning::next_step() {
  // With nobody to say yes anew, nothing goes on after a stop that no step asked for.
  if (!settings_.attended && stopped_in_step_) return end();
  stopped_in_step_ = false;
  ++current_;
  phase_ = Phase::choosing;
}

void Commissioning::set_state(StepState state) {
  for (const std::size_t i : work_[current_].views) views_[i].state = state;
}

void Commissioning::stop(const std::string& by) {
  if (phase_ == Phase::disarming || phase_ == Phase::finished) return;
  if (series_) loop_.disarm(by);
  end();
}

void Commissioning::end() {
  stopped_ = true;
  prompt_.reset();
  if (current_ < work_.size() && !over(view().state)) set_state(StepState::pending);
  phase_ = loop_.disarming() ? Phase::disarming : Phase::finished;
  entered_ = loop_.now();
  if (series_) series_->stop();
}

void Commissioning::on_event(const strobe_msgs::event_t& event) {
  if (phase_ == Phase::firing) series_->on_event(event);
  if (phase_ == Phase::firing || phase_ == Phase::running) work_[current_].step->on_event(event, loop_.now());
}

void Commissioning::on_shot(const strobe_msgs::shot_t& shot) {
  const ShotKey key{shot.boot_id, shot.shot_id};
  if (shot.host_id != loop_.settings().host_id || shots_.find(key) != nullptr) return;
  shots_.put(key, shot);
  if (phase_ != Phase::firing || wanted_.readout || result_) return;
  result_ = host::unmeasured_shot(shot, {}, "");
  result_at_ = loop_.now();
}

void Commissioning::on_shot_result(const host::Shot& result) {
  if (phase_ != Phase::firing || result.host_id != loop_.settings().host_id || result_) return;
  if (delivered_.find({result.boot_id, result.shot_id}) != nullptr) return;  // of a shot before
  series_->on_shot_result(result);
  static_cast<void>(series_->take_notifications());
  result_ = result;
  result_at_ = loop_.now();
}

void Commissioning::on_photograph(const host::KeptPhotograph& kept) {
  photographs_.put(kept.shot, kept.file);
}

}  // namespace strobe::commission
