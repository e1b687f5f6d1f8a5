// The status message's counts of ignored commands, each with its name for programs and its words for a
// person. Values only.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <strobe_msgs/status_t.hpp>

namespace strobe::host {

struct RejectedCommandLabel {
  std::int64_t strobe_msgs::status_t::*count;
  std::string_view key;
  std::string_view words;
};

inline constexpr std::array kRejectedCommandLabels{
    RejectedCommandLabel{&strobe_msgs::status_t::rejected_malformed, "malformed", "malformed"},
    RejectedCommandLabel{&strobe_msgs::status_t::rejected_oversized, "oversized", "oversized"},
    RejectedCommandLabel{&strobe_msgs::status_t::rejected_forged, "forged", "forged"},
    RejectedCommandLabel{&strobe_msgs::status_t::rejected_replayed, "replayed", "replayed"},
    RejectedCommandLabel{&strobe_msgs::status_t::rejected_stale, "stale", "stale"},
    RejectedCommandLabel{&strobe_msgs::status_t::rejected_other_rig, "other_rig", "for other rigs"},
};

}  // namespace strobe::host
