// What a host keeps of a session: DIR/host-<UTC>.lcmlog (every message received, its own readouts), results.csv and
// flashes.csv with their data dictionaries (data_dictionary.hpp), and the rig, plan and calibration files as used. A
// failing disk stops no call: it is told (take_failures), and what was not written is counted (unstored). Writes files;
// one thread's.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <strobe_msgs/readout_t.hpp>
#include <utility>
#include <vector>

#include "common/authentication/key.hpp"
#include "common/result.hpp"
#include "host/messages/event_ledger.hpp"
#include "host/session/event_log.hpp"
#include "host/session/flashes_csv.hpp"
#include "host/session/results_csv.hpp"
#include "host/session/session.hpp"

namespace strobe::host {

struct KeptFile {
  std::string_view name;  ///< ends in .toml; empty: no such file
  std::string_view text;
};

class SessionFolder {
 public:
  /// Makes the folder if need be, opens a new log and results.csv for appending, keeps the rig and plan
  /// files and the camera's calibration. utc: as of utc_for_file(). Fails with the path that cannot be
  /// written.
  static Result<std::unique_ptr<SessionFolder>> open(const std::filesystem::path& folder,
                                                     const std::string& utc, std::string_view rig_text,
                                                     std::string_view plan_text,
                                                     const KeptFile& calibration = {});

  /// Appends a message as it came, at `wall`. Each is on its way to the disk before the call returns, so
  /// that a killed host loses none.
  void log(const std::string& channel, std::span<const std::uint8_t> message, WallTime wall);
  /// Appends a line to results.csv.
  void add(const ShotResult& shot_result, const std::string& utc);
  /// Appends a shot's flashes to flashes.csv, once.
  void add(const strobe_msgs::shot_t& shot);

  /// Writes what could not be written before, and looks whether the files are still in their places.
  void tend();
  /// Returns once all that was written is on the disk. May take long.
  void sync();
  /// As tend() and sync(), and closes the files: the last call.
  void close();

  /// New failures in words, each once: which file, why.
  std::vector<std::string> take_failures() { return std::exchange(failures_, {}); }
  /// Whether there ever was one.
  bool failed() const { return !told_.empty(); }
  /// What is not stored, a line for each file: nothing, or what waits, is lost or may be.
  std::vector<std::string> unstored() const;

  /// Enters the events in this folder's earlier host logs that are sealed with the lab's key, so that they are
  /// not asked for again; but for the last ones of shots whose summaries are in none. Flashes of those summaries
  /// that flashes.csv lacks are added.
  void load_events(EventLedger& ledger, const std::string& rig, const authentication::Key& key);

  const std::filesystem::path& path() const { return folder_; }

 private:
  explicit SessionFolder(std::filesystem::path folder, EventLog log, ResultsCsv results, FlashesCsv flashes)
      : folder_(std::move(folder)),
        log_(std::move(log)),
        results_(std::move(results)),
        flashes_(std::move(flashes)) {}
  std::array<RecordFile*, 3> files() { return {&log_.file(), &results_.file(), &flashes_.file()}; }
  void note(const Result<void>& done);
  void lost_for_want_of_memory(const std::filesystem::path& path, int shot_id);

  std::filesystem::path folder_;
  EventLog log_;
  ResultsCsv results_;
  FlashesCsv flashes_;
  std::vector<std::string> failures_;
  std::set<std::string> told_;
  std::map<std::filesystem::path, std::string>
      doubts_;  ///< what may be lost or is no longer in its place, and why
};

/// "20260131T093000Z" for file names; one more letter makes it unique where needed.
std::string utc_for_file(WallTime wall);
/// "2026-01-31T09:30:00.123Z"
std::string utc_for_table(WallTime wall);

}  // namespace strobe::host
