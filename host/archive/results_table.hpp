// results.csv made anew from the session. Pure, but for rebuild_results(), which writes a file; allocates.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "host/archive/stored_session.hpp"
#include "host/session/results_rows.hpp"

namespace strobe::host {

/// "auto", "hand" or "corrected", of the digitization that counts; empty: there is none.
std::string_view digitization_word(const StoredShot& shot);

/// The whole table: a row for each shot, with the numbers of the digitization that counts. existing: the table as it
/// is, or empty; its rows keep their order, those of shots that the session does not tell of stay as they are.
std::string results_table(const StoredSession& session, const std::vector<ResultsRow>& existing);

/// Writes the table, and the data dictionary beside it; what the session's own results.csv has is taken into account. It is
/// the old file or the new one at any time. Fails with the name of a file that cannot be read or written. No host may be writing there.
Result<void> rebuild_results(const StoredSession& session, const std::filesystem::path& file);

}  // namespace strobe::host
