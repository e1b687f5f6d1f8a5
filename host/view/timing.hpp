// The firmware's timing and clock for a person, as lines with small bars, and for a program. No I/O;
// thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <strobe_msgs/status_t.hpp>
#include <vector>

#include "common/authentication/unverified.hpp"
#include "host/clock/device_clock.hpp"

namespace strobe::host {

/// The histogram of a quantity (histogram_t::LATENESS ...); null if the status has none of it, or without a
/// value.
const strobe_msgs::histogram_t* histogram_of(const strobe_msgs::status_t& status, int quantity);

/// How the firmware's clock stands to this machine's, and how promptly its heartbeats come.
std::string clock_line(const ClockState& clock, double status_age_s);

/// One line for each quantity that has values, under a header: mean, sd, percentiles, largest, how many, and
/// the bins as bars whose height is logarithmic. Microseconds.
std::vector<std::string> render_timing(const strobe_msgs::status_t& status);

/// {"timing_after_shot":…,"boot_id":"…","timing":{"lateness_us":{"n":…,"mean":…, …},…},"clock":{…},…} on one
/// line; keys in fixed order, what is not known null.
std::string timing_json(const strobe_msgs::status_t& status, const ClockState& clock, int after_shot,
                        const authentication::UnverifiedCounts& unverified);

// The status message's counts of ignored commands, each with its name for programs and its words for a
// person. Values only.

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
