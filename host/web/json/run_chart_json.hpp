// A series as the page draws it: what it says, its shots in their order, and the limits of each run chart. Values; pure;
// thread-safe; allocates.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/data/thesis_data.hpp"
#include "host/series/series.hpp"
#include "host/web/json/shot_json.hpp"

namespace strobe::web {

/// Limits within which single shots of a steady process lie (99.7 %): mean ± 3 standard deviations as the differences of
/// consecutive shots tell them, so that a drift does not widen them. Source: ISO 7870-2:2013, chart of individual values.
struct RunLimits {
  double mean = 0.0, lower = 0.0, upper = 0.0;
};
/// values: in the order of the shots. Absent below two.
std::optional<RunLimits> run_limits(const std::vector<double>& values);

/// {"name","utc","counted","rejected","values"}
nlohmann::ordered_json point_json(const ShotRow& row);
/// {quantity: {"mean","lower","upper"} or null}
nlohmann::ordered_json limits_json(const host::Series& series);
/// {quantity: {"value","sd"}}, of the quantities that the thesis has; null without a condition.
nlohmann::ordered_json thesis_json(const std::optional<thesis::Condition>& condition);

/// {"summary","points","limits","thesis"} as text. points: of point_json(), as text.
std::string run_chart_text(const std::string& name, const host::Series& series, const std::vector<std::string>& points,
                           const std::optional<thesis::Condition>& condition);

}  // namespace strobe::web
