// What became of a stored shot. Pure; thread-safe; allocates.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <strobe_msgs/frame_t.hpp>
#include <vector>

#include "common/reduction/reduce.hpp"
#include "common/result.hpp"
#include "host/archive/log_player.hpp"
#include "host/archive/read_session.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::host {

/// The shot as the logs give it, or where they end before its result, as much as they tell.
Shot logged_outcome(const ShotKey& key, const LoggedShot& fired);

/// Gives the shot the readout of its newest digitization, or none, and judges whether it counts; what it was
/// told of the events that came and of the firmware's clock stays. A shot without a summary stays as it is.
void judge_again(Shot& shot);

/// Whether its photograph is kept and was never digitized: the host ended before.
bool never_digitized(const Shot& shot);
/// Of the session's shots to which that happened; nullopt: there are none. Aborted shots, whose photographs
/// measure nothing, are not told.
std::optional<std::string> never_digitized_remark(const StoredSession& session);
/// The command that mends it.
std::string completion_advice(const StoredSession& session);

// A stored shot's numbers by another estimator. Pure; thread-safe; allocates.

/// The result with a readout by this estimator, from the digitization that counts and the flashes' most
/// probable times; whether the shot counts stays as it was. Fails with one line if there is no digitization,
/// or no flashes match it.
Result<Shot> reduced_by(const Shot& shot, reduction::Estimator estimator,
                        const reduction::ReduceOptions& options);

// results.csv made anew from the session. Pure, but for rebuild_results(), which writes a file; allocates.

/// The whole table: a row for each shot, with the numbers of the digitization that counts. existing: the
/// table as it is, or empty; its rows keep their order, those of shots that the session does not tell of stay
/// as they are.
std::string results_table(const StoredSession& session, const std::vector<ResultsRow>& existing);

/// Writes the table, and the data dictionary beside it; what the session's own results.csv has is taken into
/// account. It is the old file or the new one at any time. Fails with the name of a file that cannot be read
/// or written. No host may be writing there.
Result<void> rebuild_results(const StoredSession& session, const std::filesystem::path& file);

}  // namespace strobe::host
