#include "host/loop/series_runner.hpp"

#include <utility>

namespace strobe::host {
namespace {

// The first status may take half of it: nothing is missing before it had time to come.
constexpr Duration kFirstStatus = std::chrono::seconds{1};
constexpr Duration kDisarmTimeout = std::chrono::seconds{10};

}  // namespace

SeriesRunner::SeriesRunner(HostLoop& loop, ShotSeriesSettings settings)
    : loop_(loop), series_(std::move(settings), loop.commands()), entered_(loop.now()) {
  loop.add_listener(*this);
}

void SeriesRunner::enter(Phase phase) {
  phase_ = phase;
  entered_ = loop_.now();
  if (phase == Phase::recovering) recovery_.emplace(loop_.now());
}

void SeriesRunner::take_in_first(FormerRuns former) {
  take_in_.emplace(loop_, std::move(former));
  enter(Phase::taking_in);
}

void SeriesRunner::on_shot_result(const ShotResult& result) {
  if (result.host_id == loop_.settings().host_id) {
    series_.on_shot_result(result);
  } else if (loop_.session().adopted(result.host_id)) {
    series_.on_former_result(result);
  }
}

void SeriesRunner::step() {
  if (phase_ == Phase::taking_in && take_in_->finished()) enter(Phase::firing);
  if (phase_ == Phase::firing) send_commands();  // what a message has led to since
  if (phase_ == Phase::firing && series_.finished())
    enter(loop_.disarming() ? Phase::disarming : Phase::recovering);
  if (phase_ == Phase::disarming && (!loop_.disarming() || loop_.now() - entered_ > kDisarmTimeout))
    enter(Phase::recovering);
  if (phase_ == Phase::firing) {
    if (on_begin_) std::exchange(on_begin_, nullptr)();
    fire();
  }
  if (phase_ == Phase::recovering && (hurried_ || recovery_->finished(loop_.session(), loop_.now())))
    phase_ = Phase::finished;
}

void SeriesRunner::fire() {
  const auto status = loop_.live_status();
  const Session& session = loop_.session();
  series_.on_danger(session.danger());
  if (loop_.was_suspended()) series_.end_after_shot("this computer was suspended");
  series_.on_second_rig(loop_.second_rig());
  series_.on_unanswered(loop_.unanswered());
  if (status)
    series_.on_arming_of(session.host_name(status->arm_host_id), session.adopted(status->arm_host_id));
  // One that was fired at the last moment of an earlier run.
  const bool former_under_way = status && session.waits_for_adopted() && !series_.shot_under_way();
  if (!former_under_way && (status || loop_.now() - entered_ > kFirstStatus))
    series_.step(status, loop_.now());
  send_commands();
}

bool SeriesRunner::stop(const std::string& by) {
  if (phase_ != Phase::firing && phase_ != Phase::taking_in) return false;
  series_.stop();
  loop_.disarm(by);
  enter(Phase::disarming);
  return true;
}

void SeriesRunner::stop_at_once(const std::string& by) {
  hurried_ = true;
  if (stop(by) || phase_ == Phase::finished) return;
  loop_.disarm(by);
  enter(Phase::disarming);
}

void SeriesRunner::leave() { phase_ = Phase::finished; }

void SeriesRunner::end_after_shot(const std::string& why) {
  if (phase_ != Phase::firing && phase_ != Phase::taking_in) return;
  series_.end_after_shot(why);
  send_commands();
}

void SeriesRunner::send_commands() {
  for (const auto& command : series_.take_commands()) loop_.send(command);
  for (const std::string& text : series_.take_notifications()) loop_.notify(text);
  if (series_.take_disarm()) loop_.disarm("the series' end");
}

Duration SeriesRunner::recovering_for() const {
  return phase_ == Phase::recovering ? loop_.now() - entered_ : Duration{};
}

}  // namespace strobe::host
