// What the tables and figures are made from: the thesis's data as printed and as used. Loading reads files;
// the rest is pure.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/data/printed_values.hpp"
#include "common/data/thesis_data.hpp"
#include "common/impact/fit/contact_fit.hpp"
#include "common/impact/ode/contact_trajectory.hpp"
#include "host/thesis/table.hpp"

namespace strobe::report {

struct Material {
  thesis::Data printed;
  thesis::Data used;  ///< corrected; the same as `printed` where corrections are off
  bool corrected = true;
  std::vector<thesis::PrintedValue> values;
  std::string only_set;                                  ///< empty: all
  std::vector<impact::ContactObservation> observations;  ///< of every set, whichever are shown
  impact::ContactFit mechanics;                          ///< the contact's mechanics fitted to them

  /// Conditions to show, in printed order; `spin` empty: of every spin.
  std::vector<const thesis::Condition*> conditions(std::string_view spin = {}) const;
  bool shows(std::string_view set) const { return only_set.empty() || only_set == set; }
};

/// Fails where a file is missing or wrong, where there is no set of that name, or where the fit does.
Result<Material> load_material(const std::filesystem::path& folder, thesis::Version version,
                               const std::string& only_set);

/// Spins in printed order, and what the thesis calls them.
inline constexpr std::string_view kSpins[] = {"zero", "top", "back"};
std::string_view spin_phrase(std::string_view spin);

/// The thesis's three sets at 23 degrees.
inline constexpr std::string_view kMainSets[] = {"zero_23", "top_23", "back_22"};

/// The contact of a condition by the fitted mechanics; nothing where it cannot be integrated.
std::optional<impact::ContactTrajectory> course_of(const Material& material,
                                                   const thesis::Condition& condition);

/// The erratum of a printed value, from corrections.csv: `tables` are the names to look under. Null if there
/// is none.
const thesis::Correction* erratum(const Material& material, std::string_view set, std::string_view field,
                                  std::initializer_list<std::string_view> tables);

/// Replaces "unexplained" by what the erratum says: misprint where it knows the right value, else
/// inconsistent.
void explain(Cell& cell, const thesis::Correction* erratum);

}  // namespace strobe::report
