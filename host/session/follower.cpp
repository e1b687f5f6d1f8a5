#include "host/session/follower.hpp"

#include <fmt/format.h>

namespace strobe::host {
namespace {

constexpr std::int64_t kHeard_ns = 2'000'000'000;
constexpr std::size_t kNoticesKept = 50;

}  // namespace

void Follower::status(const strobe_msgs::status_t& message, std::int64_t now_ns) {
  session_.on_status(message, now_ns);
  hand_on();
}

void Follower::event(const strobe_msgs::event_t& message, std::int64_t now_ns) {
  session_.on_event(message, now_ns);
  if (on_event) on_event(message);
  hand_on();
}

void Follower::shot(const strobe_msgs::shot_t& message, std::int64_t now_ns) {
  session_.on_shot(message, now_ns);
  if (on_shot) on_shot(message);
  hand_on();
}

void Follower::frame(const strobe_msgs::frame_t& message, std::int64_t now_ns) {
  session_.on_frame(message, now_ns);
  hand_on();
}

void Follower::time(std::int64_t now_ns) {
  session_.on_time(now_ns);
  hand_on();
}

void Follower::local_clocks(const MachineClocks& clocks) {
  session_.clock().on_local(clocks);
  for (const std::string& text : session_.clock().take_notices()) notice(text);
}

void Follower::end() {
  session_.on_end();
  hand_on();
}

void Follower::hand_on() {
  for (const std::string& text : session_.take_notices()) notice(text);
  for (const Outcome& outcome : session_.take_outcomes()) {
    ++outcomes_;
    if (!outcome.spoilt && !outcome.dry) model_.series.add(outcome.readout);
    model_.last = outcome;
    if (on_outcome) on_outcome(outcome);
  }
}

void Follower::notice(const std::string& text) {
  model_.notices.push_back(text);
  if (model_.notices.size() > kNoticesKept) model_.notices.erase(model_.notices.begin());
  if (on_notice) on_notice(text);
}

std::optional<strobe_msgs::status_t> Follower::heard(std::int64_t now_ns) const {
  if (!session_.status() || now_ns - session_.status_heard_ns() > kHeard_ns) return std::nullopt;
  return session_.status();
}

const Model& Follower::shown(std::int64_t now_ns) {
  model_.status = session_.status();
  model_.status_age_s = static_cast<double>(now_ns - session_.status_heard_ns()) * 1e-9;
  const bool suspect_before = model_.clock.suspect;
  model_.clock = session_.clock().state();
  if (model_.clock.suspect && !suspect_before) {
    notice(fmt::format("the firmware's clock drifts by {:.0f} ppm against this machine's: not plausible",
                       *model_.clock.drift_ppm));
  }
  model_.events_missing = session_.ledger().missing();
  return model_;
}

}  // namespace strobe::host
