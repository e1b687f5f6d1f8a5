// What a host keeps of a session: DIR/host-<UTC>.lcmlog (every message received, its own readouts),
// results.csv and flashes.csv with their data dictionaries (shot_table.hpp), shots.txt (what a person was
// told), runs.jsonl (run_record.hpp), and the rig, plan and calibration files as used. A failing disk stops
// no call: it is told (take_failures), and what was not written is counted (unstored). Writes files; one
// thread's.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <strobe_msgs/readout_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <utility>
#include <vector>

#include "common/result.hpp"
#include "common/shot/shot_key.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/messages/transport.hpp"
#include "host/session/record_file.hpp"
#include "host/session/run_record.hpp"
#include "host/session/session.hpp"
#include "host/session/session_logs.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::host {

std::string flashes_header();
/// The lines of a shot, each with its end.
std::string flashes_lines(const strobe_msgs::shot_t& shot);

/// flashes.csv: the record of every flash of every shot, one line each, appended over any number of runs.
/// What was not there is empty.
class FlashesCsv {
 public:
  /// Fails where CsvFile does. Flashes that the file already has are known.
  static Result<FlashesCsv> open(const std::filesystem::path& path);

  /// Known flashes change nothing; those that a cut-short write left out are added.
  Result<void> add(const strobe_msgs::shot_t& shot);

  RecordFile& file() { return file_.file(); }
  const RecordFile& file() const { return file_.file(); }

 private:
  using FlashKey = std::pair<ShotKey, std::int32_t>;
  static std::set<FlashKey> flashes_in(std::istream& lines);
  FlashesCsv(CsvFile file, std::set<FlashKey> known) : file_(std::move(file)), known_(std::move(known)) {}

  CsvFile file_;
  std::set<FlashKey> known_;
};

struct KeptFile {
  std::string_view name;  ///< ends in .toml; empty: no such file
  std::string_view text;
};

class SessionFolder {
 public:
  /// Makes the folder if need be, opens a new log and results.csv for appending, keeps the rig and plan
  /// files, the camera's calibration and the ball's file. utc: as of utc_for_file(). Fails with the path that
  /// cannot be written.
  static Result<std::unique_ptr<SessionFolder>> open(const std::filesystem::path& folder,
                                                     const std::string& utc, std::string_view rig_text,
                                                     std::string_view plan_text,
                                                     const KeptFile& calibration = {},
                                                     const KeptFile& ball = {});

  /// Appends a message as it came, at `wall`. Each is on its way to the disk before the call returns, so
  /// that a killed host loses none.
  void log(const std::string& channel, std::span<const std::uint8_t> message, WallTime wall);
  /// Appends a line to results.csv.
  void add(const Shot& shot, const std::string& utc);
  /// Appends a shot's flashes to flashes.csv, once.
  void add(const strobe_msgs::shot_t& shot);
  /// Appends lines, each with its end, to shots.txt.
  void add_text(const std::string& lines);
  /// Appends a line to runs.jsonl; on the disk when it returns.
  void add(const RunRecord& run);
  /// Likewise to camera.jsonl, with the time: the camera and its settings as read back, a JSON object.
  void add_camera(std::string_view object, const std::string& utc);

  /// Writes what could not be written before, and looks whether the files are still in their places.
  void tend();
  /// Returns once all that was written is on the disk. May take long.
  void sync();
  /// As tend() and sync(), and closes the files: the last call.
  void close();

  /// New failures in words, each once: which file, why.
  std::vector<std::string> take_failures() { return std::exchange(failures_, {}); }
  /// Whether there ever was one.
  bool failed() const { return !reported_.empty(); }
  /// What is not stored, a line for each file: nothing, or what waits, is lost or may be.
  std::vector<std::string> unstored() const;

  const std::filesystem::path& path() const { return folder_; }
  const std::filesystem::path& log_path() const { return log_.file().path(); }
  /// The plan file as used, a name in the folder: plan.toml, or another where an earlier run had another
  /// plan.
  const std::string& plan_file() const { return plan_file_; }

 private:
  SessionFolder(std::filesystem::path folder, std::string plan_file, EventLog log, ResultsCsv results,
                FlashesCsv flashes, RecordFile text)
      : folder_(std::move(folder)),
        plan_file_(std::move(plan_file)),
        log_(std::move(log)),
        results_(std::move(results)),
        flashes_(std::move(flashes)),
        text_(std::move(text)) {}
  std::array<RecordFile*, 4> files() { return {&log_.file(), &results_.file(), &flashes_.file(), &text_}; }
  void append_line(const char* name, const std::string& line, const char* kind);
  void note(const Result<void>& done);
  void lost_for_want_of_memory(const std::filesystem::path& path, int shot_id);

  std::filesystem::path folder_;
  std::string plan_file_;
  EventLog log_;
  ResultsCsv results_;
  FlashesCsv flashes_;
  RecordFile text_;
  std::vector<std::string> failures_;
  std::set<std::string> reported_;
  std::map<std::filesystem::path, std::string>
      doubts_;  ///< what may be lost or is no longer in its place, and why
};

/// "20260131T093000Z" for file names; one more letter makes it unique where needed.
std::string utc_for_file(WallTime wall);
/// "2026-01-31T09:30:00.123Z"
std::string utc_for_table(WallTime wall);

/// A transport whose messages are kept in a session's log: those received that the loop acts on, and those
/// published as they are published; with their seals, so that a replay can verify them too. What strangers
/// send fills no disk. Times in the log are those of the start, gone on by CLOCK_MONOTONIC: setting the wall
/// clock does not make a replay wait, or believe that the firmware was silent.
class LoggedTransport final : public Transport {
 public:
  /// All references must outlive the object.
  LoggedTransport(Transport& transport, SessionFolder& folder, Clock& clock)
      : transport_(transport), folder_(folder), clock_(clock), started_(clock.read()) {}

  bool receive(std::chrono::milliseconds max_wait, std::span<const int> descriptors,
               const Receiver& receiver) override;
  std::string sender() const override { return transport_.sender(); }
  void publish(const std::string& channel, Bytes bytes) override;
  void keep(const std::string& channel, Bytes bytes) override { log(channel, bytes); }

 private:
  void log(const std::string& channel, Bytes bytes);

  Transport& transport_;
  SessionFolder& folder_;
  Clock& clock_;
  HostReading started_;
};

}  // namespace strobe::host
