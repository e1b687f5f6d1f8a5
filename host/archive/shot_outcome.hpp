// What became of a stored shot. Pure; thread-safe; allocates.
#pragma once

#include <optional>
#include <string>
#include <strobe_msgs/frame_t.hpp>

#include "host/archive/fired_shots.hpp"
#include "host/archive/stored_session.hpp"

namespace strobe::host {

/// The result that the logs give, or where they end before it, as much as they tell.
ShotResult logged_outcome(const ShotKey& key, const FiredShot& fired);

/// The result by another digitization. The shot must have a summary; what its former result says of the events that came
/// and of the firmware's clock stays.
ShotResult measured_again(const StoredShot& shot, const strobe_msgs::frame_t& frame);

/// The result without any.
ShotResult without_photograph(const StoredShot& shot);

/// Whether its photograph is kept and was never digitized: the host ended before.
bool never_digitized(const StoredShot& shot);
/// Of the session's shots to which that happened, with the command that mends it; nullopt: there are none. Aborted
/// shots, whose photographs measure nothing, are not told.
std::optional<std::string> never_digitized_remark(const StoredSession& session);

}  // namespace strobe::host
