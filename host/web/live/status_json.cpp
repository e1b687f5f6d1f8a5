#include "host/web/live/status_json.hpp"

#include <nlohmann/json.hpp>
#include <string_view>

#include "common/messages/parsed_json.hpp"

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

}  // namespace strobe::web
