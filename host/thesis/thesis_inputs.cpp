#include "host/thesis/thesis_inputs.hpp"

#include <algorithm>

#include "common/contact/condition_inputs.hpp"

namespace strobe::thesis {

std::vector<const thesis::Condition*> ThesisInputs::conditions(std::string_view spin) const {
  std::vector<const thesis::Condition*> out;
  for (const thesis::Condition& c : used.conditions)
    if ((spin.empty() || c.spin == spin) && shows(c.name())) out.push_back(&c);
  return out;
}

Result<ThesisInputs> load_inputs(const std::filesystem::path& folder, thesis::Version version,
                                 const std::string& only_set, const impact::ContactFitOptions& mechanics) {
  auto printed = thesis::load(folder, thesis::Version::as_printed);
  if (!printed) return tl::unexpected(printed.error());
  auto used = version == thesis::Version::as_printed ? printed : thesis::load(folder, version);
  if (!used) return tl::unexpected(used.error());
  auto values = thesis::load_printed_values(folder);
  if (!values) return tl::unexpected(values.error());
  if (!only_set.empty() && !printed->condition(only_set))
    return fail("no set " + only_set + "; the thesis has zero_17 to back_68");
  ThesisInputs inputs{.printed = *std::move(printed),
                      .used = *std::move(used),
                      .corrected = version == thesis::Version::corrected,
                      .values = *std::move(values),
                      .only_set = only_set,
                      .mechanics_options = mechanics,
                      .observations = {},
                      .mechanics = {}};
  for (const thesis::Condition& c : inputs.used.conditions)
    inputs.observations.push_back(impact::observation_of(c));
  auto fit = impact::fit_contact(inputs.observations, mechanics);
  if (!fit) return fail("contact mechanics: " + fit.error().message);
  inputs.mechanics = *std::move(fit);
  return inputs;
}

std::string_view spin_phrase(std::string_view spin) {
  if (spin == "top") return "topspin";
  return spin == "back" ? "backspin" : "no spin";
}

std::optional<impact::ContactTrajectory> simulate_contact(const ThesisInputs& inputs,
                                                          const thesis::Condition& c) {
  const impact::ContactVector& fitted = inputs.mechanics.value;
  auto course = impact::ContactTrajectory::make(
      impact::ball_of(fitted), {c.vx_td_mps.mean, c.vy_td_mps.mean, c.omega_td_radps.mean},
      impact::coefficients_of(impact::observation_of(c), fitted, inputs.mechanics_options),
      inputs.mechanics_options.contact());
  if (!course) return std::nullopt;
  return *std::move(course);
}

const thesis::Correction* erratum(const ThesisInputs& inputs, std::string_view set, std::string_view field,
                                  std::initializer_list<std::string_view> tables) {
  for (const thesis::Correction& c : inputs.printed.corrections)
    if (c.set == set && c.field == field && std::find(tables.begin(), tables.end(), c.table) != tables.end())
      return &c;
  return nullptr;
}

void explain(Cell& cell, const thesis::Correction* erratum) {
  if (!erratum || cell.reason != Reason::unexplained) return;
  cell.reason = erratum->corrected == "none" ? Reason::inconsistent : Reason::misprint;
  cell.remark = erratum->reason;
}

namespace {

double total_rotation_rad(const ThesisInputs& inputs, const thesis::Condition& condition) {
  const auto ode = simulate_contact(inputs, condition);
  if (!ode) return 0.0;
  const double own_rad = ode->summary().rotation_rad;
  const data::ContactSet& set = inputs.used.contact.at(condition.name());
  const auto errors =
      contact::standard_errors(set, contact::trajectory_of(*ode), contact::fraction_scale(condition));
  if (!errors || !errors->rotation) return own_rad;
  const double fitted_rad = errors->rotation->fitted_total.total_rad;
  return own_rad * fitted_rad > 0.0 ? own_rad : fitted_rad;
}

}  // namespace

contact::ContactScale contact_scale(const ThesisInputs& inputs, const thesis::Condition& condition) {
  return {.dwell_time_s = condition.dwell_time_ms.mean / 1e3,
          .dwell_distance_m = condition.dwell_distance_cm.mean / 1e2,
          .total_rotation_rad = total_rotation_rad(inputs, condition)};
}

}  // namespace strobe::thesis
