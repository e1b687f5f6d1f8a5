// What a session's folder holds besides its logs may have been cut short, or be anything: runs.jsonl, a digitization,
// results.csv, the record of commissioning, and file names. The first byte says which it is.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>

#include "host/archive/session_files.hpp"
#include "host/archive/redigitize.hpp"
#include "host/commission/record/record.hpp"
#include "host/session/shot_table.hpp"
#include "host/session/run_record.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe;
using namespace strobe::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text(text_of(data + 1, size - 1));
  const ShotKey key{77, 3};
  switch (data[0] % 5) {
    case 0: {
      host::RunRecords records;
      std::istringstream lines(text);
      for (std::string line; std::getline(lines, line);) records.add(line, 1);
      for (const host::RunRecord& run : records.runs) require(run.host_id != 0);
      for (const std::string& remark : records.remarks) require_one_line(remark, "runs.jsonl:");
      break;
    }
    case 1: {
      const auto digitization = host::parse_digitization(text, key, "fuzz.json");
      if (!digitization) return require_one_line(digitization.error().message, "fuzz.json:"), 0;
      require(digitization->frame.boot_id == key.boot_id && digitization->frame.shot_id == key.shot_id);
      require(digitization->frame.image_count == static_cast<int>(digitization->frame.images.size()));
      break;
    }
    case 2: {
      std::vector<ShotKey> keys;
      for (const host::ResultsRow& row : host::parse_results(text)) {
        require(row.line.starts_with(row.utc));
        keys.push_back(row.key);
      }
      require(host::shot_names(keys).size() == keys.size());
      break;
    }
    case 4: {
      const commission::Record record = commission::parse_record(text);
      for (const commission::RecordedStep& step : record.steps) {
        const commission::Record again = commission::parse_record(commission::record_line(step));
        require(again.steps.size() == 1 && !again.torn);
        require(commission::record_line(again.steps[0]) == commission::record_line(step));
      }
      for (const std::string& remark : record.remarks) require_one_line(remark, "line ");
      break;
    }
    default:
      if (const auto file = host::digitization_file(text)) require(file->key.shot_id > 0 && file->number > 0);
      if (const auto number = host::shot_number_in(text)) require(*number > 0);
      if (const auto named = host::named_photograph("/nowhere", text)) require(false);
  }
  return 0;
}
