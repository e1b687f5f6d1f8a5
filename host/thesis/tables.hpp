// The tables: 2 to 17 as in the thesis, and those beyond it. Each is computed from the inputs by the
// analysis core. Pure; thread-safe; allocates.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host/thesis/table.hpp"
#include "host/thesis/thesis_inputs.hpp"

namespace strobe::thesis {

/// Tables 2–4, 5–7 and 8–10.
Table incoming_table(const ThesisInputs& inputs, int number, std::string_view spin);
Table rebound_table(const ThesisInputs& inputs, int number, std::string_view spin);
Table system_table(const ThesisInputs& inputs, int number, std::string_view spin);
/// Printed sds of the angles against those of the components and of the speed.
Table spread_table(const ThesisInputs& inputs);

/// The thesis's three sets, or the selected one; with `all`, every set shown.
std::vector<std::string> contact_sets(const ThesisInputs& inputs, bool all);

/// Tables 11–14, and the growth of errors for which the thesis left the differentiation approach.
Table cubic_table(const ThesisInputs& inputs);
Table derivative_table(const ThesisInputs& inputs);
Table end_velocity_table(const ThesisInputs& inputs);
Table zero_table(const ThesisInputs& inputs);
Table growth_table(const ThesisInputs& inputs);

/// Tables 15–17, and the same and more of all sets.
Table equation_table(const ThesisInputs& inputs);
Table peak_table(const ThesisInputs& inputs);
Table peaks_of_all_table(const ThesisInputs& inputs);
Table see_table(const ThesisInputs& inputs);
Table see_of_all_table(const ThesisInputs& inputs);
Table stiffness_table(const ThesisInputs& inputs);
Table depth_table(const ThesisInputs& inputs);

/// Leave-one-out cross-validation of the pulse, of cubics and of splines.
Table cross_validation_table(const ThesisInputs& inputs);

/// Rolling friction of each set.
Table rolling_table(const ThesisInputs& inputs);

/// Contact ODE: its fit, the skid-to-grip time, the energy.
Table mechanics_table(const ThesisInputs& inputs);
Table skid_table(const ThesisInputs& inputs);
Table energy_table(const ThesisInputs& inputs);

struct TableEntry {
  std::string id;
  std::string title;
  Table (*make)(const ThesisInputs&);
};

/// All tables, in the order in which they are printed.
const std::vector<TableEntry>& all_tables();

/// Returns nullptr if there is none of that id.
const TableEntry* find_table(std::string_view id);

}  // namespace strobe::thesis
