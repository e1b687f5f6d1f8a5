// The record of measured figures (figures.json) and the tables that READMEs show of it. Reads and writes no files except
// in load(); single-threaded.
//
// A figure is one command and one or more values that a pattern finds in its output:
//   "what": what was measured; "command": the line that measures it, run in the repository's folder with the programs on
//   PATH; "text": how a README states it, each {name} standing for a value; "measured": the day; "machine": what kind of;
//   "values": {"name": {"value": 0.985, "pattern": "an ECMAScript regex whose first group is the number",
//   "take": "min" | "max" | "median" | "sum" | "last" (default) of its matches, "factor": to the text's unit (default 1),
//   "digits": significant digits kept (default 3), "tolerance": share by which a new measurement may differ,
//   "worse": "higher" | "lower" | "either" (default)}}.
// A value without a pattern was measured by hand; measure leaves it alone.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/result.hpp"

namespace strobe::figures {

using Json = nlohmann::ordered_json;

/// Fails with one line that names the file if it cannot be read, is no JSON, or lacks a field.
Result<Json> load(const std::filesystem::path& file);

/// "{low} to {high}" with the values put in. Fails if a name is unknown.
Result<std::string> stated(const Json& figure);

/// The Markdown table of the named group's figures. Fails if the group or one of its figures is unknown.
Result<std::string> table_of(const Json& record, const std::string& group);

/// `text` with what stands between each pair of markers generated anew:
///   <!-- figures: GROUP -->            a table
///   <!-- end of figures -->
///   <!-- figure: NAME -->text<!-- end of figure -->   a figure's text within a sentence
/// Fails if a marker has no end or names what is not in the record.
Result<std::string> regenerated(const std::string& text, const Json& record);

/// The value that `output` holds. Returns nullopt if its pattern matches nothing.
std::optional<double> found_in(const std::string& output, const Json& value);

enum class Change { same, moved, worse };

/// `same` within the tolerance; beyond it `worse` in the direction that the record names, otherwise `moved`.
Change compare(double recorded, double measured, const Json& value);

}  // namespace strobe::figures
