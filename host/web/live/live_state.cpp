#include "host/web/live/live_state.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "common/messages/parsed_json.hpp"
#include "host/session/shot_table.hpp"
#include "host/view/render.hpp"
#include "host/view/timing.hpp"
#include "host/web/http/background.hpp"
#include "host/web/json/series_page_json.hpp"
#include "host/web/json/shot_json.hpp"
#include "host/web/live/status_json.hpp"

namespace strobe::web {
namespace {

using nlohmann::ordered_json;

std::string line_of(const ordered_json& json) { return messages::json_text(json); }

}  // namespace

LiveState::LiveState(LiveSetup setup, LiveChannel& channel, EventHub& hub)
    : setup_(std::move(setup)), channel_(channel), hub_(hub) {
  status_.missing = "no firmware heard";
  thread_ = background_thread("strobe-web-live", [this] { run(); });
}

LiveState::~LiveState() {
  channel_.end();
  thread_.join();
}

void LiveState::run() {
  while (true) {
    auto [messages, ended] = channel_.take();
    bool shots = false;
    for (LiveMessage& message : messages) {
      shots = shots || std::holds_alternative<LiveShot>(message);
      std::visit([this](auto& told) { take(std::move(told)); }, message);
    }
    if (shots) publish_series();
    if (ended) return;
  }
}

void LiveState::take(LiveStatus status) {
  std::string text = line_of(status_json(status));
  {
    const std::lock_guard lock(mutex_);
    status_ = std::move(status);
  }
  hub_.publish("status", std::move(text));
}

void LiveState::take(LiveShot shot) {
  const host::Shot& result = shot.result;
  shots_.push_back(result.key());
  const ShotRow row =
      shot_row(result, host::shot_names(shots_).back(), shot.utc, host::digitization_word(result));
  std::string text = line_of(shot_json(row, setup_.session));
  {
    const std::lock_guard lock(mutex_);
    last_text_ = text;
    last_shot_id_ = result.shot_id;
  }
  hub_.publish("shot", std::move(text));
  if (result.dry) return;
  rows_.push_back(row);
  series_.add(result);
}

void LiveState::take(LiveNotification notification) {
  std::string text = line_of({{"utc", notification.utc}, {"text", notification.text}});
  {
    const std::lock_guard lock(mutex_);
    notifications_.push_back(text);
    if (notifications_.size() > kMaxNotifications) notifications_.erase(notifications_.begin());
  }
  hub_.publish("notification", std::move(text));
}

void LiveState::publish_series() {
  if (rows_.empty()) return;
  std::string text = line_of(series_page_json(series_.summary("series"), setup_.thesis, rows_));
  {
    const std::lock_guard lock(mutex_);
    series_text_ = std::move(text);
  }
  hub_.publish("series", "{}");
}

std::string LiveState::live_json() const {
  const std::int64_t event_id = hub_.last_id();  // first: what changes meanwhile is told again
  const std::lock_guard lock(mutex_);
  const ordered_json head{
      {"program", setup_.program},
      {"version", setup_.version},
      {"rig", setup_.rig},
      {"session", setup_.session ? ordered_json(*setup_.session) : ordered_json()},
      {"can", {{"stop", status_.can_stop}, {"disarm", status_.can_disarm}, {"edit", setup_.can_edit}}},
      {"status", status_json(status_)}};
  std::string text = line_of(head);
  text.pop_back();
  return text + fmt::format(",\"series\":{},\"last\":{},\"notifications\":[{}],\"event_id\":{}}}",
                            series_text_, last_text_, fmt::join(notifications_, ","), event_id);
}

std::optional<std::string> LiveState::timing_json() const {
  const std::lock_guard lock(mutex_);
  if (!status_.status) return std::nullopt;
  return host::timing_json(*status_.status, status_.clock, last_shot_id_, status_.unverified);
}

LiveState::Asked LiveState::ask(LiveCommand command) {
  {
    const std::lock_guard lock(mutex_);
    const bool can = command.kind == LiveCommand::Kind::stop ? status_.can_stop : status_.can_disarm;
    if (!can) return Asked::no;
  }
  switch (channel_.command(std::move(command))) {
    case LiveChannel::Given::taken:
      return Asked::taken;
    case LiveChannel::Given::waits:
      return Asked::waits;
    case LiveChannel::Given::too_many:
      break;
  }
  return Asked::too_often;
}

}  // namespace strobe::web
