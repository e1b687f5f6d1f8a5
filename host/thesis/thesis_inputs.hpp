// The inputs of the thesis's tables and figures: its data as printed and as used, and the contact ODE fitted
// to it. Loading reads files; the rest is pure. Thread-safe; allocates.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/contact/differentiation.hpp"
#include "common/data/thesis_data.hpp"
#include "common/impact/fit/contact_fit.hpp"
#include "common/impact/ode/contact_trajectory.hpp"
#include "host/thesis/table.hpp"

namespace strobe::thesis {

struct ThesisInputs {
  thesis::Data printed;
  thesis::Data used;  ///< corrected, or as printed where corrections are off
  bool corrected = true;
  std::vector<thesis::PrintedValue> values;
  std::string only_set;                           ///< empty: all
  impact::ContactFitOptions mechanics_options;    ///< of the fit, and of the contacts shown
  std::vector<impact::Observation> observations;  ///< of all sets, not only those shown
  impact::ContactFit mechanics;                   ///< the contact ODE fitted to them

  /// Conditions to show, in printed order; `spin` empty: of every spin.
  std::vector<const thesis::Condition*> conditions(std::string_view spin = {}) const;
  bool shows(std::string_view set) const { return only_set.empty() || only_set == set; }
};

/// Fails if a file is missing or wrong, if there is no set of that name, or if the fit fails.
Result<ThesisInputs> load_inputs(const std::filesystem::path& folder, thesis::Version version,
                                 const std::string& only_set,
                                 const impact::ContactFitOptions& mechanics = {});

/// Spins in printed order, and the thesis's names for them.
inline constexpr std::string_view kSpins[] = {"zero", "top", "back"};
std::string_view spin_phrase(std::string_view spin);

/// The thesis's three sets at 23 degrees.
inline constexpr std::string_view kMainSets[] = {"zero_23", "top_23", "back_22"};

/// The contact of a condition by the fitted ODE. Returns nullopt if it cannot be integrated.
std::optional<impact::ContactTrajectory> simulate_contact(const ThesisInputs& inputs,
                                                          const thesis::Condition& condition);

/// The erratum of a printed value, from corrections.csv, under one of the names `tables`. Returns nullptr if
/// there is none.
const thesis::Correction* erratum(const ThesisInputs& inputs, std::string_view set, std::string_view field,
                                  std::initializer_list<std::string_view> tables);

/// Replaces the reason "unexplained" by the erratum's: misprint if it has the right value, else inconsistent.
void explain(Cell& cell, const thesis::Correction* erratum);

// Scales that turn a set's fractions into SI units. Pure; thread-safe.

/// Dwell time and distance are the condition's. The total rotation is not printed: it is computed by the
/// contact ODE, which was fitted to velocities and spins alone; where the images rotate the other way
/// (back_17, whose total is near zero), it is the one with which they fit the ODE best. The thesis's own
/// totals follow from the corrected entries of its Table 13 for two sets, -51.0 degrees (zero_23) and -9.7
/// (back_22); this gives -49.5 and -9.7.
contact::ContactScale contact_scale(const ThesisInputs& inputs, const thesis::Condition& condition);

}  // namespace strobe::thesis
