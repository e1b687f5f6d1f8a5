// What the witnesses of a series say, for a person and for a program. Pure; thread-safe.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/series/drift.hpp"

namespace strobe::host {

/// "! drift since shot 12, told at shot 14: scale by the balls' diameters", how far each number has moved,
/// and what explains that; none: nothing to say.
std::vector<std::string> render_drift(const WitnessCharts& charts);

/// A row for each shot: the witnesses' values, and beneath each how far it is off in sds; then the sums.
std::vector<std::string> render_witnesses(const WitnessCharts& charts);

/// shots, charts (values, scores, sums, limit, alarm), verdict (null: all is well).
nlohmann::ordered_json drift_json(const WitnessCharts& charts);

}  // namespace strobe::host
