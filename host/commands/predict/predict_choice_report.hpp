// How `strobe predict` tells what it chose: as JSON and as text.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/commands/predict/predict_choice.hpp"

namespace strobe::host {

nlohmann::ordered_json choice_json(const ImpactChoice& choice, const frontier::Demand& demand);

std::vector<std::string> choice_lines(const ImpactChoice& choice, const frontier::Demand& demand);

}  // namespace strobe::host
