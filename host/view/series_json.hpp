// What a series says, for a program: JSON objects with keys in fixed order; what is not known is null. Pure;
// thread-safe.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/data/thesis_data.hpp"
#include "common/reduction/uncertainty.hpp"
#include "host/series/compare.hpp"
#include "host/series/series.hpp"

namespace strobe::host {

/// name, counted, rejected, until_known, quantities (each with its budget), outliers.
nlohmann::ordered_json series_json(const SeriesSummary& summary,
                                   const std::optional<thesis::Condition>& condition);
nlohmann::ordered_json comparison_json(const std::string& first, const std::string& second,
                                       const Comparison& comparison);
nlohmann::ordered_json monte_carlo_json(const reduction::MonteCarlo& drawn);

nlohmann::ordered_json budget_json(const std::vector<BudgetLine>& lines);

/// Of one shot: for each quantity its lines.
nlohmann::ordered_json budget_json(const reduction::Budget& budget, const reduction::Readout& readout);

}  // namespace strobe::host
