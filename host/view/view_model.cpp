#include "host/view/view_model.hpp"

#include <fmt/format.h>

namespace strobe::host {
namespace {

constexpr std::size_t kMaxNotifications = 50;

}  // namespace

SeriesShot series_shot_of(const ShotResult& result) {
  SeriesShot shot;
  shot.name = std::to_string(result.shot_id);
  shot.readout = result.readout;
  if (result.budget) shot.budget = *result.budget;
  if (const auto ball = result.readout.record.find("ball_name"); ball != result.readout.record.end())
    shot.ball = ball->second;
  shot.rejected = result.rejected;
  return shot;
}

void ViewModel::add(const ShotResult& result) {
  ++shots;
  if (!result.dry) series.add(series_shot_of(result));
  last = result;
}

void ViewModel::add_notification(const std::string& text) {
  notifications.push_back(text);
  if (notifications.size() > kMaxNotifications) notifications.erase(notifications.begin());
}

std::optional<std::string> ViewModel::update(Session& session, HostTime now) {
  status = session.status();
  danger = session.danger();
  silent = !session.live_status(now);
  status_age_s = to_seconds(now - session.status_heard());
  events_missing = session.ledger().missing();
  const bool suspect_before = clock.suspect;
  clock = session.clock().state();
  if (!clock.suspect || suspect_before) return std::nullopt;
  return fmt::format("the firmware's clock drifts by {:.0f} ppm against this machine's: not plausible",
                     *clock.drift_ppm);
}

std::string why_nothing_can_be_fired(const ViewModel& model) {
  if (!model.blocking_reason.empty()) return model.blocking_reason;
  if (!model.status) return "no firmware heard";
  if (model.silent) return fmt::format("the firmware has been silent for {:.0f} s", model.status_age_s);
  return model.status->message;
}

}  // namespace strobe::host
