#include "host/loop/series_runner.hpp"

namespace strobe::host {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
// The first status may take half of it: nothing is missing before it had time to come.
constexpr std::int64_t kFirstStatus_ns = kSecond_ns;
constexpr std::int64_t kDisarmTimeout_ns = kSecond_ns;

}  // namespace

SeriesRunner::SeriesRunner(HostLoop& loop, ShotSeriesSettings settings)
    : loop_(loop), series_(std::move(settings), loop.commands()), entered_ns_(loop.now_ns()) {
  loop.add_listener(*this);
}

void SeriesRunner::enter(Phase phase) {
  phase_ = phase;
  entered_ns_ = loop_.now_ns();
  if (phase == Phase::recovering) recovery_.emplace(loop_.now_ns());
}

void SeriesRunner::step() {
  if (phase_ == Phase::firing && series_.finished()) enter(Phase::recovering);
  if (phase_ == Phase::disarming && (disarmed() || loop_.now_ns() - entered_ns_ > kDisarmTimeout_ns))
    enter(Phase::recovering);
  if (phase_ == Phase::firing) fire();
  if (phase_ == Phase::recovering && recovery_->finished(loop_.session(), loop_.now_ns()))
    phase_ = Phase::finished;
}

void SeriesRunner::fire() {
  const auto status = loop_.live_status();
  if (status || loop_.now_ns() - entered_ns_ > kFirstStatus_ns) series_.step(status, loop_.now_ns());
  send_commands();
}

bool SeriesRunner::stop() {
  if (phase_ != Phase::firing) return false;
  series_.stop(loop_.live_status());
  send_commands();
  enter(Phase::disarming);
  return true;
}

void SeriesRunner::send_commands() {
  for (const auto& command : series_.take_commands()) loop_.send(command);
  for (const std::string& text : series_.take_notifications()) loop_.notify(text);
}

bool SeriesRunner::disarmed() const {
  const auto& status = loop_.session().status();
  return !status || (status->arm_token == 0 && status->state != strobe_msgs::status_t::FIRING);
}

std::int64_t SeriesRunner::recovering_for_ns() const {
  return phase_ == Phase::recovering ? loop_.now_ns() - entered_ns_ : 0;
}

}  // namespace strobe::host
