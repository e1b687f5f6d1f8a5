// From sessions to a report, and its two ways to be written: HTML and JSON. build_report() reads the
// sessions' files (photographs, and all that is hashed); otherwise all are pure functions: the same input and
// files give the same bytes. Not thread-safe where `progress` is not; they allocate.
#pragma once

#include <optional>
#include <string>

#include "host/report/content.hpp"
#include "host/report/model.hpp"

namespace strobe::report {

Report build_report(const ReportInput& input);

/// One HTML file that needs nothing else: no script, no network, nothing loaded. It is well-formed XML, too.
std::string render_html(const Report& report);

/// {"report":{"id","title","issued"},"sections":{KEY:{"number","title","facts":{KEY:{...}},"tables":{KEY:{...}},
/// …}}} on one line: all that the HTML shows, by name, with numbers at full precision beside the texts that
/// are shown. Numbers that are not finite are null; bytes that are not UTF-8 become U+FFFD.
std::string report_json(const Report& report);

/// The thesis's tables and fits that come with strobe, to be set beside; absent where they are not installed.
/// Reads files.
std::optional<thesis::ThesisInputs> shipped_thesis();

}  // namespace strobe::report
