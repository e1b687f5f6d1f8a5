#include "host/session/shot_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <optional>
#include <set>

#include "common/config/files.hpp"
#include "common/data/csv.hpp"
#include "host/config/notes.hpp"

namespace strobe::host {
namespace {

using reduction::Quantity;

struct Meaning {
  std::string_view unit;
  std::string_view text;
};

constexpr std::array<Meaning, kNamedNotes.size()> kNotes{{
    {"", "label of the series: zero, top or back"},
    {"deg", "label of the series: the machine's nominal angle"},
    {"", "number of the photograph on its film or in its folder"},
    {"", "ball"},
    {"", "ball's grade or state"},
    {"", "surface"},
    {"", "surface's grade or state"},
    {"Cel", "air temperature at the plate"},
    {"m", "distance of the camera from the plane of flight"},
    {"m", "distance of the machine from the impact"},
    {"deg", "machine's angle as set"},
    {"deg", "surface's inclination, counter-clockwise positive"},
    {"", "who fired"},
    {"", "remarks"},
}};

std::string joined_flags(const reduction::FlagSet& flags) {
  std::string names;
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    const auto flag = static_cast<reduction::Flag>(i);
    if (flags.has(flag)) names += fmt::format("{}{}", names.empty() ? "" : ";", name(flag));
  }
  return names;
}

/// Of the keys that have no column of their own.
std::string other_notes(const reduction::Record& record) {
  std::string others;
  for (const auto& [key, value] : record) {
    if (std::ranges::find(kNamedNotes, key) == kNamedNotes.end())
      others += fmt::format("{}{}={}", others.empty() ? "" : ";", key, value);
  }
  return others;
}

std::string text_of(bool value) { return value ? "true" : "false"; }

/// value: a number, an integer ...; absent: an empty cell.
template <typename Value>
std::string text_of(const std::optional<Value>& value) {
  return value ? fmt::format("{}", *value) : std::string();
}

constexpr std::string_view kSdOf = "standard deviation, given the ball's diameter and the air, of: ";
constexpr std::string_view kSystematicSdOf =
    "standard deviation from the tolerances of the ball's diameter and of the air, of: ";

void add_quantities(std::vector<ShotField>& fields, std::string_view prefix, std::string_view words,
                    reduction::Quantities reduction::Readout::*numbers) {
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const QuantityLabel& label = kQuantityLabels[i];
    fields.push_back(
        {{fmt::format("{}{}", prefix, reduction::kQuantityNames[i]), "number",
          std::string(label.unit.empty() ? "1" : label.unit), fmt::format("{}{}", words, label.meaning)},
         [numbers, q = static_cast<Quantity>(i)](const Shot& shot) {
           return text_of((shot.readout.*numbers)[q]);
         }});
  }
}

/// Empty where the third dimension is not told.
void add_spatial(std::vector<ShotField>& fields, std::string_view prefix, std::string_view words,
                 double reduction::DerivedNumber::*member) {
  for (std::size_t i = 0; i < reduction::kSpatialCount; ++i) {
    const QuantityLabel& label = kSpatialLabels[i];
    fields.push_back({{fmt::format("{}{}", prefix, reduction::kSpatialNames[i]), "number",
                       std::string(label.unit), fmt::format("{}{}", words, label.meaning)},
                      [member, i](const Shot& shot) {
                        const auto& spatial = shot.readout.spatial;
                        const auto number = spatial ? spatial->number[i] : std::nullopt;
                        return number ? fmt::format("{}", *number.*member) : std::string();
                      }});
  }
}

/// Operators write them: a number among them may be any text.
void add_notes(std::vector<ShotField>& fields) {
  for (std::size_t i = 0; i < kNamedNotes.size(); ++i) {
    fields.push_back({{std::string(kNamedNotes[i]), "string", std::string(kNotes[i].unit),
                       fmt::format("{}, as recorded", kNotes[i].text)},
                      [key = std::string(kNamedNotes[i])](const Shot& shot) {
                        const auto note = shot.readout.record.find(key);
                        return note == shot.readout.record.end() ? std::string() : note->second;
                      }});
  }
  fields.push_back({{"other_notes", "string", "", "further notes of the record, key=value", ';'},
                    [](const Shot& shot) { return other_notes(shot.readout.record); }});
}

/// A number of the flashes that show the ball.
template <typename Value>
auto of_flashes(Value reduction::ImagedFlashes::*member) {
  return [member](const Shot& shot) {
    const auto& flashes = shot.readout.flashes;
    return flashes ? fmt::format("{}", *flashes.*member) : std::string();
  };
}

std::vector<ShotField> make_shot_fields() {
  using reduction::ImagedFlashes;
  using reduction::Readout;
  std::vector<ShotField> fields{
      {{"utc", "dateTime", "", "when the result came, by the host's clock"},
       [](const Shot& shot) { return shot.utc; }},
      {{"boot_id", "string", "", "start of the firmware that fired the shot, hexadecimal"},
       [](const Shot& shot) { return fmt::format("{:x}", static_cast<std::uint64_t>(shot.boot_id)); }},
      {{"shot_id", "integer", "", "number of the shot in its session"},
       [](const Shot& shot) { return std::to_string(shot.shot_id); }},
      {{"rejected", "string", "", "why the shot does not count; empty: it counts"},
       [](const Shot& shot) { return shot.rejected.value_or(""); }},
  };
  add_quantities(fields, "", "", &Readout::value);
  add_quantities(fields, "sd_", kSdOf, &Readout::sd);
  add_quantities(fields, "sd_systematic_", kSystematicSdOf, &Readout::sd_systematic);
  fields.push_back(
      {{"regime", "string", "", "slides: throughout the contact; grips: not; unclear: either"},
       [](const Shot& shot) { return std::string(shot.readout.regime ? name(*shot.readout.regime) : ""); }});
  fields.push_back({{"court_pace_conforming", "boolean", "", "the shot met the court pace's conditions"},
                    [](const Shot& shot) { return text_of(shot.readout.court_pace_conforming); }});
  fields.push_back({{"method", "string", "", "estimator: best, two-point or legacy"},
                    [](const Shot& shot) { return shot.readout.method; }});
  fields.push_back(
      {{"mirrored", "boolean", "", "the ball travelled to the left; numbers are of its mirror image"},
       [](const Shot& shot) { return text_of(shot.readout.mirrored); }});
  fields.push_back({{"flags", "string", "", "what was unusual (common/reduction/README.md)", ';'},
                    [](const Shot& shot) { return joined_flags(shot.readout.flags); }});
  add_notes(fields);
  fields.push_back(
      {{"first_flash", "integer", "1", "flash, numbered as fired from 0, that made the first image"},
       of_flashes(&ImagedFlashes::first)});
  fields.push_back(
      {{"last_flash", "integer", "1", "flash, numbered as fired from 0, that made the last image"},
       of_flashes(&ImagedFlashes::last)});
  fields.push_back(
      {{"misassignment_probability", "number", "1", "probability that other flashes made these images"},
       of_flashes(&ImagedFlashes::misassignment_probability)});
  fields.push_back(
      {{"digitization", "string", "",
        "who measured the photograph: auto, hand, or corrected by a person afterwards; empty: there is none"},
       [](const Shot& shot) { return std::string(digitization_word(shot)); }});
  fields.push_back(
      {{"shot", "string", "",
        "what the shot is called: its number and, where an earlier start of the firmware had the "
        "same, its start"},
       [](const Shot& shot) { return shot.name; }});
  using reduction::DerivedNumber;
  add_spatial(fields, "", "", &DerivedNumber::value);
  add_spatial(fields, "sd_", kSdOf, &DerivedNumber::sd);
  add_spatial(fields, "sd_systematic_", kSystematicSdOf, &DerivedNumber::sd_systematic);
  return fields;
}

std::vector<Column> make_flashes_columns() {
  constexpr std::string_view kClock = "by the firmware's CLOCK_MONOTONIC";
  const auto instant = [&](std::string_view name, std::string_view words) {
    return Column{std::string(name), "integer", "ns", fmt::format("{}, {}", words, kClock)};
  };
  return {
      {"boot_id", "string", "", "start of the firmware that fired the shot, hexadecimal"},
      {"shot_id", "integer", "", "number of the shot in its session"},
      {"flash_index", "integer", "1", "number of the flash in its shot, from 0"},
      {"lamps", "string", "", "lamps that were to flash: a, b or ab"},
      instant("commanded_ns", "planned instant"),
      instant("issue_start_ns", "before the call that switched the lamps on; empty: never issued"),
      instant("issue_end_ns", "after that call; empty: never issued"),
      instant("observed_a_ns", "first edge of sensor A less its delay; empty: none"),
      instant("observed_b_ns", "first edge of sensor B less its delay; empty: none"),
      {"extra_edges", "integer", "1", "further edges of either sensor before the next flash"},
  };
}

/// In quotes. Written as text, since nlohmann's destructors need memory: where there is none they end the
/// program.
std::string json_string(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + "\"";
}

std::string column_json(const Column& column) {
  std::string json = fmt::format("{{\"name\": {0}, \"titles\": {0}, \"datatype\": {1}",
                                 json_string(column.name), json_string(column.datatype));
  if (column.separator != 0) json += fmt::format(", \"separator\": \"{}\"", column.separator);
  if (!column.unit.empty()) json += fmt::format(", \"schema:unitCode\": {}", json_string(column.unit));
  return json + fmt::format(", \"dc:description\": {}}}", json_string(column.meaning));
}

template <typename Number>
std::optional<Number> number_in(std::string_view text, int base) {
  Number value{};
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (text.empty() || read.ec != std::errc() || read.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Unless it is none.
void add_row(const std::string& line, std::vector<ResultsRow>& rows) {
  const std::vector<std::string> cells = data::csv_cells(line);
  if (cells.size() < 3 || !line.starts_with(cells[0])) return;
  if (const auto key = shot_key_in(cells[1], cells[2]))
    rows.push_back({*key, cells[0], cells.size() == 3 || cells[3].empty(), line});
}

/// Takes lines, of which a quoted field may hold the end; a last line without its end is left out.
class RowsReader {
 public:
  void add(std::string_view line, bool ended) {
    whole_ = whole_ && begun_.size() <= config::kMaxLine_bytes;
    if (!ended || !whole_) return;
    begun_ += line;
    if (std::ranges::count(begun_, '"') % 2 != 0) {
      begun_ += '\n';
      return;
    }
    add_row(begun_, rows);
    begun_.clear();
  }
  bool whole() const { return whole_; }

  std::vector<ResultsRow> rows;

 private:
  std::string begun_;
  bool whole_ = true;
};

}  // namespace

const std::vector<ShotField>& shot_fields() {
  static const std::vector<ShotField> fields = make_shot_fields();
  return fields;
}

const std::vector<Column>& results_columns() {
  static const std::vector<Column> columns = [] {
    std::vector<Column> all;
    for (const ShotField& field : shot_fields()) all.push_back(field.column);
    return all;
  }();
  return columns;
}

const std::vector<Column>& flashes_columns() {
  static const std::vector<Column> columns = make_flashes_columns();
  return columns;
}

std::string csv_header(std::span<const Column> columns) {
  std::string header;
  for (const Column& column : columns) header += fmt::format("{}{}", header.empty() ? "" : ",", column.name);
  return header;
}

std::string data_dictionary(std::string_view file_name, std::string_view title,
                            std::span<const Column> columns) {
  std::string json = fmt::format(
      "{{\n  \"@context\": \"http://www.w3.org/ns/csvw\",\n  \"url\": {},\n  \"dc:title\": {},\n"
      "  \"tableSchema\": {{\n    \"columns\": [",
      json_string(file_name), json_string(title));
  for (std::size_t i = 0; i < columns.size(); ++i)
    json += fmt::format("{}\n      {}", i == 0 ? "" : ",", column_json(columns[i]));
  return json + "\n    ]\n  }\n}\n";
}

std::string results_header() { return csv_header(results_columns()); }

std::vector<std::string> earlier_results_headers() {
  const auto without = [](std::size_t added_later) {
    return csv_header(std::span(results_columns()).first(results_columns().size() - added_later));
  };
  constexpr std::size_t kSpatial = 3 * reduction::kSpatialCount, kNames = 2, kFlashes = 3;
  return {without(kSpatial), without(kSpatial + kNames), without(kSpatial + kNames + kFlashes)};
}

std::string_view digitization_word(const Digitization& digitization) {
  if (!digitization.file.empty() && digitization.by_hand) return "corrected";
  return digitization.frame.source == "hand" ? "hand" : "auto";
}

std::string_view digitization_word(const Shot& shot) {
  return shot.digitizations.empty() ? "" : digitization_word(shot.digitizations.back());
}

std::string results_line(const Shot& shot) {
  std::string line;
  for (const ShotField& field : shot_fields())
    line += (&field == &shot_fields().front() ? "" : ",") + data::csv_cell(field.text(shot));
  return line;
}

Result<ResultsCsv> ResultsCsv::open(const std::filesystem::path& path) {
  auto file = CsvFile::open(path, results_header(), earlier_results_headers());
  if (!file) return tl::unexpected(file.error());
  const auto rows = read_results_rows(path);
  if (!rows) return tl::unexpected(rows.error());
  std::vector<ShotKey> shots;
  for (const ResultsRow& row : *rows) shots.push_back(row.key);
  return ResultsCsv(std::move(*file), std::move(shots));
}

Result<void> ResultsCsv::add(Shot shot) {
  shots_.push_back(shot.key());
  shot.name = shot_names(shots_).back();
  return file_.append(results_line(shot));
}

std::optional<ShotKey> shot_key_in(std::string_view boot_id, std::string_view shot_id) {
  const auto boot = number_in<std::uint64_t>(boot_id, 16);
  const auto shot = number_in<std::int32_t>(shot_id, 10);
  if (!boot || !shot) return std::nullopt;
  return ShotKey{static_cast<std::int64_t>(*boot), *shot};
}

std::vector<ResultsRow> parse_results(std::string_view text) {
  RowsReader reader;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    reader.add(text.substr(0, end), end != std::string_view::npos);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return std::move(reader.rows);
}

Result<std::vector<ResultsRow>> read_results_rows(const std::filesystem::path& file) {
  RowsReader reader;
  const auto read =
      config::read_lines(file, [&reader](std::string_view line, bool ended) { reader.add(line, ended); });
  if (!read) return tl::unexpected(read.error());
  if (!reader.whole()) return fail(file.string() + ": a quoted field has no end");
  return std::move(reader.rows);
}

std::vector<std::string> shot_names(const std::vector<ShotKey>& shots) {
  constexpr std::size_t kDigits = 6;
  std::set<std::string> taken;
  std::vector<std::string> names;
  for (const ShotKey& key : shots) {
    const std::string boot = fmt::format("{:016x}", static_cast<std::uint64_t>(key.boot_id));
    std::string name = std::to_string(key.shot_id);
    for (std::size_t digits = kDigits; !taken.insert(name).second && digits <= boot.size(); ++digits)
      name = fmt::format("{}/{}", key.shot_id, boot.substr(0, digits));
    names.push_back(name);
  }
  assert(names.size() == shots.size());
  return names;
}

}  // namespace strobe::host
