// What is said of a shot, once for all who say it: each field's name, unit, meaning and text. results.csv,
// its header and data dictionary (NAME.csv-metadata.json beside each table) are made of it, as are the
// columns of flashes.csv; and results.csv read back. A file grows by whole lines over any number of runs
// (record_file.hpp). ResultsCsv writes a file, one thread's; the functions are pure but for
// read_results_rows(), thread-safe, and allocate. Source: W3C, Metadata Vocabulary for Tabular Data (2015);
// units by UCUM (ucum.org).
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "common/shot/shot_key.hpp"
#include "host/session/record_file.hpp"
#include "host/session/shot.hpp"

namespace strobe::host {

/// A readout's number for a person.
struct QuantityLabel {
  std::string_view words;
  std::string_view unit;  ///< UCUM; empty: a pure number
  std::string_view meaning;
};

/// In the order of reduction::Quantity, whose names are those of columns and keys.
inline constexpr std::array<QuantityLabel, reduction::kQuantityCount> kQuantityLabels{{
    {"angle in", "deg", "angle of the velocity to the surface at touchdown, negative on the way in"},
    {"angle out", "deg", "angle of the velocity to the surface at lift-off"},
    {"vx touchdown", "m/s", "velocity along the surface at touchdown, positive in the direction of travel"},
    {"vy touchdown", "m/s", "velocity normal to the surface at touchdown, positive away from it"},
    {"speed touchdown", "m/s", "speed at touchdown"},
    {"spin touchdown", "rad/s",
     "spin at touchdown, counter-clockwise positive as the camera sees a ball that travels to the right: "
     "backspin is positive"},
    {"vx lift-off", "m/s", "velocity along the surface at lift-off"},
    {"vy lift-off", "m/s", "velocity normal to the surface at lift-off"},
    {"speed lift-off", "m/s", "speed at lift-off"},
    {"spin lift-off", "rad/s", "spin at lift-off"},
    {"slip lift-off", "m/s", "speed of the contact point along the surface at lift-off, vx + R omega"},
    {"restitution e", "", "coefficient of restitution: -vy at lift-off over vy at touchdown"},
    {"impulse ratio mu", "", "impulse ratio: (vx touchdown - vx lift-off) / (vy lift-off - vy touchdown)"},
    {"dwell time", "ms", "dwell time: from touchdown to lift-off"},
    {"dwell distance", "cm", "dwell distance: along the surface, from touchdown to lift-off"},
    {"court pace", "", "court pace rating (ITF CS 01/02); needs temperature_c"},
}};

/// In the order of reduction::SpatialQuantity.
inline constexpr std::array<QuantityLabel, reduction::kSpatialCount> kSpatialLabels{{
    {"spin x touchdown", "rad/s", "spin about the direction of travel along the surface at touchdown"},
    {"spin y touchdown", "rad/s", "spin about the surface's normal at touchdown: sidespin"},
    {"spin z touchdown", "rad/s", "spin about the axis towards the camera at touchdown"},
    {"axis touchdown", "deg", "angle of the spin's axis to the camera's at touchdown, 0 to 90"},
    {"vz touchdown", "m/s", "velocity towards the camera at touchdown"},
    {"spin x lift-off", "rad/s", "spin about the direction of travel along the surface at lift-off"},
    {"spin y lift-off", "rad/s", "spin about the surface's normal at lift-off: sidespin"},
    {"spin z lift-off", "rad/s", "spin about the axis towards the camera at lift-off"},
    {"axis lift-off", "deg", "angle of the spin's axis to the camera's at lift-off, 0 to 90"},
    {"vz lift-off", "m/s", "velocity towards the camera at lift-off"},
    {"off the plane", "mm", "the ball's centre at touchdown before the calibrated plane, towards the camera"},
}};

struct Column {
  std::string name;
  std::string datatype;  ///< of that vocabulary: "string", "number", "integer", "boolean", "dateTime"
  std::string unit;      ///< UCUM; "1": a pure number; empty: no quantity
  std::string meaning;   ///< one sentence
  char separator = 0;    ///< a cell is a list of values that this separates; 0: one value
};

/// A column of results.csv, and what of a shot stands there: numbers with the fewest digits that read back to
/// the same value; what could not be had is empty.
struct ShotField {
  Column column;
  std::function<std::string(const Shot&)> text;
};

/// In the order of results.csv, which is stable: new fields come last, and hold no commas.
const std::vector<ShotField>& shot_fields();
/// Their columns.
const std::vector<Column>& results_columns();
/// Of flashes.csv, in its order.
const std::vector<Column>& flashes_columns();

/// "utc,boot_id,shot_id"
std::string csv_header(std::span<const Column> columns);

/// The metadata file of a table. title: for a person.
std::string data_dictionary(std::string_view file_name, std::string_view title,
                            std::span<const Column> columns);

std::string results_header();
inline constexpr std::string_view kResultsTitle = "Results, one row per shot";
/// Those of earlier versions, which lacked the last columns, newest first.
std::vector<std::string> earlier_results_headers();

/// Who measured the photograph: "auto", "hand", or "corrected" by a person afterwards.
std::string_view digitization_word(const Digitization& digitization);
/// Of the one that counts; empty: there is none.
std::string_view digitization_word(const Shot& shot);

/// Without its end.
std::string results_line(const Shot& shot);

class ResultsCsv {
 public:
  /// Fails where CsvFile does.
  static Result<ResultsCsv> open(const std::filesystem::path& path);

  /// Under the name that tells the shot from those before it in the file.
  Result<void> add(Shot shot);

  std::size_t left_out() const { return file_.left_out(); }
  RecordFile& file() { return file_.file(); }
  const RecordFile& file() const { return file_.file(); }

 private:
  ResultsCsv(CsvFile file, std::vector<ShotKey> shots) : file_(std::move(file)), shots_(std::move(shots)) {}

  CsvFile file_;
  std::vector<ShotKey> shots_;  ///< of its lines
};

struct ResultsRow {
  ShotKey key;
  std::string utc;
  bool counts = false;  ///< it is not rejected
  std::string line;     ///< as it stands there, without its end
};

/// Of a boot, hexadecimal, and a shot's number; absent: they are not both whole numbers.
std::optional<ShotKey> shot_key_in(std::string_view boot_id, std::string_view shot_id);

/// Rows of any text: the header and lines that do not begin with a time, a boot and a shot are left out, as
/// is a last line that was cut short. Quoted fields may hold line ends.
std::vector<ResultsRow> parse_results(std::string_view text);

/// Those of a file, of any size; none if there is no such file. Fails with its name if it cannot be read.
Result<std::vector<ResultsRow>> read_results_rows(const std::filesystem::path& file);

/// What a person calls the shots of a session, in their order: the shot's number; where an earlier one has
/// that, with as many hexadecimal digits of its boot as tell it apart, six or more: "3/1f2e4d".
std::vector<std::string> shot_names(const std::vector<ShotKey>& shots);

}  // namespace strobe::host
