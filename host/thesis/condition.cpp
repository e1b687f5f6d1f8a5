#include "host/thesis/condition.hpp"

#include <cmath>

#include "common/config/files.hpp"

namespace strobe::host {

std::optional<thesis::Condition> thesis_condition(const std::string& spin, double angle_deg) {
  const auto share = config::share_folder();
  if (spin.empty() || !share) return std::nullopt;
  const auto text = config::read_file((*share / "thesis" / "tables_02_to_10.csv").string());
  if (!text) return std::nullopt;
  const auto conditions = thesis::parse_conditions(*text, "tables_02_to_10.csv");
  if (!conditions) return std::nullopt;
  for (const thesis::Condition& condition : *conditions) {
    if (condition.spin == spin && condition.angle_label_deg == std::abs(angle_deg)) return condition;
  }
  return std::nullopt;
}

}  // namespace strobe::host
