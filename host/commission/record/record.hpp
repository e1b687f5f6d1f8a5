// The record of commissioning: RIG.commission.jsonl, one JSON object a line for each step that was done,
// appended and on the disk before the next one begins. Pure functions but where said; thread-safe; they
// allocate.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "common/units/time.hpp"
#include "host/commission/record/step_result.hpp"
#include "host/config/rig_file.hpp"

namespace strobe::commission {

struct RecordedStep {
  std::string utc;            ///< "2026-01-31T09:30:00.123Z"
  std::string operator_name;  ///< "login@machine"
  std::string version;        ///< of strobe
  std::string rig;            ///< its name
  std::string tables_hash;    ///< see tables_hash()
  std::string title;
  StepResult result;
};

struct Record {
  bool torn = false;                ///< the last line has no end
  std::vector<RecordedStep> steps;  ///< oldest first
  std::vector<std::string>
      remarks;  ///< a sentence for each line that is none, such as one that a power cut tore
  /// The newest result of a step; nullptr: there is none.
  const RecordedStep* newest(std::string_view id) const;
};

/// {"utc","rig","step","title","state","value","sd","unit","limit","words","advice","fault","figures","operator","version",
/// "tables_hash"}, with its end.
std::string record_line(const RecordedStep& step);
/// The result alone: {"step","title","state","value","sd","unit","limit","words","advice","fault","figures"}
std::string result_json(const std::string& title, const StepResult& result);
/// Any bytes.
Record parse_record(std::string_view text);
/// Reads the file; an absent one is empty. Fails with the file's name.
Result<Record> read_record(const std::filesystem::path& path);

/// What a session's folder calls its copy of the record.
inline constexpr const char* kRecordInSession = "commission.jsonl";

/// Where the record of this rig file is. rig_path: as given, not empty.
std::filesystem::path record_path(const std::filesystem::path& rig_path,
                                  const host::CommissionTable& settings);

/// SHA-256 of what these tables of the rig file say, and for "camera" also its calibration: comments, order
/// and other tables do not change it. Empty: the text is no TOML that can be read.
std::string tables_hash(const host::RigFile& rig, const std::vector<std::string>& tables);

/// How the record stands on a day.
struct Standing {
  enum class State {
    absent,  ///< nothing is recorded
    good,    ///< all steps passed, or were skipped for a stated reason; none old, none before the rig file's
             ///< change
    doubtful,  ///< some step failed or was not told, is missing, old, or older than the rig file's change
  };
  struct Line {
    const RecordedStep* step = nullptr;  ///< nullptr: never done
    StepInfo info;
    bool changed = false;  ///< the rig file has, since
    bool old = false;
  };
  State state = State::absent;
  std::string newest_utc;    ///< of any step
  double oldest_days = 0.0;  ///< of the oldest of the newest results
  std::vector<Line> lines;   ///< one for each step
  std::string words;         ///< after "the rig is": "commissioned on 2026-11-23; failed: lamp_a"
};
/// infos: of all steps. The lines point into `record`.
Standing standing(const Record& record, std::span<const StepInfo> infos, const host::RigFile& rig,
                  WallTime now);

}  // namespace strobe::commission
