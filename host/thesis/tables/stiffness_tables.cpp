// Beyond the thesis: how stiff the contact is by several readings, what Freund's stiffnesses may have been
// computed from, and how deep the ball's top goes.
#include "common/contact/condition_inputs.hpp"
#include "host/thesis/tables/tables.hpp"

namespace strobe::report {

namespace {

using impact::PulseForm;
using thesis::Condition;

}  // namespace

Table stiffness_table(const ThesisInputs& m) {
  Table table{.id = "stiffness", .title = "Stiffness of the contact by several readings"};
  table.columns = {{"half_period_knpm", "m(pi/dwell)^2", "kN/m", 1},
                   {"secant_knpm", "Fmax/depth", "kN/m", 1},
                   {"energy_knpm", "energy", "kN/m", 1},
                   {"kelvin_voigt_knpm", "Kelvin-Voigt", "kN/m", 1},
                   {"zeta", "zeta", "", 3},
                   {"compression_knpm", "to deepest", "kN/m", 1},
                   {"peak_time_knpm", "to peak force", "kN/m", 1},
                   {"freund_knpm", "Freund", "kN/m", 1}};
  for (const Condition* c : m.conditions()) {
    const auto k = contact::stiffness(contact::spin_pulse_input(*c, PulseForm::exact));
    if (!k) continue;
    const auto cell = [](double value) { return computed_only(value / 1e3); };
    Row row{c->name(),
            {cell(k->half_period), cell(k->secant), cell(k->energy), cell(k->kelvin_voigt),
             computed_only(k->kelvin_voigt_zeta), cell(k->compression), cell(k->peak_time)}};
    const auto* freund = thesis::find(m.values, "freund", c->name(), "stiffness");
    row.cells.push_back(freund ? as_measured({freund->value, freund->last_digit, {}}) : Cell{});
    table.rows.push_back(std::move(row));
  }
  table.notes = {
      "the contact is no linear spring, so that its readings differ; Freund measured at 17 degrees; to "
      "deepest and to "
      "peak force: the time to it is a quarter of a period"};
  return table;
}

Table freund_table(const ThesisInputs& m) {
  Table table{.id = "freund", .title = "What Freund's stiffnesses may have been computed from"};
  std::vector<contact::PublishedStiffness> published;
  for (const thesis::PrintedValue& v : m.values) {
    if (v.table != "freund") continue;
    published.push_back(
        contact::published_stiffness(*m.used.condition(v.set), m.used.contact.at(v.set), 1e3 * v.value));
    table.columns.push_back({v.set + "_knpm", v.set, "kN/m", 1});
  }
  table.columns.push_back({"common_ratio", "Freund over it", "", 2});
  table.columns.push_back({"spread", "spread of that", "", 3});
  const auto guesses = contact::explain_stiffness(published);
  if (!guesses) return table;
  Row printed{"as printed", {}};
  for (const contact::PublishedStiffness& p : published)
    printed.cells.push_back(computed_only(p.stiffness / 1e3));
  printed.cells.resize(table.columns.size());
  table.rows.push_back(std::move(printed));
  for (const contact::StiffnessHypothesis& guess : *guesses) {
    Row row{std::string(guess.name), {}};
    for (const double k : guess.predicted) row.cells.push_back(computed_only(k / 1e3));
    row.cells.push_back(computed_only(guess.common_ratio));
    row.cells.push_back(computed_only(guess.spread));
    table.rows.push_back(std::move(row));
  }
  table.notes = {
      "a guess explains the numbers where Freund over it is 1, and is proportional to them where the spread "
      "(sd of the logarithms of the ratios) is no more than rounding's"};
  return table;
}

Table depth_table(const ThesisInputs& m) {
  Table table{.id = "depth", .title = "Measured drop of the ball's top over the pulse's drop of its centre"};
  table.columns = {{"ratio", "ratio", "", 2},
                   {"sd_inputs", "sd by inputs", "", 2},
                   {"depth_mm", "depth of the top", "mm", 2},
                   {"see_mm", "about it", "mm", 2},
                   {"n", "n", "", 0}};
  for (const Condition* c : m.conditions()) {
    const auto drop =
        contact::drop_ratio(m.used.contact.at(c->name()), contact::spin_pulse_input(*c, PulseForm::exact),
                            contact::spin_pulse_sd(*c));
    if (!drop) continue;
    table.rows.push_back(
        {c->name(),
         {computed_only(drop->ratio, drop->sd_images), computed_only(drop->sd_inputs),
          computed_only(1e3 * drop->depth_m), computed_only(1e3 * drop->see_m), computed_only(drop->n)}});
  }
  table.notes = {
      "least squares over the images between touchdown and lift-off; 1 where the top goes down as the centre "
      "of the pulse does"};
  return table;
}

}  // namespace strobe::report
