// Rows of results.csv as the page has them.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <set>

#include "common/data/csv.hpp"
#include "host/session/record_file.hpp"
#include "host/session/shot_table.hpp"
#include "host/web/json/shot_json.hpp"

namespace strobe::web {
namespace {

using reduction::kQuantityCount;
using reduction::Quantity;

std::optional<double> cell_number(const std::string& text) {
  double value = 0.0;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, value);
  if (text.empty() || read.ec != std::errc() || read.ptr != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::vector<std::string> words_between(const std::string& text, char separator) {
  std::vector<std::string> words;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(separator, at), text.size());
    if (end > at) words.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return words;
}

/// Where each column is: earlier versions lacked the last ones, none had another order.
class ResultsColumns {
 public:
  ResultsColumns() {
    const auto names = data::csv_cells(host::results_header());
    for (std::size_t i = 0; i < names.size(); ++i) places_[names[i]] = i;
    for (std::size_t i = 0; i < kQuantityCount; ++i) {
      const std::string quantity(reduction::kQuantityNames[i]);
      value_[i] = places_.at(quantity);
      sd_[i] = places_.at("sd_" + quantity);
      systematic_[i] = places_.at("sd_systematic_" + quantity);
    }
  }

  ShotRow row(const host::ResultsRow& line) const {
    const std::vector<std::string> cells = data::csv_cells(line.line);
    const auto cell = [&](std::size_t at) { return at < cells.size() ? cells[at] : std::string(); };
    const auto named = [&](const char* name) { return cell(places_.at(name)); };
    ShotRow row;
    row.key = line.key;
    row.utc = line.utc;
    if (!line.counts) row.rejected = named("rejected");
    for (std::size_t i = 0; i < kQuantityCount; ++i) {
      const auto q = static_cast<Quantity>(i);
      row.value[q] = cell_number(cell(value_[i]));
      if (const auto sd = cell_number(cell(sd_[i])))
        row.total_sd[q] = std::hypot(*sd, cell_number(cell(systematic_[i])).value_or(0.0));
    }
    row.regime = named("regime");
    row.flags = words_between(named("flags"), ';');
    row.spin = named("spin");
    row.angle_deg = cell_number(named("angle_deg"));
    row.digitization = named("digitization");
    return row;
  }

 private:
  std::map<std::string, std::size_t> places_;
  std::array<std::size_t, kQuantityCount> value_{}, sd_{}, systematic_{};
};

}  // namespace

std::vector<ShotRow> shot_rows(const std::vector<host::ResultsRow>& results) {
  static const ResultsColumns columns;
  std::vector<ShotRow> rows;
  std::vector<ShotKey> keys;
  std::set<ShotKey> known;
  for (const host::ResultsRow& line : results) {
    if (!known.insert(line.key).second) continue;
    rows.push_back(columns.row(line));
    keys.push_back(line.key);
  }
  std::vector<std::string> names = host::shot_names(keys);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].name = std::move(names[i]);
  return rows;
}

}  // namespace strobe::web
