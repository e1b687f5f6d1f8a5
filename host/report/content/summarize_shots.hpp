// A session's shots as a series takes them, for reports. Pure; thread-safe; allocates.
#pragma once

#include "host/report/content/report_input.hpp"

namespace strobe::lab_report {

/// Knows the shots of these sessions alone. What of each shot's uncertainty other shots share is found at once: some
/// milliseconds a shot.
Summarize summarize_shots(const std::vector<host::StoredSession>& sessions);

}  // namespace strobe::lab_report
