#include "host/commands/fit_data.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "common/config/files.hpp"
#include "common/data/csv.hpp"
#include "common/reduction/flags.hpp"

namespace strobe::host {

namespace {

/// The cells of one row by the header's names.
class Record {
 public:
  Record(const std::vector<std::string>& header, const data::CsvRow& row, const std::string& source)
      : header_(header), row_(row), source_(source) {}

  /// Empty where the file has no such column.
  std::string_view text(std::string_view column) const {
    const auto at = std::find(header_.begin(), header_.end(), column);
    return at == header_.end() ? std::string_view()
                               : std::string_view(row_.cells[static_cast<std::size_t>(at - header_.begin())]);
  }

  Result<std::optional<double>> number(std::string_view column) const {
    if (text(column).empty()) return std::optional<double>();
    return data::parse_number(text(column), source_, row_.line, column).map([](double x) {
      return std::optional<double>(x);
    });
  }

  /// As the screen and the table call the shot; the line where the table has no names.
  std::string name() const {
    const std::string_view shot = text("shot").empty() ? text("shot_id") : text("shot");
    return shot.empty() ? source_ + ":" + std::to_string(row_.line) : source_ + ": shot " + std::string(shot);
  }

 private:
  const std::vector<std::string>& header_;
  const data::CsvRow& row_;
  const std::string& source_;
};

struct Column {
  std::string_view name;
  double impact::Motion::*member;
  impact::Motion impact::Observation::*motion;
  impact::Motion impact::Observation::*sd;
};

using impact::Motion;
using impact::Observation;

constexpr std::array<Column, 5> kColumns{
    {{"vx_td_mps", &Motion::vx_mps, &Observation::touchdown, &Observation::touchdown_sd},
     {"vy_td_mps", &Motion::vy_mps, &Observation::touchdown, &Observation::touchdown_sd},
     {"omega_td_radps", &Motion::omega_radps, &Observation::touchdown, &Observation::touchdown_sd},
     {"vx_lo_mps", &Motion::vx_mps, &Observation::lift_off, &Observation::lift_off_sd},
     {"omega_lo_radps", &Motion::omega_radps, &Observation::lift_off, &Observation::lift_off_sd}}};

/// Reads a number and its sd; false where the number is missing.
Result<bool> read_pair(const Record& record, std::string_view column, double& value, double& sd) {
  const auto number = record.number(column);
  if (!number) return tl::unexpected(number.error());
  const auto spread = record.number("sd_" + std::string(column));
  if (!spread) return tl::unexpected(spread.error());
  value = number->value_or(0.0);
  sd = spread->value_or(0.0);
  return number->has_value();
}

bool aliased(const Record& record) {
  return record.text("flags").find(name(reduction::Flag::spin_aliased)) != std::string_view::npos;
}

/// Adds the shot, or counts why not.
Result<void> add_shot(const Record& record, const std::string& source, FitData& out) {
  Observation o;
  o.name = record.name();
  o.spin = record.text("spin");
  o.series = source;
  const std::string angle(record.text("angle_deg"));
  if (!o.spin.empty() && !angle.empty()) o.series = o.spin + "_" + angle;
  if (o.spin.empty()) o.spin = "not noted";
  bool complete = true;
  for (const Column& c : kColumns) {
    const auto there = read_pair(record, c.name, (o.*c.motion).*c.member, (o.*c.sd).*c.member);
    if (!there) return tl::unexpected(there.error());
    complete = complete && *there;
  }
  const auto there = read_pair(record, "e", o.e, o.e_sd);
  if (!there) return tl::unexpected(there.error());
  if (const auto dwell = read_pair(record, "dwell_time_ms", o.dwell_s, o.dwell_sd_s); !dwell)
    return tl::unexpected(dwell.error());
  o.dwell_s /= 1e3;
  o.dwell_sd_s /= 1e3;
  if (!record.text("rejected").empty()) {
    ++out.rejected;
  } else if (!complete || !*there || aliased(record)) {
    ++out.incomplete;
  } else {
    out.observations.push_back(std::move(o));
  }
  return {};
}

Result<void> check_header(const std::vector<std::string>& header, int line, const std::string& source) {
  const auto missing = [&](std::string_view column) {
    return std::find(header.begin(), header.end(), column) == header.end();
  };
  for (const Column& c : kColumns)
    if (missing(c.name)) return data::csv_error(source, line, c.name, "is missing in the header");
  if (missing("e")) return data::csv_error(source, line, "e", "is missing in the header");
  return {};
}

}  // namespace

Result<FitData> conditions_to_fit(thesis::Version version, impact::Spread spread) {
  const auto share = config::share_folder();
  if (!share) return tl::unexpected(share.error());
  const auto loaded = thesis::load(*share / "thesis", version);
  if (!loaded) return tl::unexpected(loaded.error());
  FitData out;
  out.observations = impact::observations_of(loaded->conditions, spread);
  return out;
}

Result<FitData> parse_results(std::string_view text, const std::string& source) {
  const std::vector<data::CsvRow> rows = data::csv_rows(text);
  if (rows.empty()) return fail(source + ": is empty");
  const std::vector<std::string>& header = rows.front().cells;
  if (const auto checked = check_header(header, rows.front().line, source); !checked)
    return tl::unexpected(checked.error());
  FitData out;
  for (const data::CsvRow& row : std::span(rows).subspan(1)) {
    if (row.cells.size() != header.size())
      return fail(source + ":" + std::to_string(row.line) + ": " + std::to_string(row.cells.size()) +
                  " cells where the header has " + std::to_string(header.size()));
    const auto added = add_shot(Record(header, row, source), source, out);
    if (!added) return tl::unexpected(added.error());
  }
  return out;
}

Result<FitData> read_results(const std::filesystem::path& path) {
  std::string text;  // of any size, where read_file() has a limit
  const auto there = config::read_lines(
      path, [&text](std::string_view line, bool ended) { text.append(line).append(ended ? "\n" : ""); });
  if (!there) return tl::unexpected(there.error());
  if (!*there) return fail(path.string() + ": No such file or directory");
  return parse_results(text, path.string());
}

}  // namespace strobe::host
