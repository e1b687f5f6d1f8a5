// runs.jsonl: what each `strobe fire` in a session's folder was asked for, one JSON object per line, appended
// before its first shot. Pure functions but for read_runs(), which reads a file; thread-safe; they allocate.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/result.hpp"

namespace strobe::host {

struct RunRecord {
  std::string utc;            ///< of its start, as in results.csv
  std::int64_t host_id = 0;   ///< of its process; in the file as text, since JSON readers round such numbers
  std::string version;        ///< of strobe
  std::string operator_name;  ///< "login@machine"
  int shots = 1;              ///< that must count: this run's, or with `until` all of the session's
  bool until = false;
  int retries = 0;  ///< shots that may be fired again
  bool dry = false;
  reduction::Record notes;  ///< --spin, --angle, --note
  std::string plan_file;    ///< in the folder
  std::string spacing;      ///< --spacing; empty: not given
  std::string rig_file;     ///< as it was read; empty: the shipped example
  std::string photographs;  ///< --photographs; empty: not given
  std::string effort;       ///< of the digitizer
  std::string key_fingerprint;
  std::vector<std::string> command;  ///< as typed
  /// Shots that count which the session is to hold in the end: what `--resume` goes on to.
  int session_shots = 0;
  std::string until_known;  ///< --until-known, as "e:0.003,mu:1%"; empty: not given
  std::string protocol;     ///< the name of the one that the session's protocol.toml holds; empty: none
  int protocol_seed = 0;    ///< of its drawn order
};

/// One line, with its end.
std::string run_line(const RunRecord& run);

struct RunRecords {
  std::vector<RunRecord> runs;  ///< oldest first
  std::vector<std::string>
      remarks;  ///< a sentence for each line that is no record, such as one that a power cut tore
  /// Any bytes without their end; number: of the line, from 1. A line without a host_id, or that is no JSON
  /// object, is left out and told. What else is absent or of another type is as RunRecord has it by default.
  void add(std::string_view line, int number);
};

/// Of a file of any size; no runs if there is none. Fails on a file that cannot be read.
Result<RunRecords> read_runs(const std::filesystem::path& path);

}  // namespace strobe::host
