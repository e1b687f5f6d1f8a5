// A program run to its end as a user runs it, and what is expected of its answers. Failures fail the test.
#pragma once

#include "tests/support/json_lines.hpp"
#include "tests/support/process.hpp"
#include "tests/support/string_from.hpp"

namespace strobe::testing {

/// The program, then its arguments.
inline CompletedProcess run_program(std::vector<std::string> words,
                                    std::map<std::string, std::string> environment = {}) {
  return run_process({.arguments = std::move(words), .environment = std::move(environment)},
                     std::chrono::seconds(100));
}

/// One line of strobe's on standard error, nothing on standard output.
inline void check_refused(const CompletedProcess& run, const std::string& complaint, int code = 2) {
  CHECK_EQUAL("strobe: " + complaint + "\n", run.err);
  CHECK_EQUAL("", run.out);
  LONGS_EQUAL(code, run.status->code);
}

/// Of a run that succeeded.
inline std::vector<nlohmann::json> jsons_of(const CompletedProcess& run) {
  LONGS_EQUAL_TEXT(0, run.status->code, run.err.c_str());
  return parse_json_lines(run.out);
}

/// The same, where there is one.
inline nlohmann::json json_of(const CompletedProcess& run) {
  const auto lines = jsons_of(run);
  LONGS_EQUAL(1, lines.size());
  return lines.at(0);
}

inline void check_prints(const CompletedProcess& run, std::initializer_list<const char*> parts) {
  LONGS_EQUAL_TEXT(0, run.status->code, run.err.c_str());
  for (const char* part : parts) STRCMP_CONTAINS(part, run.out.c_str());
}

}  // namespace strobe::testing
