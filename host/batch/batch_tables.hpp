// What a batch leaves in its folder: NAME.csv of each session, results.csv of all by the sessions' names,
// each with its data dictionary, NAME.remarks.txt, and batch.json, which names the sessions. Writes files;
// one thread's.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "host/config/rig_file.hpp"
#include "host/digitize/digitize.hpp"

namespace strobe::host {

struct BatchSession {
  std::string path;  ///< as it was given
  std::string name;  ///< its folder's; where several have the same, with a hash of the path
};

/// Absolute or relative paths of sessions, each once.
std::vector<BatchSession> batch_sessions(const std::vector<std::string>& paths);

struct BatchManifest {
  std::string id;  ///< of batch_id()
  std::vector<std::string> sessions;
};

Result<void> write_manifest(const std::filesystem::path& folder, const BatchManifest& manifest);
Result<BatchManifest> read_manifest(const std::filesystem::path& folder);

/// lines: rows, each with its line end.
Result<void> write_session_table(const std::filesystem::path& folder, const std::string& session,
                                 const std::string& lines);

/// NAME.remarks.txt: what of the session could not be read or is missing, a line each; no file where there is
/// nothing.
Result<void> write_session_remarks(const std::filesystem::path& folder, const std::string& session,
                                   const std::vector<std::string>& remarks);

/// results.csv of all sessions, which may lie in several folders, into `out`. Returns the number of rows.
/// Fails if the folders are of different batches, or with the number of sessions that are not finished and
/// the first of their names.
Result<int> merge_tables(const std::vector<std::filesystem::path>& folders, const std::filesystem::path& out);

// What a batch does with every session. Plain values; thread-safe.

struct BatchSettings {
  std::string version;                             ///< of strobe: another one computes anew
  std::string rig;                                 ///< path; empty: the rig file that each session keeps
  std::string calibration_text, calibration_name;  ///< name empty: the rig file's own
  digitize::Effort effort = digitize::Effort::standard;
  bool stored_frames = false;  ///< reduce what was digitized, measure no photograph
};

/// Of sixteen hexadecimal digits: other settings, another batch.
std::string batch_id(const BatchSettings& settings, const std::string& rig_text);

/// The rig with the batch's calibration. Fails as read_rig does.
Result<RigFile> calibrated(RigFile rig, const BatchSettings& settings);

/// BLAKE2b of 128 bits, hexadecimal: of bytes that differ another.
class ContentHash {
 public:
  ContentHash();
  /// Each part with its size, so that no two lists of parts are alike.
  ContentHash& add(std::string_view part);
  std::string digits() const;

 private:
  std::string parts_;
};

/// Of a file's bytes, read in pieces. Fails with the file's name.
Result<std::string> hash_of_file(const std::string& path);

}  // namespace strobe::host
