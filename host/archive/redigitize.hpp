// A session's photographs measured again: with a person's corrections, or because their measurement was lost; put into the
// session, and taken back. Reads and writes files; one process's at a time.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/archive/read_session.hpp"
#include "host/photographs/measure_photograph.hpp"

namespace strobe::host {

/// Measures the shot's photograph with what its session has: rig file, calibration, the flashes' times and the effort that
/// its run asked for. Fails with one line: no photograph, no summary, a file that cannot be read.
Result<MeasuredPhotograph> redigitize(const StoredSession& session, const StoredShot& shot,
                                      const std::vector<digitize::Correction>& corrections = {});
/// With the corrections of the shot's newest digitization: what there is to see of it.
Result<MeasuredPhotograph> redigitize_newest(const StoredSession& session, const StoredShot& shot);

/// Who changes a session, and when.
struct Author {
  std::string who;  ///< "login@machine"; empty: nobody, a measurement that was lost is made good
  std::string utc;  ///< as in results.csv
};
/// Of whoever runs this process, now.
Author author_now();

/// A shot after a change: what it was is in the session that was read.
struct ChangedShot {
  StoredShot shot;
  bool changed = true;  ///< false: it was so before
};

/// Puts the photograph's measurement with these corrections (a file's text, and its name for messages) into the session,
/// to be the one that counts. If it is the newest already nothing is written.
Result<ChangedShot> put_correction(const StoredSession& session, const StoredShot& shot,
                                   const std::string& corrections, const std::string& file_name,
                                   const Author& author);

/// Takes the newest digitization that is a file back: the one before it counts again. Fails if there is none.
Result<ChangedShot> take_back(const StoredSession& session, const StoredShot& shot);

struct Completion {
  int digitized = 0;
  std::vector<std::string> problems;  ///< a line for each photograph that cannot be measured, or not be kept
};
/// Measures all photographs that are kept and were never digitized, and puts that into the session and into `session`.
Completion complete(StoredSession& session);

}  // namespace strobe::host
