// The record of a session: notes "key = value" from the rig file's [record], the command line and the
// firmware. And what a laboratory states of itself, of a job and of its instruments, for a report: the rig
// file's [laboratory] and [report], which strobed and the analysis do not use. Text on one line each.
// Constants and pure functions; thread-safe. Source of the statements: ISO/IEC 17025:2017, 7.8.2 and 7.8.3.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/toml_reader.hpp"
#include "common/reduction/frame.hpp"
#include "common/result.hpp"

namespace strobe::host {

/// Keys with a meaning of their own: shown by name and given a column of results.csv. Any other key is kept
/// too.
inline constexpr std::array<std::string_view, 14> kNamedNotes{"spin",
                                                              "angle_deg",
                                                              "frame_number",
                                                              "ball_name",
                                                              "ball_grade",
                                                              "surface_name",
                                                              "surface_grade",
                                                              "temperature_c",
                                                              "camera_distance_m",
                                                              "machine_distance_m",
                                                              "machine_angle_deg",
                                                              "surface_angle_deg",
                                                              "operator",
                                                              "remarks"};

/// What is wrong with the note, or nothing: keys are 1 to 64 of [a-z0-9_.], values UTF-8 of at most 1024
/// bytes without control characters.
std::optional<std::string> note_problem(std::string_view key, std::string_view value);

/// Adds "key=value" (spaces around both are dropped), replacing an entry of the same key.
Result<void> add_note(reduction::Record& record, std::string_view text);

/// The note read as a number, if there is one and it is a finite number through to its end.
std::optional<double> note_number(const reduction::Record& record, std::string_view key);

struct StatementKey {
  std::string_view id;          ///< in JSON; as an option with - for _
  std::string_view table, key;  ///< in the rig file
  std::string_view label;
  std::string_view example;
};

inline constexpr std::array<StatementKey, 20> kStatementKeys{{
    {"title", "report", "title", "Title", "Test report: impact of a ball on a surface"},
    {"laboratory", "laboratory", "name", "Laboratory", "Sports Surfaces Laboratory"},
    {"address", "laboratory", "address", "Address", "1 Main Street, Springfield"},
    {"contact", "laboratory", "contact", "Contact", "lab@example.org"},
    {"location", "laboratory", "location", "Place of the tests", "hall 2"},
    {"accreditation", "laboratory", "accreditation", "Accreditation", "none"},
    {"customer", "report", "customer", "Customer", "Courts Ltd."},
    {"customer_contact", "report", "customer_contact", "Customer's contact", "2 Main Street, Springfield"},
    {"item", "report", "item", "Item tested", "sample 17, acrylic hard court, 600 x 600 mm"},
    {"item_condition", "report", "item_condition", "Condition of the item", "new, clean, dry"},
    {"received", "report", "received", "Date of receipt", "2026-11-02"},
    {"sampling", "report", "sampling", "Sampling", "by the customer"},
    {"method", "report", "method", "Method", "ITF CS 01/02"},
    {"deviations", "report", "deviations", "Deviations from the method", "none"},
    {"conditions", "report", "conditions", "Environmental conditions", "21 C, 45 % relative humidity"},
    {"tested_by", "report", "tested_by", "Operator", "J. Smith"},
    {"authorised_by", "report", "authorised_by", "Authorised by", "A. Jones"},
    {"authorised_role", "report", "authorised_role", "Role", "head of laboratory"},
    {"issued", "report", "issued", "Date of issue", "2026-11-21"},
    {"remarks", "report", "remarks", "Remarks", "the ball was changed after shot 6"},
}};

/// By StatementKey::id; what is not stated is absent.
using Statements = std::map<std::string, std::string>;

/// What is wrong with a statement, or nothing: text of at most 1024 bytes on one line; `received` and
/// `issued` are days as 2026-11-21.
std::optional<std::string> statement_problem(const StatementKey& key, const std::string& text);

/// A [[report.instrument]]: what a result is traced to. Texts as of statements; empty: not stated.
struct Instrument {
  std::string name;             ///< with its number; never empty
  std::string certificate;      ///< of its calibration
  std::string calibrated, due;  ///< days, as 2026-11-21; `due` is not before `calibrated`
};

/// Reads both tables; what is wrong is reported to the document's reader. Empty texts state nothing.
Statements read_statements(config::TomlTable root);
std::vector<Instrument> read_instruments(config::TomlTable report);

}  // namespace strobe::host
