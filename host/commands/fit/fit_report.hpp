// What `strobe fit` found, as text or as JSON objects. Writes to stdout; one thread's.
#pragma once

#include <optional>
#include <vector>

#include "common/impact/fit/cross_validation.hpp"
#include "common/impact/fit/regime.hpp"
#include "common/impact/fit/rolling_friction.hpp"
#include "host/commands/fit/fit_data.hpp"

namespace strobe::host {

struct FitReport {
  FitData data;
  impact::FitOptions options;
  impact::ModelFit fit;
  std::vector<impact::RegimeJudgement> regimes;           ///< one for each observation
  std::vector<impact::RollingFriction> rolling_friction;  ///< one for each observation
  std::optional<impact::Validation> validation;
  impact::LeaveOut left_out_by = impact::LeaveOut::spin;
};

/// A parameter's value as the command line has it: d in mm, the others as they are.
double at_the_edge(impact::Parameter parameter, double value);
double from_the_edge(impact::Parameter parameter, double value);
const char* unit_at_the_edge(impact::Parameter parameter);  ///< " mm", " m/s" or ""

/// Lines of type "fit", then "observation" for each, then "left_out" for each group and "validation".
void print_fit_json(const FitReport& report);
void print_fit_text(const FitReport& report);

}  // namespace strobe::host
