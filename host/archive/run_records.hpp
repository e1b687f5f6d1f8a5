// runs.jsonl: each start of `strobe fire` in a session's folder, one JSON object a line. Pure; thread-safe; allocates.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host/archive/stored_session.hpp"

namespace strobe::host {

struct RunRecords {
  std::vector<StoredRun> runs;
  std::vector<std::string> remarks;  ///< a sentence for each line that is no record
};

/// Any bytes. A line without a host_id, or that is no JSON object, is told and left out; so is a last line that was cut
/// short. What else is absent or of another type is as StoredRun has it by default.
RunRecords parse_run_records(std::string_view text);

}  // namespace strobe::host
