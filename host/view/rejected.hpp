// The status message's counts of ignored commands, each with its name for programs and its words for a
// person. Values only.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <strobe_msgs/status_t.hpp>

namespace strobe::host {

struct RejectedLabel {
  std::int64_t strobe_msgs::status_t::*count;
  std::string_view key;
  std::string_view words;
};

inline constexpr std::array kRejectedLabels{
    RejectedLabel{&strobe_msgs::status_t::rejected_malformed, "malformed", "malformed"},
    RejectedLabel{&strobe_msgs::status_t::rejected_oversized, "oversized", "oversized"},
    RejectedLabel{&strobe_msgs::status_t::rejected_forged, "forged", "forged"},
    RejectedLabel{&strobe_msgs::status_t::rejected_replayed, "replayed", "replayed"},
    RejectedLabel{&strobe_msgs::status_t::rejected_stale, "stale", "stale"},
    RejectedLabel{&strobe_msgs::status_t::rejected_other_rig, "other_rig", "for other rigs"},
};

}  // namespace strobe::host
