// What `strobe design` says, for a person, as JSON and as figures. Pure but for write_design_figures();
// thread-safe.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/design/improvements.hpp"
#include "host/design/needs.hpp"
#include "host/design/train_search.hpp"

namespace strobe::host {

struct DesignReport {
  Design design;
  std::vector<std::string> remarks;             ///< what is beyond what was measured of the ball's kind
  std::string train_remark;                     ///< how the plan is coded; may be empty
  std::vector<reduction::Quantity> quantities;  ///< that matter
  Prediction prediction;
  std::optional<FoundTrain> best;
  std::vector<Need> needs;
  std::vector<Improvement> improvements;
};

/// `all`: every quantity, and whole budgets.
std::vector<std::string> render_design(const DesignReport& report, std::size_t width, bool all);

nlohmann::ordered_json design_json(const DesignReport& report);

/// images.svg: where the images of a mean ball will lie; uncertainty.svg: the half width of each wanted
/// mean's 95 % interval by balls, flash period and scale; with the numbers as CSV. Makes the folder. Fails
/// with its name.
Result<void> write_design_figures(const DesignReport& report, const std::filesystem::path& folder);

}  // namespace strobe::host
