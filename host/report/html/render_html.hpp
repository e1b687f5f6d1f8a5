// A report as one HTML file that needs nothing else: no script, no network, nothing loaded. It is well-formed XML, too. The
// same report gives the same bytes. Pure; thread-safe; allocates.
#pragma once

#include <string>

#include "host/report/model/model.hpp"

namespace strobe::lab_report {

std::string render_html(const Report& report);

}  // namespace strobe::lab_report
