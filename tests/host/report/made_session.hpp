// Stored sessions of synthetic shots, whose readouts the shipped assembly made. One thread.
#pragma once

#include <string>

#include "host/report/content.hpp"

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

report::ReportInput input_of(host::StoredSession session);

}  // namespace strobe::report_test
