// A report as one JSON object: all that the HTML shows, by name, with numbers at full precision beside the texts that are
// shown. Pure; thread-safe; allocates.
#pragma once

#include <string>

#include "host/report/model/model.hpp"

namespace strobe::lab_report {

/// {"report":{"id","title","issued"},"sections":{KEY:{"number","title","facts":{KEY:{...}},"tables":{KEY:{...}}, …}}}
/// on one line. Numbers that are not finite are null; bytes that are not UTF-8 become U+FFFD.
std::string report_json(const Report& report);

/// The id that follows from all else: the same content has the same one.
std::string identify(const Report& report);

}  // namespace strobe::lab_report
