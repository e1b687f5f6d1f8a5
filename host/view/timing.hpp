// The firmware's timing histograms for a person: as lines with small bars. No I/O; thread-safe.
#pragma once

#include <string>
#include <strobe_msgs/status_t.hpp>
#include <vector>

namespace strobe::host {

/// The histogram of a quantity (histogram_t::LATENESS ...); null if the status has none of it, or without a
/// value.
const strobe_msgs::histogram_t* histogram_of(const strobe_msgs::status_t& status, int quantity);

/// One line for each quantity that has values, under a header: mean, sd, percentiles, largest, how many, and
/// the bins as bars whose height is logarithmic. Microseconds.
std::vector<std::string> render_timing(const strobe_msgs::status_t& status);

}  // namespace strobe::host
