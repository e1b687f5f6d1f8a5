// One shot of a batch: measured again from its stored photograph, at its own flashes' times, and reduced. Reads the
// photograph; thread-safe; allocates.
#pragma once

#include <string>
#include <vector>

#include "host/archive/stored_session.hpp"
#include "host/batch/batch_settings.hpp"
#include "host/session/data_dictionary.hpp"

namespace strobe::host {

/// Where a row's numbers come from.
enum class RowSource { photograph, stored_frame, none };

/// What a shot's row is made of, before it is measured. shot: with the batch's rig.
struct BatchShot {
  const StoredShot* shot = nullptr;
  RowSource source = RowSource::none;
  std::string corrections;  ///< a person's, of the newest digitization; applied to what is found again
};

/// Fails if corrections cannot be read.
Result<BatchShot> batch_shot(const StoredShot& shot, const BatchSettings& settings);

/// Of all that the row depends on. photograph_hash: of the photograph's bytes; empty: it is not used.
std::string row_key(const BatchShot& shot, const BatchSettings& settings, const std::string& photograph_hash);

/// What a finished row keeps; what can be had from the session is left out.
struct BatchRow {
  std::string results;  ///< as a line of results.csv
  bool failed = false;  ///< the photograph could not be measured: `rejected` says why
};

BatchRow measure(const BatchShot& shot, const BatchSettings& settings);

/// Of a shot that cannot be measured.
BatchRow failed_row(const StoredShot& shot, const std::string& why);

/// Of a batch's tables: results_columns(), and session, photograph, digitized, key, batch.
std::vector<Column> batch_columns();
std::string_view name(RowSource source);

}  // namespace strobe::host
