// The tables: 2 to 17 as in the thesis, and those beyond it. Each is computed from the material by the
// analysis core. Pure; thread-safe; allocates.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host/thesis/table.hpp"
#include "host/thesis/thesis_inputs.hpp"

namespace strobe::report {

/// Tables 2–4, 5–7 and 8–10.
Table incoming_table(const Material& material, int number, std::string_view spin);
Table rebound_table(const Material& material, int number, std::string_view spin);
Table system_table(const Material& material, int number, std::string_view spin);
/// Printed sds of the angles against those of the components and of the speed.
Table spread_table(const Material& material);

/// The thesis's three sets, or the one asked for; with `all`, every set that is shown.
std::vector<std::string> contact_sets(const Material& material, bool all);

/// Tables 11–14, and the growth of errors that made the thesis leave the differentiation approach.
Table cubic_table(const Material& material);
Table derivative_table(const Material& material);
Table end_velocity_table(const Material& material);
Table zero_table(const Material& material);
Table growth_table(const Material& material);

/// Tables 15–17, and the same and more of all sets.
Table equation_table(const Material& material);
Table peak_table(const Material& material);
Table peaks_of_all_table(const Material& material);
Table see_table(const Material& material);
Table see_of_all_table(const Material& material);
Table stiffness_table(const Material& material);
Table freund_table(const Material& material);
Table depth_table(const Material& material);

/// Each image in contact foretold without it: by the pulse, by cubics and by splines.
Table foretell_table(const Material& material);

/// In/out models: speed and spin at lift-off against all sets, their fits, regimes, rolling friction.
Table vx_model_table(const Material& material);
Table omega_model_table(const Material& material);
Table fit_table(const Material& material);
Table regime_table(const Material& material);
Table rolling_table(const Material& material);

/// Contact mechanics: its fit, the skid-to-grip time, the energy.
Table mechanics_table(const Material& material);
Table skid_table(const Material& material);
Table energy_table(const Material& material);

struct TableEntry {
  std::string id;
  std::string title;
  Table (*make)(const Material&);
};

/// In the order in which they are printed.
const std::vector<TableEntry>& catalogue();

/// Null if there is none of that id.
const TableEntry* find_table(std::string_view id);

}  // namespace strobe::report
