// Tables 15 to 17: the integration approach (damped sine pulse); and what it says of all sets.
#include <fmt/format.h>
#include <cmath>

#include "common/contact/condition_inputs.hpp"
#include "common/contact/standard_error.hpp"
#include "common/contact/stiffness.hpp"
#include "common/units/angles.hpp"
#include "host/thesis/table.hpp"
#include "host/thesis/tables.hpp"
#include "host/thesis/thesis_inputs.hpp"

namespace strobe::thesis {

namespace {

using impact::PulseForm;
using thesis::Condition;

/// The thesis's numbers behind its equations where they are printed, else the means.
struct Equation {
  contact::ContactInputs inputs;
  const thesis::PrintedValue* e = nullptr;
  const thesis::PrintedValue* vy = nullptr;
  const thesis::PrintedValue* dwell = nullptr;
};

Equation equation_of(const ThesisInputs& m, const Condition& c, PulseForm form) {
  Equation out;
  out.e = thesis::find(m.values, "15", c.name(), "e");
  out.vy = thesis::find(m.values, "15", c.name(), "vy_td");
  out.dwell = thesis::find(m.values, "15", c.name(), "dwell_time");
  out.inputs = {.vx_td_mps = c.vx_td_mps.mean,
                .vy_td_mps = out.vy ? out.vy->value : c.vy_td_mps.mean,
                .e = out.e ? out.e->value : c.e.mean,
                .mu = c.mu.mean,
                .dwell_time_s = (out.dwell ? out.dwell->value : c.dwell_time_ms.mean) / 1e3,
                .dwell_distance_m = c.dwell_distance_cm.mean / 1e2,
                .form = form};
  return out;
}

Cell printed_or_not(const ThesisInputs& m, const thesis::PrintedValue* printed, double computed,
                    const Tolerance& tolerance, const char* field) {
  if (!printed) return computed_only(computed, {}, Reason::not_at_hand);
  Cell cell = compared({printed->value, printed->last_digit, {}}, computed, tolerance);
  explain(cell, erratum(m, printed->set, field, {fmt::format("table_{}", printed->table)}));
  return cell;
}

Cell damping_cell(PulseForm form, double e) {
  const auto f = impact::damping_from_restitution(form, e);
  return f ? computed_only(*f) : text_cell("-");
}

/// In the thesis's order: velocities, then top and distance, with theta = pi t/dwell.
std::string equations(const std::string& set, const contact::ContactInputs& in) {
  const auto f = impact::damping_from_restitution(PulseForm::simplified, in.e);
  const double speed = std::abs(in.vy_td_mps);
  const double length_mm = 1e3 * speed * in.dwell_time_s / kPi;
  return fmt::format(
      "{}, E = exp(-{:.4f} theta): vy = -{:.3f} E cos theta m/s, vx = {:.2f} + {:.3f} (E cos theta - 1) m/s, "
      "Y = {:.1f} - {:.2f} E sin theta mm, X = {:.2f} t + {:.2f} E sin theta mm (t in ms)",
      set, f.value_or(0.0), speed, in.vx_td_mps, in.mu * speed, 1e3 * in.diameter_m, length_mm,
      in.vx_td_mps - in.mu * speed, in.mu * length_mm);
}

struct See {
  double x_mm = 0.0;
  double y_mm = 0.0;
};

std::optional<See> see_of(const data::ContactSet& set, const contact::ContactInputs& in) {
  const auto errors = contact::pulse_standard_errors(set, in);
  if (!errors) return std::nullopt;
  return See{1e3 * errors->see_x_m, 1e3 * errors->see_y_m};
}

/// How far the rounding of the equation's inputs moves the errors of estimate.
See see_rounding(const data::ContactSet& set, const Equation& equation) {
  See sum;
  const auto base = see_of(set, equation.inputs);
  const auto add = [&](double contact::ContactInputs::*input, double half_digit) {
    double x = 0.0;
    double y = 0.0;
    for (const double sign : {-1.0, 1.0}) {
      contact::ContactInputs moved = equation.inputs;
      moved.*input += sign * half_digit;
      const auto see = see_of(set, moved);
      if (!see || !base) continue;
      x = std::max(x, std::abs(see->x_mm - base->x_mm));
      y = std::max(y, std::abs(see->y_mm - base->y_mm));
    }
    sum.x_mm += x;
    sum.y_mm += y;
  };
  const auto half = [](const thesis::PrintedValue* printed) {
    return printed ? printed->last_digit / 2.0 : kHalfDigit;
  };
  add(&contact::ContactInputs::vx_td_mps, kHalfDigit);
  add(&contact::ContactInputs::vy_td_mps, half(equation.vy));
  add(&contact::ContactInputs::e, half(equation.e));
  add(&contact::ContactInputs::mu, kHalfDigit);
  add(&contact::ContactInputs::dwell_time_s, half(equation.dwell) / 1e3);
  add(&contact::ContactInputs::dwell_distance_m, kHalfDigit / 1e2);
  return sum;
}

/// Of the fitted mechanics: X, Y, rotation and the R² of the latter.
std::vector<Cell> mechanics_errors(const ThesisInputs& m, const Condition& c, const data::ContactSet& set) {
  const auto ode = simulate_contact(m, c);
  if (!ode) return std::vector<Cell>(4, text_cell("-"));
  const auto errors = contact::standard_errors(set, contact::trajectory_of(*ode), contact::fraction_scale(c));
  if (!errors) return std::vector<Cell>(4, text_cell("-"));
  const auto& rotation = errors->rotation;
  return {computed_only(1e3 * errors->see_x_m), computed_only(1e3 * errors->see_y_m),
          rotation ? computed_only(degrees(rotation->own_total.see_rad)) : text_cell("-"),
          rotation ? computed_only(rotation->r_squared) : text_cell("-")};
}

Cell peak_cell(const ValueSd& value, double unit) {
  return computed_only(unit * value.value, unit * value.sd, Reason::not_at_hand);
}

Table peak_rows(const ThesisInputs& m, Table table, bool all) {
  table.columns = {{"force_n", "max Fy", "N", 0},
                   {"force_fraction", "at T", "", 3},
                   {"deformation_mm", "deformation", "mm", 2},
                   {"deformation_ms", "at", "ms", 2},
                   {"deformation_fraction", "at T", "", 3},
                   {"friction_n", "max Fx", "N", 0},
                   {"grip_fraction", "grip T", "", 3},
                   {"grip_ms", "skid to grip", "ms", 2}};
  for (const std::string& name : contact_sets(m, all)) {
    const Condition& c = *m.used.condition(name);
    const auto peaks =
        contact::peaks(contact::spin_pulse_input(c, PulseForm::exact), contact::spin_pulse_sd(c));
    if (!peaks) continue;
    Row row{name,
            {peak_cell(peaks->normal_force.size, 1.0), peak_cell(peaks->normal_force.fraction, 1.0),
             peak_cell(peaks->deformation.size, 1e3), peak_cell(peaks->deformation.time_s, 1e3),
             peak_cell(peaks->deformation.fraction, 1.0), peak_cell(peaks->friction_force.size, 1.0)}};
    row.cells.push_back(peaks->grip_fraction ? peak_cell(*peaks->grip_fraction, 1.0) : text_cell("slides"));
    row.cells.push_back(peaks->grip_time_s ? peak_cell(*peaks->grip_time_s, 1e3) : text_cell("slides"));
    for (Cell& cell : row.cells)
      if (all) cell.reason = Reason::none;
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace

Table equation_table(const ThesisInputs& m) {
  Table table{.id = "15", .title = "Integration: what the equations of the damped sine pulse are made of"};
  table.columns = {{"e", "e", "", 4},
                   {"vy_td_mps", "vy TD", "m/s", 3},
                   {"dwell_time_ms", "dwell", "ms", 4},
                   {"f_simplified", "f simplified", "", 5},
                   {"f_exact", "f exact", "", 5}};
  for (const std::string& name : contact_sets(m, false)) {
    const Condition& c = *m.used.condition(name);
    const Equation q = equation_of(m, c, PulseForm::simplified);
    const DerivedValue e = restitution(c);
    Row row{name, {}};
    row.cells.push_back(printed_or_not(m, q.e, e.value, e.tolerance, "e"));
    row.cells.push_back(printed_or_not(m, q.vy, c.vy_td_mps.mean, {kHalfDigit, 0.0}, "vy_td"));
    row.cells.push_back(printed_or_not(m, q.dwell, c.dwell_time_ms.mean, {kHalfDigit, 0.0}, "dwell_time"));
    row.cells.push_back(damping_cell(PulseForm::simplified, q.inputs.e));
    row.cells.push_back(damping_cell(PulseForm::exact, q.inputs.e));
    table.rows.push_back(std::move(row));
    table.notes.push_back("simplified, " + equations(name, q.inputs));
  }
  table.notes.push_back(
      "anew: e = -vy LO/vy TD, vy TD and dwell time of the means, which are rounded; f: simplified "
      "-ln(e)/pi, "
      "exact from e = (1 + exp(-f pi))/(1 + f^2) - 1");
  table.notes.push_back(
      "the thesis adds f inside the bracket of X and leaves -f out of Y: a position starts at zero");
  return table;
}

Table peak_table(const ThesisInputs& m) {
  Table table{.id = "16", .title = "Largest forces and deformation, times and fractions (exact pulse)"};
  table = peak_rows(m, std::move(table), false);
  table.notes = {
      "sd: of one shot, from the printed sds taken as independent; deformation: of the centre (the top goes "
      "down further: table \"depth\"); Fx: largest before the grip"};
  return table;
}

Table peaks_of_all_table(const ThesisInputs& m) {
  Table table{.id = "peaks", .title = "Table 16 for all sets"};
  return peak_rows(m, std::move(table), true);
}

Table see_table(const ThesisInputs& m) {
  Table table{.id = "17", .title = "Standard error of estimate of the pulse, simplified form"};
  table.columns = {{"see_x_mm", "X", "mm", 3}, {"see_y_mm", "Y", "mm", 3}};
  for (const std::string& name : contact_sets(m, false)) {
    const Equation q = equation_of(m, *m.used.condition(name), PulseForm::simplified);
    const data::ContactSet& set = m.printed.contact.at(name);
    const auto see = see_of(set, q.inputs);
    if (!see) continue;
    const See rounding = see_rounding(set, q);
    table.rows.push_back({name,
                          {printed_or_not(m, thesis::find(m.values, "17", name, "see_x"), see->x_mm,
                                          {rounding.x_mm, 0.0}, "see_x"),
                           printed_or_not(m, thesis::find(m.values, "17", name, "see_y"), see->y_mm,
                                          {rounding.y_mm, 0.0}, "see_y")}});
  }
  table.notes = {
      "anew: from the numbers behind Table 15's equations and the images as printed; the rounding allowed "
      "for "
      "is that of all of these numbers"};
  return table;
}

Table see_of_all_table(const ThesisInputs& m) {
  Table table{.id = "see",
              .title = "Standard error of estimate for all sets, by each form of the integration"};
  table.columns = {{"n", "n", "", 0},
                   {"simplified_x_mm", "simplified X", "mm", 2},
                   {"simplified_y_mm", "Y", "mm", 2},
                   {"exact_x_mm", "exact X", "mm", 2},
                   {"exact_y_mm", "Y", "mm", 2},
                   {"grip_x_mm", "with grip X", "mm", 2},
                   {"mechanics_x_mm", "mechanics X", "mm", 2},
                   {"mechanics_y_mm", "Y", "mm", 2},
                   {"rotation_deg", "rotation", "deg", 1},
                   {"rotation_r2", "R^2", "", 3}};
  for (const Condition* c : m.conditions()) {
    const data::ContactSet& set = m.used.contact.at(c->name());
    Row row{c->name(), {}};
    for (const PulseForm form : {PulseForm::simplified, PulseForm::exact}) {
      Equation q = equation_of(m, *c, form);
      const auto see = contact::pulse_standard_errors(set, q.inputs);
      if (form == PulseForm::simplified) row.cells.push_back(see ? computed_only(see->n) : text_cell("-"));
      row.cells.push_back(see ? computed_only(1e3 * see->see_x_m) : text_cell("-"));
      row.cells.push_back(see ? computed_only(1e3 * see->see_y_m) : text_cell("-"));
    }
    const auto pulse = contact::SpinPulse::make(contact::spin_pulse_input(*c, PulseForm::exact));
    std::optional<contact::StandardErrors> errors;
    if (pulse) {
      auto result =
          contact::standard_errors(set, contact::trajectory_of(*pulse), contact::fraction_scale(*c));
      if (result) errors = *result;
    }
    row.cells.push_back(errors ? computed_only(1e3 * errors->see_x_m) : text_cell("-"));
    for (Cell& cell : mechanics_errors(m, *c, set)) row.cells.push_back(std::move(cell));
    table.rows.push_back(std::move(row));
  }
  table.notes = {
      "simplified, exact: friction mu F_y throughout, as in the thesis; with grip: until the contact point "
      "stops, rolling from then on, which is what the thesis could not integrate",
      "mechanics: springs, friction and offset fitted to the velocities and spins of all sets, not to the "
      "images; "
      "rotation: its own against the images as fractions of its total, R^2 the share of it that they follow; "
      "with backspin the total is small, and so are the fractions' degrees"};
  return table;
}

// Beyond the thesis: how stiff the contact is by several readings, and how deep the ball's top goes.

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

}  // namespace strobe::thesis
