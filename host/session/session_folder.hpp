// What a host keeps of a session: DIR/host-<UTC>.lcmlog (every message received, its own readouts),
// results.csv, flashes.csv, and the rig, plan and calibration files as used. Writes files; one thread's.
#pragma once

#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <string>
#include <string_view>
#include <strobe_msgs/readout_t.hpp>

#include "common/authentication/key.hpp"
#include "common/result.hpp"
#include "host/messages/event_ledger.hpp"
#include "host/session/csv_file.hpp"
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
  void log(const std::string& channel, const void* data, std::size_t size, WallTime wall);
  /// Appends a line to results.csv.
  Result<void> add(const ShotResult& shot_result, const std::string& utc);
  /// Appends a shot's flashes to flashes.csv, once.
  Result<void> add(const strobe_msgs::shot_t& shot);

  /// Enters the events in this folder's earlier host logs that are sealed with the lab's key, so that they are
  /// not asked for again; but for the
  /// last ones of shots whose summaries are in none.
  void load_events(EventLedger& ledger, const std::string& rig, const authentication::Key& key) const;

  const std::filesystem::path& path() const { return folder_; }

 private:
  SessionFolder(std::filesystem::path folder, std::filesystem::path log_path)
      : folder_(std::move(folder)), log_path_(std::move(log_path)) {}

  std::filesystem::path folder_, log_path_;
  std::unique_ptr<lcm::LogFile> log_;
  std::int64_t event_number_ = 0;
  std::unique_ptr<CsvFile> results_;
  std::unique_ptr<FlashesCsv> flashes_;
};

/// "20260131T093000Z" for file names; one more letter makes it unique where needed.
std::string utc_for_file(WallTime wall);
/// "2026-01-31T09:30:00.123Z"
std::string utc_for_table(WallTime wall);

}  // namespace strobe::host
