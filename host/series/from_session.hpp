// The shots of a stored session as a series takes them. No I/O; thread-safe; allocates; some milliseconds a shot.
#pragma once

#include <string>
#include <vector>

#include "host/archive/stored_session.hpp"
#include "host/series/series_shot.hpp"

namespace strobe::host {

/// `session`: what its shots are called by, empty where there is one session only. Calibration and ball are those of the
/// shot's rig file, the ball also by its note ball_name: balls that no note tells apart are taken for the same.
std::vector<SeriesShot> series_shots(const StoredSession& session, const std::string& session_name);

/// The shot's frame with the likeliest times of its flashes; absent without one.
std::optional<reduction::Frame> matched_frame(const StoredShot& shot);

/// Of the digitization that counts; empty without one.
reduction::Budget budget_of(const StoredShot& shot);

/// One shot with its budget, of a rig's.
SeriesShot series_shot(const ShotResult& result, reduction::Budget budget, const RigFile& rig);

}  // namespace strobe::host
