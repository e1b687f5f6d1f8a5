#include "host/session/data_dictionary.hpp"

#include <fmt/format.h>

#include <array>

#include "common/reduction/readout.hpp"
#include "host/config/notes.hpp"

namespace strobe::host {
namespace {

struct Meaning {
  std::string_view unit;
  std::string_view text;
};

constexpr std::array<Meaning, reduction::kQuantityCount> kQuantities{{
    {"deg", "angle of the velocity to the surface at touchdown, negative on the way in"},
    {"deg", "angle of the velocity to the surface at lift-off"},
    {"m/s", "velocity along the surface at touchdown, positive in the direction of travel"},
    {"m/s", "velocity normal to the surface at touchdown, positive away from it"},
    {"m/s", "speed at touchdown"},
    {"rad/s",
     "spin at touchdown, counter-clockwise positive as the camera sees a ball that travels to the right: "
     "backspin is positive"},
    {"m/s", "velocity along the surface at lift-off"},
    {"m/s", "velocity normal to the surface at lift-off"},
    {"m/s", "speed at lift-off"},
    {"rad/s", "spin at lift-off"},
    {"m/s", "speed of the contact point along the surface at lift-off, vx + R omega"},
    {"1", "coefficient of restitution: -vy at lift-off over vy at touchdown"},
    {"1", "impulse ratio: (vx touchdown - vx lift-off) / (vy lift-off - vy touchdown)"},
    {"ms", "dwell time: from touchdown to lift-off"},
    {"cm", "dwell distance: along the surface, from touchdown to lift-off"},
    {"1", "court pace rating (ITF CS 01/02); needs temperature_c"},
}};

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

void add_quantities(std::vector<Column>& columns, std::string_view prefix, std::string_view words) {
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i)
    columns.push_back({fmt::format("{}{}", prefix, reduction::kQuantityNames[i]), "number",
                       std::string(kQuantities[i].unit), fmt::format("{}{}", words, kQuantities[i].text)});
}

/// Operators write them: a number among them may be any text.
void add_notes(std::vector<Column>& columns) {
  for (std::size_t i = 0; i < kNamedNotes.size(); ++i)
    columns.push_back({std::string(kNamedNotes[i]), "string", std::string(kNotes[i].unit),
                       fmt::format("{}, as recorded", kNotes[i].text)});
  columns.push_back({"other_notes", "string", "", "further notes of the record, key=value", ';'});
}

std::vector<Column> make_results_columns() {
  std::vector<Column> columns{
      {"utc", "dateTime", "", "when the result came, by the host's clock"},
      {"boot_id", "string", "", "start of the firmware that fired the shot, hexadecimal"},
      {"shot_id", "integer", "", "number of the shot in its session"},
      {"rejected", "string", "", "why the shot does not count; empty: it counts"},
  };
  add_quantities(columns, "", "");
  add_quantities(columns, "sd_", "standard deviation, given the ball's diameter and the air, of: ");
  add_quantities(columns, "sd_systematic_",
                 "standard deviation from the tolerances of the ball's diameter and of the air, of: ");
  columns.insert(
      columns.end(),
      {{"regime", "string", "", "slides: throughout the contact; grips: not; unclear: either"},
       {"court_pace_conforming", "boolean", "", "the shot met the court pace's conditions"},
       {"method", "string", "", "estimator: best, two-point or legacy"},
       {"mirrored", "boolean", "", "the ball travelled to the left; numbers are of its mirror image"},
       {"flags", "string", "", "what was unusual (common/reduction/README.md)", ';'}});
  add_notes(columns);
  columns.insert(
      columns.end(),
      {{"first_flash", "integer", "1", "flash, numbered as fired from 0, that made the first image"},
       {"last_flash", "integer", "1", "flash, numbered as fired from 0, that made the last image"},
       {"misassignment_probability", "number", "1", "probability that other flashes made these images"},
       {"digitization", "string", "",
        "who measured the photograph: auto, hand, or corrected by a person afterwards; empty: there is none"},
       {"shot", "string", "",
        "what the shot is called: its number and, where an earlier start of the firmware had the same, its "
        "start"}});
  return columns;
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

/// In quotes. Written as text, since nlohmann's destructors need memory: where there is none they end the program.
std::string json_string(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + "\"";
}

std::string column_json(const Column& column) {
  std::string json = fmt::format("{{\"name\": {0}, \"titles\": {0}, \"datatype\": {1}", json_string(column.name),
                                 json_string(column.datatype));
  if (column.separator != 0) json += fmt::format(", \"separator\": \"{}\"", column.separator);
  if (!column.unit.empty()) json += fmt::format(", \"schema:unitCode\": {}", json_string(column.unit));
  return json + fmt::format(", \"dc:description\": {}}}", json_string(column.meaning));
}

}  // namespace

const std::vector<Column>& results_columns() {
  static const std::vector<Column> columns = make_results_columns();
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

}  // namespace strobe::host
