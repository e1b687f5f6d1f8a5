#include "common/messages/air_law_json.hpp"

#include <nlohmann/json.hpp>
#include <string>

namespace strobe::messages {

nlohmann::ordered_json air_law_json(const flight::AirLaw& law) {
  nlohmann::ordered_json object;
  for (const flight::AirLawField& field : flight::kAirLawFields)
    object[std::string(field.name)] = law.*field.member;
  return object;
}

Result<flight::AirLaw> air_law_from_json(const nlohmann::json& object) {
  if (!object.is_object()) return fail("air_law: must be an object");
  flight::AirLaw law;
  for (const flight::AirLawField& field : flight::kAirLawFields) {
    const auto value = object.find(field.name);
    if (value == object.end()) return fail("air_law." + std::string(field.name) + ": is missing");
    if (!value->is_number()) return fail("air_law." + std::string(field.name) + ": must be a number");
    law.*field.member = value->get<double>();
  }
  return law;
}

}  // namespace strobe::messages
