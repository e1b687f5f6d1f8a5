// The results of `strobe fit` as text or as JSON objects. Writes to stdout; single-threaded.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/impact/fit/model_fit.hpp"
#include "common/impact/fit/regime.hpp"
#include "common/impact/fit/rolling_friction.hpp"
#include "host/commands/fit_data.hpp"

namespace strobe::host {

struct FitReport {
  FitData data;
  impact::FitOptions options;
  impact::ModelFit fit;
  std::vector<impact::RegimeClassification> regimes;      ///< one for each observation
  std::vector<impact::RollingFriction> rolling_friction;  ///< one for each observation
  std::optional<impact::CrossValidation> validation;
  impact::CrossValidationGroup grouped_by = impact::CrossValidationGroup::spin;
};

/// A parameter's value in the unit of the command line, and back: d in mm, dwell in ms, the others in SI
/// units.
double to_display_unit(impact::Parameter parameter, double value);
double from_display_unit(impact::Parameter parameter, double value);
const char* display_unit(impact::Parameter parameter);  ///< " mm", " m/s", " ms" or ""

/// What the data do not tell, a line each: parameters as uncertain as before, pairs of which only a
/// combination is known.
std::vector<std::string> left_open(const impact::ModelFit& fit);

/// Lines of type "fit", then "observation" for each, then "left_out" for each group and "validation".
void print_fit_json(const FitReport& report);
void print_fit_text(const FitReport& report);

}  // namespace strobe::host
