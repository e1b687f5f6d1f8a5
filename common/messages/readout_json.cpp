#include <nlohmann/json.hpp>
#include <utility>

#include "common/messages/json_conversions.hpp"
#include "common/messages/or_null.hpp"
#include "common/messages/parsed_json.hpp"
#include "common/reduction/uncertainty.hpp"

namespace strobe::messages {
namespace {

using nlohmann::ordered_json;
using reduction::Quantities;
using reduction::Readout;

void put(ordered_json& object, const Quantities& quantities) {
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto quantity = static_cast<reduction::Quantity>(i);
    object[std::string(name(quantity))] = or_null(quantities[quantity]);
  }
}

ordered_json quantities_json(const Quantities& quantities) {
  ordered_json object = ordered_json::object();
  put(object, quantities);
  return object;
}

ordered_json expanded_json(const Readout& readout) {
  Quantities expanded;
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto quantity = static_cast<reduction::Quantity>(i);
    expanded[quantity] = reduction::expanded_uncertainty(readout, quantity);
  }
  return quantities_json(expanded);
}

ordered_json flags_json(const reduction::FlagSet& flags) {
  ordered_json names = ordered_json::array();
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    const auto flag = static_cast<reduction::Flag>(i);
    if (flags.has(flag)) names.push_back(std::string(name(flag)));
  }
  return names;
}

ordered_json contact_json(const reduction::ContactImage& image) {
  ordered_json object;
  object["height_cm"] = image.height_cm;
  object["time_fraction"] = image.time_fraction;
  object["x_fraction"] = image.x_fraction;
  object["y_fraction"] = image.y_fraction;
  object["rotation_fraction"] = image.rotation_fraction;
  return object;
}

void put_flashes(ordered_json& object, const std::optional<reduction::ImagedFlashes>& flashes) {
  object["first_flash"] = flashes ? ordered_json(flashes->first) : ordered_json();
  object["last_flash"] = flashes ? ordered_json(flashes->last) : ordered_json();
  object["misassignment_probability"] =
      flashes ? ordered_json(flashes->misassignment_probability) : ordered_json();
}

void put_assignments(ordered_json& object, const std::optional<reduction::Assignments>& assignments) {
  object["assignments"] = assignments ? ordered_json(assignments->hypotheses) : ordered_json();
  object["sd_assignments"] = assignments ? quantities_json(assignments->sd) : ordered_json();
}

void put_residual_ratios(ordered_json& object, const reduction::ResidualRatios& ratios) {
  object["residual_ratio"] = or_null(ratios.all);
  ordered_json& by_kind = object["residual_ratio_by_kind"] = ordered_json::object();
  for (std::size_t i = 0; i < reduction::kMeasurementKindCount; ++i)
    by_kind[std::string(reduction::kMeasurementKindNames[i])] = or_null(ratios.by_kind[i]);
}

}  // namespace

std::string readout_to_json(const Readout& readout) {
  ordered_json object;
  object["shot_id"] = readout.shot_id;
  put(object, readout.value);
  object["regime"] = readout.regime ? ordered_json(std::string(name(*readout.regime))) : ordered_json();
  object["court_pace_conforming"] = readout.court_pace_conforming;
  object["method"] = readout.method;
  object["mirrored"] = readout.mirrored;
  object["flight_effects"] = ordered_json::array();
  for (std::size_t i = 0; i < flight::kEffectNames.size(); ++i) {
    if (!(readout.flight_effects.*flight::kEffectMembers[i])) continue;
    object["flight_effects"].push_back(std::string(flight::kEffectNames[i]));
  }
  object["flags"] = flags_json(readout.flags);
  put_flashes(object, readout.flashes);
  put_assignments(object, readout.assignments);
  object["sd"] = quantities_json(readout.sd);
  object["sd_systematic"] = quantities_json(readout.sd_systematic);
  object["degrees_of_freedom"] = quantities_json(readout.degrees_of_freedom);
  object["expanded_uncertainty"] = expanded_json(readout);
  put_residual_ratios(object, readout.residual_ratios);
  if (readout.legacy) {
    object["far"] = quantities_json(readout.legacy->far);
    object["contact"] = ordered_json::array();
    for (const auto& image : readout.legacy->contact) object["contact"].push_back(contact_json(image));
  }
  object["record"] = ordered_json::object();
  for (const auto& [key, value] : readout.record) object["record"][key] = value;
  return json_text(object);
}

}  // namespace strobe::messages
