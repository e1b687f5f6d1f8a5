// Measured frontiers come from people's runs: any bytes are either rows and ranges in order or an error of
// one line, and any requirement on the rows is met or refused in words.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "common/frontier/frontier.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;

namespace {

using namespace strobe::frontier;

void choose_each_way(const std::vector<Row>& rows) {
  for (const Row& row : rows) {
    for (const Requirement& requirement :
         {Requirement{row.error, {}}, Requirement{{}, row.cost_us}, Requirement{row.error, row.cost_us},
          Requirement{0.5 * row.error, 0.5 * row.cost_us}}) {
      const auto chosen = choose(rows, requirement);
      require(chosen ? requirement.is_met_by(*chosen) : !failure_text(chosen.error(), requirement).empty());
      require(chosen || !requirement.is_met_by(row));
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = text_of(data, size);
  const auto rows = parse_frontier(text, "fuzz.csv");
  if (!rows) require_one_line(rows.error().message, "fuzz.csv:");
  if (rows && rows->size() < 200) {
    for (const Row& row : *rows) {
      require(std::isfinite(row.cost_us) && row.cost_us > 0.0 && std::isfinite(row.error) &&
              row.error >= 0.0);
      require(!row.study.empty() && !row.method.empty() &&
              accuracy_and_cost(row).find('\n') == std::string::npos);
      parameter_value(row.parameter, "tolerance");
    }
    choose_each_way(*rows);
  }
  const auto ranges = parse_ranges(text, "fuzz.csv");
  if (!ranges) require_one_line(ranges.error().message, "fuzz.csv:");
  if (ranges)
    for (const Range& range : *ranges) require(range.lowest <= range.highest);
  return 0;
}
