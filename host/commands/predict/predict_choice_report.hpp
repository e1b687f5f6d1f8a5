// The choice of `strobe predict` as JSON and as text. Pure; thread-safe.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/commands/predict/predict_choice.hpp"

namespace strobe::host {

nlohmann::ordered_json choice_json(const ImpactChoice& choice, const frontier::Requirement& requirement);

std::vector<std::string> choice_lines(const ImpactChoice& choice, const frontier::Requirement& requirement);

}  // namespace strobe::host
