#include "host/web/live_state.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "common/messages/parsed_json.hpp"
#include "host/series/select.hpp"
#include "host/session/shot_table.hpp"
#include "host/view/render.hpp"
#include "host/view/timing.hpp"
#include "host/web/conditions.hpp"
#include "host/web/http/worker.hpp"
#include "host/web/shot_json.hpp"

namespace strobe::web {
namespace {

using nlohmann::ordered_json;
using strobe_msgs::status_t;

std::string_view state_of(const LiveStatus& live) {
  if (!live.status) return "never_heard";
  if (live.silent) return "silent";
  switch (live.status->state) {
    case status_t::IDLE:
      return "idle";
    case status_t::ARMED:
      return "armed";
    case status_t::FIRING:
      return "firing";
    case status_t::SPENT:
      return "spent";
    case status_t::STOPPED:
      return "stopped";
    default:
      return "fault";  // also a later firmware's, of which nothing is known
  }
}

/// What a firmware said that is not heard any more is not known to be so still.
std::string_view switch_of(const LiveStatus& live, bool is_on, std::string_view on, std::string_view off) {
  if (!live.status || live.silent) return "unknown";
  return is_on ? on : off;
}

ordered_json unverified_json(const authentication::UnverifiedCounts& counts) {
  ordered_json json = ordered_json::object();
  for (std::size_t i = 0; i < authentication::kUnverifiedCount; ++i) {
    const auto why = static_cast<authentication::Unverified>(i);
    json[authentication::name(why)] = counts[why];
  }
  return json;
}

std::string line_of(const ordered_json& json) { return messages::json_text(json); }

}  // namespace

ordered_json status_json(const LiveStatus& live) {
  return {{"state", state_of(live)},
          {"age_s", live.status ? ordered_json(live.age_s) : ordered_json()},
          {"key", switch_of(live, live.status && live.status->key_active, "on", "off")},
          {"estop", switch_of(live, live.status && live.status->estop_active, "pressed", "released")},
          {"danger", live.danger},
          {"missing", live.missing},
          {"activity", live.activity},
          {"shots", live.shots},
          {"counted", live.counted},
          {"wanted", messages::or_null(live.wanted)},
          {"armed_by", live.armed_by},
          {"real_time", live.status && live.status->real_time},
          {"journal_ok", live.status && live.status->journal_ok},
          {"events_missing", live.events_missing},
          {"verified", live.verified},
          {"unverified", unverified_json(live.unverified)},
          {"photographs_pending", live.photographs_pending},
          {"can", {{"stop", live.can_stop}, {"disarm", live.can_disarm}}}};
}

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
      shots = shots || std::holds_alternative<host::Shot>(message);
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

void LiveState::take(host::Shot shot) {
  shots_.push_back(shot.key());
  shot.name = host::shot_names(shots_).back();
  const ShotRow row = shot_row(shot);
  std::string text = line_of(shot_json(row, setup_.session));
  {
    const std::lock_guard lock(mutex_);
    last_text_ = text;
    last_shot_id_ = shot.shot_id;
  }
  hub_.publish("shot", std::move(text));
  if (shot.dry) return;
  LiveSeries& series = series_like(shot);
  series.rows.push_back(row);
  series.series.add(shot);
}

/// Shots of other conditions may come in turn: each goes to its own series, and the newest one's is shown.
LiveState::LiveSeries& LiveState::series_like(const host::Shot& shot) {
  const auto found = std::ranges::find_if(all_series_, [&](const LiveSeries& each) {
    return host::differing_keys({&each.first, &shot}).empty();
  });
  if (found != all_series_.end()) {
    std::rotate(found, found + 1, all_series_.end());
    return all_series_.back();
  }
  LiveSeries& added = all_series_.emplace_back();
  added.first.rig = shot.rig;
  added.first.readout.record = shot.readout.record;
  return added;
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
  if (all_series_.empty()) return;
  const auto& [first, series, rows] = all_series_.back();
  ordered_json page = series_page_json(series.summary("series"), setup_.thesis, rows);
  std::vector<const host::Shot*> firsts;
  for (const LiveSeries& each : all_series_) firsts.push_back(&each.first);
  page["conditions"] = {{{"name", condition_words(first, host::differing_keys(firsts))},
                         {"counted", series.counted()},
                         {"like", rows.back().name}}};
  page["differ"] = ordered_json::array();
  std::string text = line_of(page);
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
      {"can", {{"stop", status_.can_stop}, {"disarm", status_.can_disarm}, {"edit", true}}},
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

Response LiveState::ask(const Request& request, LiveCommand::Kind kind) {
  // What asks for something to be done says nothing more.
  const auto body = messages::parsed_json<ordered_json>(request.body);
  if (!body.is_object() || !body.empty()) return error_response(400, "the body must be {}");
  const bool stops = kind == LiveCommand::Kind::stop;
  {
    const std::lock_guard lock(mutex_);
    if (!(stops ? status_.can_stop : status_.can_disarm))
      return error_response(
          409, stops ? "there is no series to be ended" : "without the lab's key nothing can be disarmed");
  }
  switch (channel_.command({kind, request.from})) {
    case LiveChannel::Given::taken:
      return json_response({{"asked", true}}, 202);
    case LiveChannel::Given::waits:
      return error_response(503, "the host did not react within 1 s");
    case LiveChannel::Given::too_many:
      break;
  }
  return error_response(503, "too many requests wait: try again");
}

void add_live_routes(Router& router, LiveState& state) {
  router.get("/api/v1/live", Work::quick,
             [&state](const Request&) { return json_text_response(state.live_json()); });
  router.get("/api/v1/timing", Work::quick, [&state](const Request&) {
    auto timing = state.timing_json();
    return timing ? json_text_response(std::move(*timing)) : error_response(404, "no firmware was heard yet");
  });
  router.post("/api/v1/stop", Work::waits,
              [&state](const Request& request) { return state.ask(request, LiveCommand::Kind::stop); });
  router.post("/api/v1/disarm", Work::waits,
              [&state](const Request& request) { return state.ask(request, LiveCommand::Kind::disarm); });
}

}  // namespace strobe::web
