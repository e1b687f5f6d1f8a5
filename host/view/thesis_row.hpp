// The thesis's numbers beside one's own. Pure; thread-safe.
#pragma once

#include <optional>
#include <string>

#include "common/data/thesis_data.hpp"
#include "common/reduction/readout.hpp"

namespace strobe::host {

/// "thesis zero 23, Tables 2, 5, 8"
std::string thesis_title(const thesis::Condition& condition);

/// What the thesis printed of the quantity; absent: nothing.
std::optional<thesis::MeanSd> thesis_number(const thesis::Condition& condition, reduction::Quantity q);

/// Mean, sd, and how far `mean` is from it in its sds; empty where the thesis has none.
std::string thesis_cells(const thesis::Condition& condition, reduction::Quantity q,
                         const std::optional<double>& mean);

}  // namespace strobe::host
