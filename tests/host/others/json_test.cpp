// What results.csv holds is in the JSON, too.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "host/config/notes.hpp"
#include "host/session/data_dictionary.hpp"
#include "tests/host/others/stored_photographs.hpp"
#include "tests/support/program_run.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;

namespace {

/// Where the JSON of a result has the column; notes are in its record if they were made.
nlohmann::json::json_pointer place_of(const std::string& column) {
  for (const std::string prefix : {"sd_systematic_", "sd_"}) {
    if (column.starts_with(prefix))
      return nlohmann::json::json_pointer("/" + prefix.substr(0, prefix.size() - 1) + "/" +
                                          column.substr(prefix.size()));
  }
  const bool note =
      std::ranges::find(host::kNamedNotes, column) != host::kNamedNotes.end() || column == "other_notes";
  return nlohmann::json::json_pointer(note ? "/record" : "/" + column);
}

}  // namespace

TEST_GROUP(JsonOfResults){};

TEST(JsonOfResults, HoldsEveryColumnThatALogTells) {
  others::StoredPhotographs stored;
  const auto session = stored.add_session("monday", "zero_23", 1);
  const auto results = jsons_of(testing::run_program(
      {STROBE_BUILD_DIR "/bin/strobe", "replay", session / "host-20260131T093000Z.lcmlog", "--json"},
      {{"STROBE_KEY_FILE", stored.key_file()}}));
  LONGS_EQUAL(1, results.size());
  for (const host::Column& column : host::results_columns()) {
    // A log's readouts are the same bytes whenever they are computed, and whatever its session calls its shots and made
    // of them afterwards; Batch.PrintsEveryColumn has these columns.
    if (column.name == "utc" || column.name == "shot" || column.name == "digitization") continue;
    CHECK_TEXT(results[0].contains(place_of(column.name)), column.name.c_str());
  }
}
