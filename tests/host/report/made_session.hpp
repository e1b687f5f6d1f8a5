// Stored sessions of synthetic shots, whose readouts the shipped assembly made. One thread.
#pragma once

#include <string>

#include "host/report/content/report_input.hpp"

namespace strobe::report_test {

struct MadeSession {
  int shots = 3;
  std::string spin = "zero", angle = "23";
  int rejected = 0;    ///< the last ones
  std::string note{};  ///< a remark in each shot's record
  std::string rig_lines{};
  bool tops = false;  ///< tops of images in contact are measured
};

host::StoredSession made_session(const MadeSession& settings = {});

/// Mean, scatter, and twice the total: enough to be shown, computed from the shots.
host::SeriesSummary plain_summary(const std::string& name, const std::vector<lab_report::ReportShot>& shots);

lab_report::ReportInput input_of(host::StoredSession session);

}  // namespace strobe::report_test
