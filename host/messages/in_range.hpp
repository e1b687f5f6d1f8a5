// Whether the numbers of a message, whoever sent it, may be reckoned with: instants and sequences far from
// overflow, flashes numbered by their places. Not whether they are true. Pure functions; thread-safe.
#pragma once

#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <strobe_msgs/status_t.hpp>

namespace strobe::host {

bool in_range(const strobe_msgs::event_t& event);
bool in_range(const strobe_msgs::status_t& status);
bool in_range(const strobe_msgs::shot_t& shot);

}  // namespace strobe::host
