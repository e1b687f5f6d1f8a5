// Readouts to JSON.
#include <nlohmann/json.hpp>

#include "common/messages/json_conversions.hpp"
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

Quantities expanded(const reduction::Numbers& numbers) {
  Quantities all;
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto quantity = static_cast<reduction::Quantity>(i);
    all[quantity] = reduction::expanded_uncertainty(numbers, quantity);
  }
  return all;
}

ordered_json launch_json(const reduction::Launch& launch) {
  const auto put = [](ordered_json& object, const Quantities& quantities) {
    for (const auto& [name, quantity] : reduction::kLaunchQuantities)
      object[std::string(name)] = or_null(quantities[quantity]);
  };
  ordered_json object{{"time_s", launch.time_s}};
  put(object, launch.value);
  put(object["sd"], launch.sd);
  put(object["sd_systematic"], launch.sd_systematic);
  put(object["degrees_of_freedom"], launch.degrees_of_freedom);
  put(object["expanded_uncertainty"], expanded(launch));
  return object;
}

template <std::size_t kCount>
ordered_json names_json(const std::array<std::string_view, kCount>& names, const std::bitset<kCount>& set) {
  ordered_json list = ordered_json::array();
  for (std::size_t i = 0; i < kCount; ++i) {
    if (set[i]) list.push_back(std::string(names[i]));
  }
  return list;
}

ordered_json contact_json(const reduction::ContactImage& image) {
  return {{"height_cm", image.height_cm},
          {"time_fraction", image.time_fraction},
          {"x_fraction", image.x_fraction},
          {"y_fraction", image.y_fraction},
          {"rotation_fraction", image.rotation_fraction}};
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

ordered_json drop_json(const reduction::Drop& drop) {
  const auto both = [&](double reduction::DerivedNumber::*number) -> ordered_json {
    return {{"fall_height_m", drop.fall_height_m.*number},
            {"rebound_height_m", drop.rebound_height_m.*number}};
  };
  ordered_json object = both(&reduction::DerivedNumber::value);
  object["sd"] = both(&reduction::DerivedNumber::sd);
  object["sd_systematic"] = both(&reduction::DerivedNumber::sd_systematic);
  return object;
}

ordered_json spatial_json(const reduction::Spatial& spatial) {
  ordered_json object;
  for (std::size_t i = 0; i < reduction::kSpatialCount; ++i) {
    const std::string key(reduction::kSpatialNames[i]);
    const auto& number = spatial.number[i];
    object[key] = number ? ordered_json(number->value) : ordered_json();
    object["sd"][key] = number ? ordered_json(number->sd) : ordered_json();
    object["sd_systematic"][key] = number ? ordered_json(number->sd_systematic) : ordered_json();
  }
  return object;
}

void put_residual_ratios(ordered_json& object, const reduction::ResidualRatios& ratios) {
  object["residual_ratio"] = or_null(ratios.all);
  ordered_json& by_kind = object["residual_ratio_by_kind"] = ordered_json::object();
  for (std::size_t i = 0; i < reduction::kMeasurementKindCount; ++i)
    by_kind[std::string(reduction::kMeasurementKindNames[i])] = or_null(ratios.by_kind[i]);
}

}  // namespace

ordered_json readout_json(const Readout& readout) {
  ordered_json object;
  object["shot_id"] = readout.shot_id;
  put(object, readout.value);
  object["regime"] = readout.regime ? ordered_json(std::string(name(*readout.regime))) : ordered_json();
  object["court_pace_conforming"] = readout.court_pace_conforming;
  object["method"] = readout.method;
  object["mirrored"] = readout.mirrored;
  std::bitset<flight::kEffectNames.size()> effects;
  for (std::size_t i = 0; i < effects.size(); ++i)
    effects[i] = readout.flight_effects.*flight::kEffectMembers[i];
  object["flight_effects"] = names_json(flight::kEffectNames, effects);
  object["flags"] = names_json(reduction::kFlagNames, readout.flags.bits());
  put_flashes(object, readout.flashes);
  put_assignments(object, readout.assignments);
  object["sd"] = quantities_json(readout.sd);
  object["sd_systematic"] = quantities_json(readout.sd_systematic);
  object["degrees_of_freedom"] = quantities_json(readout.degrees_of_freedom);
  object["expanded_uncertainty"] = quantities_json(expanded(readout));
  put_residual_ratios(object, readout.residual_ratios);
  object["spin_told_by"] = names_json(reduction::kSpinEvidenceNames, readout.spin_told_by.bits());
  if (const auto& cause = readout.likely_cause)
    object["likely_cause"] = {{"cause", name(cause->cause)}, {"value", cause->value}, {"sd", cause->sd}};
  if (readout.spatial) object["spatial"] = spatial_json(*readout.spatial);
  if (readout.drop) object["drop"] = drop_json(*readout.drop);
  if (readout.launch) object["launch"] = launch_json(*readout.launch);
  if (readout.legacy) {
    object["far"] = quantities_json(readout.legacy->far);
    object["contact"] = ordered_json::array();
    for (const auto& image : readout.legacy->contact) object["contact"].push_back(contact_json(image));
  }
  object["record"] = ordered_json::object();
  for (const auto& [key, value] : readout.record) object["record"][key] = value;
  return object;
}

std::string readout_to_json(const Readout& readout) { return json_text(readout_json(readout)); }

}  // namespace strobe::messages
