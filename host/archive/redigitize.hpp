// A session's photographs measured again: with a person's corrections, or because their measurement was lost;
// put into the session, and taken back. Reads and writes files; one process's at a time.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "common/shot/shot_key.hpp"
#include "host/archive/read_session.hpp"
#include "host/photographs/measure_photograph.hpp"

namespace strobe::host {

/// Measures the shot's photograph with what its session has: rig file, calibration, the flashes' times and
/// the effort that its run asked for. Fails with one line: no photograph, no summary, a file that cannot be
/// read.
Result<MeasuredPhotograph> redigitize(const StoredSession& session, const Shot& shot,
                                      const std::vector<digitize::Correction>& corrections = {});
/// With the corrections of the shot's newest digitization: what there is to see of it.
Result<MeasuredPhotograph> redigitize_newest(const StoredSession& session, const Shot& shot);

/// Who changes a session, and when.
struct Author {
  std::string who;  ///< "login@machine"; empty: nobody, a measurement that was lost is made good
  std::string utc;  ///< as in results.csv
};
/// Of whoever runs this process, now.
Author author_now();

/// A shot after a change: what it was is in the session that was read.
struct ChangedShot {
  Shot shot;
  bool changed = true;  ///< false: it was so before
};

/// Puts the photograph's measurement with these corrections (a file's text, and its name for messages) into
/// the session, to be the one that counts. If it is the newest already nothing is written.
Result<ChangedShot> put_correction(const StoredSession& session, const Shot& shot,
                                   const std::string& corrections, const std::string& file_name,
                                   const Author& author);

/// Takes the newest digitization that is a file back: the one before it counts again. Fails if there is none.
Result<ChangedShot> take_back(const StoredSession& session, const Shot& shot);

struct Completion {
  int digitized = 0;
  std::vector<std::string> problems;  ///< a line for each photograph that cannot be measured, or not be kept
};
/// Measures all photographs that are kept and were never digitized, and puts that into the session and into
/// `session`.
Completion complete(StoredSession& session);

// A session's folder digitizations/: photographs that were measured again, by a person's corrections or
// because their measurement was lost. shot-0003-<boot hex>-<n>.json holds the frame as `strobe digitize
// --json` prints it, with who and when; the corrections that made it are beside it, shot-0003-<boot
// hex>-<n>.toml. The largest n counts. What was taken back has another ending. Reads and writes files; one
// process's at a time.

struct DigitizationFile {
  std::filesystem::path path;
  ShotKey key;
  int number = 0;  ///< 1, 2, 3 ... for one shot
};

/// Absent: it is not the name of such a file.
std::optional<DigitizationFile> digitization_file(const std::filesystem::path& path);
/// Those of the session, each shot's in the order of their numbers. Fails where the folder is there and
/// cannot be read.
Result<std::map<ShotKey, std::vector<DigitizationFile>>> digitization_files(
    const std::filesystem::path& session);
/// The name that the shot's digitization of this number has in the session, without its ending.
std::filesystem::path digitization_stem(const std::filesystem::path& session, const ShotKey& key, int number);

/// Any text. Fails with "NAME: what is wrong".
Result<Digitization> parse_digitization(std::string_view text, const ShotKey& key, const std::string& name);
/// Fails with the file's name.
Result<Digitization> read_digitization(const DigitizationFile& file);

}  // namespace strobe::host
