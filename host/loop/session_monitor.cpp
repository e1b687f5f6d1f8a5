#include "host/loop/session_monitor.hpp"

#include <fmt/format.h>

namespace strobe::host {
namespace {

constexpr std::int64_t kHeard_ns = 2'000'000'000;
constexpr std::size_t kNotificationsKept = 50;

}  // namespace

void SessionMonitor::status(const strobe_msgs::status_t& message, std::int64_t now_ns) {
  session_.on_status(message, now_ns);
  hand_on();
}

void SessionMonitor::event(const strobe_msgs::event_t& message, std::int64_t now_ns) {
  session_.on_event(message, now_ns);
  if (on_event) on_event(message);
  hand_on();
}

void SessionMonitor::shot(const strobe_msgs::shot_t& message, std::int64_t now_ns) {
  session_.on_shot(message, now_ns);
  if (on_shot) on_shot(message);
  hand_on();
}

void SessionMonitor::frame(const strobe_msgs::frame_t& message, std::int64_t now_ns) {
  session_.on_frame(message, now_ns);
  hand_on();
}

void SessionMonitor::time(std::int64_t now_ns) {
  session_.on_time(now_ns);
  hand_on();
}

void SessionMonitor::local_clocks(const ClockReading& clocks) {
  session_.clock().on_local(clocks);
  for (const std::string& text : session_.clock().take_notifications()) notify(text);
}

void SessionMonitor::end() {
  session_.on_end();
  hand_on();
}

void SessionMonitor::hand_on() {
  for (const std::string& text : session_.take_notifications()) notify(text);
  for (const ShotResult& shot_result : session_.take_shot_results()) {
    ++shot_results_;
    if (!shot_result.rejected && !shot_result.dry) model_.series.add(shot_result.readout);
    model_.last = shot_result;
    if (on_shot_result) on_shot_result(shot_result);
  }
}

void SessionMonitor::notify(const std::string& text) {
  model_.notifications.push_back(text);
  if (model_.notifications.size() > kNotificationsKept)
    model_.notifications.erase(model_.notifications.begin());
  if (on_notification) on_notification(text);
}

std::optional<strobe_msgs::status_t> SessionMonitor::heard(std::int64_t now_ns) const {
  if (!session_.status() || now_ns - session_.status_heard_ns() > kHeard_ns) return std::nullopt;
  return session_.status();
}

const Model& SessionMonitor::shown(std::int64_t now_ns) {
  model_.status = session_.status();
  model_.status_age_s = static_cast<double>(now_ns - session_.status_heard_ns()) * 1e-9;
  const bool suspect_before = model_.clock.suspect;
  model_.clock = session_.clock().state();
  if (model_.clock.suspect && !suspect_before) {
    notify(fmt::format("the firmware's clock drifts by {:.0f} ppm against this machine's: not plausible",
                       *model_.clock.drift_ppm));
  }
  model_.events_missing = session_.ledger().missing();
  return model_;
}

}  // namespace strobe::host
