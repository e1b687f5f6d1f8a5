#include "host/thesis/tables/tables.hpp"

namespace strobe::report {

const std::vector<TableEntry>& all_tables() {
  static const std::vector<TableEntry> entries{
      {"2", "incoming, no spin", [](const ThesisInputs& m) { return incoming_table(m, 2, "zero"); }},
      {"3", "incoming, topspin", [](const ThesisInputs& m) { return incoming_table(m, 3, "top"); }},
      {"4", "incoming, backspin", [](const ThesisInputs& m) { return incoming_table(m, 4, "back"); }},
      {"5", "rebounding, no spin", [](const ThesisInputs& m) { return rebound_table(m, 5, "zero"); }},
      {"6", "rebounding, topspin", [](const ThesisInputs& m) { return rebound_table(m, 6, "top"); }},
      {"7", "rebounding, backspin", [](const ThesisInputs& m) { return rebound_table(m, 7, "back"); }},
      {"8", "system parameters, no spin", [](const ThesisInputs& m) { return system_table(m, 8, "zero"); }},
      {"9", "system parameters, topspin", [](const ThesisInputs& m) { return system_table(m, 9, "top"); }},
      {"10", "system parameters, backspin",
       [](const ThesisInputs& m) { return system_table(m, 10, "back"); }},
      {"11", "cubics through the images in contact", cubic_table},
      {"12", "derivatives of the cubics", derivative_table},
      {"13", "velocities at the ends by differentiation", end_velocity_table},
      {"14", "when skidding stops", zero_table},
      {"15", "equations of the integration", equation_table},
      {"16", "largest forces and deformation", peak_table},
      {"17", "standard error of estimate", see_table},
      {"spread", "spreads of the angles", spread_table},
      {"growth", "growth of errors by differentiation", growth_table},
      {"peaks", "Table 16 for all sets", peaks_of_all_table},
      {"see", "standard error of estimate of all sets", see_of_all_table},
      {"stiffness", "stiffness of the contact", stiffness_table},
      {"freund", "what Freund's stiffnesses may come from", freund_table},
      {"depth", "drop of the top over that of the centre", depth_table},
      {"cross_validation", "images predicted without them, by each approach", cross_validation_table},
      {"vx-models", "in/out models: speed at lift-off", vx_model_table},
      {"omega-models", "in/out models: spin at lift-off", omega_model_table},
      {"fits", "in/out models fitted", fit_table},
      {"regimes", "slides or grips", regime_table},
      {"rolling", "rolling friction", rolling_table},
      {"mechanics", "contact mechanics fitted", mechanics_table},
      {"skid", "when skidding stops, of all sets", skid_table},
      {"energy", "where the energy goes", energy_table},
  };
  return entries;
}

const TableEntry* find_table(std::string_view id) {
  for (const TableEntry& entry : all_tables())
    if (entry.id == id) return &entry;
  return nullptr;
}

}  // namespace strobe::report
