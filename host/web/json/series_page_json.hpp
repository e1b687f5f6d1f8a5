// A series for the page: run charts with their limits, and what the shots say together. Pure; thread-safe; allocates.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>

#include "common/data/thesis_data.hpp"
#include "host/series/series.hpp"
#include "host/web/json/shot_json.hpp"

namespace strobe::web {

/// {"summary","points","limits","thesis"}. rows: all shots of the series in the order of firing, those that do not count,
/// too; dry ones are left out. Limits: host/series/series.hpp; null where there are too few shots.
nlohmann::ordered_json series_page_json(const host::SeriesSummary& summary,
                                        const std::optional<thesis::Condition>& condition,
                                        std::span<const ShotRow> rows);

/// The thesis's series where all rows have one spin and angle. Reads the file that comes with strobe.
std::optional<thesis::Condition> condition_of(std::span<const ShotRow> rows);

}  // namespace strobe::web
