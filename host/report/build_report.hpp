// From sessions to a report. Reads the sessions' files (photographs, and all that is hashed); otherwise a pure function of its
// input: the same input and files give the same report. Not thread-safe where `progress` is not.
#pragma once

#include "host/report/content/report_input.hpp"
#include "host/report/model/model.hpp"

namespace strobe::lab_report {

Report build_report(const ReportInput& input);

}  // namespace strobe::lab_report
