// Tables 11 to 14: the differentiation approach, computed from the images as printed; and how its errors
// grow.
#include <fmt/format.h>
#include <cmath>
#include <initializer_list>

#include "common/contact/condition_inputs.hpp"
#include "common/contact/differentiation.hpp"
#include "common/contact/standard_error.hpp"
#include "common/units/angles.hpp"
#include "host/thesis/tables.hpp"
#include "host/thesis/thesis_inputs.hpp"

namespace strobe::thesis {

namespace {

using contact::CubicFit;
using contact::FractionFits;

/// One set's images, as printed or as corrected.
struct Images {
  std::string label;
  std::string set;
  const thesis::Condition* condition;
  FractionFits fits;
  contact::ContactScale scale;
};

/// The thesis fitted the rows as it printed them; where a correction changes them, they are fitted again.
std::vector<Images> images_of(const ThesisInputs& m, bool all) {
  std::vector<Images> out;
  const auto add = [&](const std::string& name, const thesis::Data& data, const std::string& label) {
    const data::ContactSet& set = data.contact.at(name);
    const thesis::Condition& c = *m.used.condition(name);
    out.push_back({label, name, &c, contact::fit_fractions(set), contact_scale(m, c)});
  };
  for (const std::string& name : contact_sets(m, all)) {
    const bool changed = m.printed.contact.at(name).rows != m.used.contact.at(name).rows;
    if (!all) add(name, m.printed, name);
    if (all || changed) add(name, m.used, all ? name : name + " corrected");
  }
  return out;
}

/// A coefficient whose printed value is not available, with its misprint if that is known.
Cell coefficient_cell(const ThesisInputs& m, const Images& images, const std::string& table,
                      const std::string& field, std::optional<double> value, std::optional<double> se) {
  Cell cell = computed_only(value, se, Reason::not_at_hand);
  if (images.label != images.set) {
    cell.reason = Reason::none;
    return cell;
  }
  if (const auto* e = erratum(m, images.set, field, {table})) {
    cell.reason = Reason::misprint;
    cell.remark = fmt::format("printed otherwise, should be {}: {}", e->corrected, e->reason);
  }
  return cell;
}

Row cubic_row(const ThesisInputs& m, const Images& images, const char* curve,
              const std::optional<CubicFit>& fit) {
  Row row{fmt::format("{} {}", images.label, curve), {}};
  for (std::size_t i = 0; i < 4; ++i) {
    if (!fit) {
      row.cells.push_back(text_cell("-"));
      continue;
    }
    const auto se = fit->standard_errors ? std::optional((*fit->standard_errors)[i]) : std::nullopt;
    row.cells.push_back(
        coefficient_cell(m, images, "table_11", fmt::format("{}_c{}", curve, i), fit->coefficients[i], se));
  }
  row.cells.push_back(coefficient_cell(m, images, "table_11", fmt::format("{}_r2", curve),
                                       fit ? fit->r_squared : std::nullopt, std::nullopt));
  row.cells.push_back(computed_only(fit ? std::optional<double>(fit->n) : std::nullopt));
  return row;
}

template <std::size_t N>
Row polynomial_row(const ThesisInputs& m, const Images& images, const char* quantity,
                   const std::optional<std::array<double, N>>& polynomial) {
  Row row{fmt::format("{} {}", images.label, quantity), {}};
  for (std::size_t i = 0; i < 3; ++i) {
    if (i >= N || !polynomial) {
      row.cells.push_back(Cell{});
      continue;
    }
    row.cells.push_back(coefficient_cell(m, images, "table_12", fmt::format("{}_c{}", quantity, i),
                                         (*polynomial)[i], std::nullopt));
  }
  return row;
}

/// The mean of Tables 2 to 7 beside the slope of the fit.
Cell slope_cell(const ThesisInputs& m, const Images& images, const char* field, const thesis::MeanSd& mean,
                const std::optional<ValueSd>& slope) {
  Cell cell = as_measured({mean.mean, 0.0, mean.sd});
  if (!slope) return cell;
  cell.computed = slope->value;
  cell.computed_sd = slope->sd;
  cell.reason = Reason::model;
  if (const auto* e = erratum(m, images.set, field, {"table_13"}); e && images.label == images.set)
    cell.remark = fmt::format("misprinted in Table 13, should be {}: {}", e->corrected, e->reason);
  return cell;
}

std::string joined(const std::vector<double>& values) {
  std::string text;
  for (const double v : values) text += fmt::format("{}{:.3f}", text.empty() ? "" : ", ", v);
  return text.empty() ? "never" : text;
}

}  // namespace

std::vector<std::string> contact_sets(const ThesisInputs& m, bool all) {
  std::vector<std::string> names;
  if (!all && m.only_set.empty()) return {std::begin(kMainSets), std::end(kMainSets)};
  for (const thesis::Condition* c : m.conditions()) names.push_back(c->name());
  return names;
}

Table cubic_table(const ThesisInputs& m) {
  Table table{.id = "11", .title = "Cubics of the fractions on the time fraction T, ± standard error"};
  table.columns = {{"c0", "1", "", 4},   {"c1", "T", "", 4},   {"c2", "T^2", "", 4},
                   {"c3", "T^3", "", 4}, {"r2", "R^2", "", 4}, {"n", "rows", "", 0}};
  for (const Images& images : images_of(m, false)) {
    table.rows.push_back(cubic_row(m, images, "x", images.fits.x));
    table.rows.push_back(cubic_row(m, images, "y", images.fits.y));
    table.rows.push_back(cubic_row(m, images, "rotation", images.fits.rotation));
  }
  table.notes = {
      "least squares over all rows as printed, the end points included; \"corrected\": without what the "
      "corrections leave out",
      "the thesis's digits are not at hand; its entries are known to come out to the last digit but for the "
      "misprints above"};
  return table;
}

Table derivative_table(const ThesisInputs& m) {
  Table table{.id = "12", .title = "Derivatives of the cubics, per unit of fraction and of time fraction"};
  table.columns = {{"c0", "1", "", 4}, {"c1", "T", "", 4}, {"c2", "T^2", "", 4}};
  for (const Images& images : images_of(m, false)) {
    const contact::DerivedPolynomials p = contact::fraction_polynomials(images.fits);
    table.rows.push_back(polynomial_row(m, images, "vx", p.vx_mps));
    table.rows.push_back(polynomial_row(m, images, "vy", p.vy_mps));
    table.rows.push_back(polynomial_row(m, images, "omega", p.omega_radps));
    table.rows.push_back(polynomial_row(m, images, "fx", p.fx_n));
    table.rows.push_back(polynomial_row(m, images, "fy", p.fy_n));
    table.rows.push_back(polynomial_row(m, images, "torque", p.torque_nm));
  }
  table.notes = {
      "velocities are the cubics' first derivatives, forces and torque (as accelerations) the second; times "
      "distance, diameter or rotation over dwell time, once or squared, they are in real units"};
  return table;
}

Table end_velocity_table(const ThesisInputs& m) {
  Table table{.id = "13",
              .title = "Velocities at touchdown and lift-off: measured, and as the cubics' slopes"};
  table.columns = {{"vx_td_mps", "vx TD", "m/s", 2},           {"vx_lo_mps", "vx LO", "m/s", 2},
                   {"vy_td_mps", "vy TD", "m/s", 2},           {"vy_lo_mps", "vy LO", "m/s", 2},
                   {"omega_td_radps", "omega TD", "rad/s", 1}, {"omega_lo_radps", "omega LO", "rad/s", 1}};
  for (const Images& images : images_of(m, false)) {
    const contact::DerivedState td = contact::derive(images.fits, images.scale, 0.0);
    const contact::DerivedState lo = contact::derive(images.fits, images.scale, 1.0);
    const thesis::Condition& c = *images.condition;
    table.rows.push_back({images.label,
                          {slope_cell(m, images, "vx_td_mps", c.vx_td_mps, td.vx_mps),
                           slope_cell(m, images, "vx_lo_mps", c.vx_lo_mps, lo.vx_mps),
                           slope_cell(m, images, "vy", c.vy_td_mps, td.vy_mps),
                           slope_cell(m, images, "vy", c.vy_lo_mps, lo.vy_mps),
                           slope_cell(m, images, "omega_td_radps", c.omega_td_radps, td.omega_radps),
                           slope_cell(m, images, "omega_lo_radps", c.omega_lo_radps, lo.omega_radps)}});
  }
  table.notes = {
      "printed: the means of Tables 2 to 7, which the slopes should meet; anew: slopes with the sd of the "
      "fit "
      "alone",
      "spin: the fractions are of a total rotation that is not printed; it is taken as the one that the "
      "contact "
      "mechanics gives. Table 13's own can be told from its corrected entries: -51.0 degrees (zero_23), -9.7 "
      "(back_22)"};
  if (const auto* e = erratum(m, "all", "vy", {"table_13"}))
    table.notes.push_back("Table 13 prints half of every vy: " + e->reason);
  return table;
}

Table zero_table(const ThesisInputs& m) {
  Table table{.id = "14", .title = "When skidding stops, as a fraction of the dwell time"};
  table.columns = {{"rotation_zero", "rotation = 0", "", 3},
                   {"omega_zero", "omega = 0", "", 3},
                   {"slip_zero", "slip = 0", "", 3},
                   {"pulse_grip", "slip = 0 by pulse", "", 3}};
  for (const Images& images : images_of(m, false)) {
    const contact::ZeroCrossings zeros = contact::zero_crossings(images.fits, images.scale);
    const auto peaks = contact::peaks(contact::spin_pulse_input(*images.condition, impact::PulseForm::exact),
                                      contact::spin_pulse_sd(*images.condition));
    Row row{images.label,
            {text_cell(joined(zeros.rotation)), text_cell(joined(zeros.omega)), text_cell(joined(zeros.slip)),
             text_cell("never")}};
    if (peaks && peaks->grip_fraction)
      row.cells[3] = computed_only(peaks->grip_fraction->value, peaks->grip_fraction->sd);
    table.rows.push_back(std::move(row));
  }
  table.notes = {"Table 14's digits are not at hand",
                 "slip by differentiation is the difference of two slopes of nearly the same size: where it "
                 "passes zero late or never, the errors of Table 13 are why"};
  if (const auto* e = erratum(m, "all", "time_fraction", {"table_14"}))
    table.notes.push_back("Table 14 " + e->reason);
  return table;
}

Table growth_table(const ThesisInputs& m) {
  Table table{.id = "growth",
              .title = "How errors grow from position to velocity to force (differentiation)"};
  table.columns = {{"condition_number", "condition", "", 1},
                   {"x_position", "x", "%", 1},
                   {"x_velocity", "vx", "%", 1},
                   {"x_force", "Fx", "%", 1},
                   {"y_position", "y", "%", 1},
                   {"y_velocity", "vy", "%", 1},
                   {"y_force", "Fy", "%", 1},
                   {"y_force_at_ends", "Fy at ends", "%", 1},
                   {"rotation_velocity", "omega", "%", 1},
                   {"rotation_force", "torque", "%", 1}};
  const auto percent = [](const std::optional<contact::ErrorGrowth>& growth,
                          double contact::ErrorGrowth::*of) {
    return growth ? computed_only(1e2 * (*growth).*of) : text_cell("-");
  };
  const auto growth_of = [](const std::optional<CubicFit>& fit) {
    return fit ? contact::error_growth(*fit) : std::nullopt;
  };
  using contact::ErrorGrowth;
  for (const Images& images : images_of(m, true)) {
    const auto x = growth_of(images.fits.x);
    const auto y = growth_of(images.fits.y);
    const auto r = growth_of(images.fits.rotation);
    const double condition = images.fits.x ? images.fits.x->condition.monomial : 0.0;
    table.rows.push_back({images.label,
                          {computed_only(condition), percent(x, &ErrorGrowth::position),
                           percent(x, &ErrorGrowth::velocity), percent(x, &ErrorGrowth::force),
                           percent(y, &ErrorGrowth::position), percent(y, &ErrorGrowth::velocity),
                           percent(y, &ErrorGrowth::force), percent(y, &ErrorGrowth::force_at_ends),
                           percent(r, &ErrorGrowth::velocity), percent(r, &ErrorGrowth::force)}});
  }
  table.notes = {
      "sd of the fitted curve and of its derivatives, root mean square over the contact, over that of the "
      "quantity itself; condition: of the normal design matrix 1, T, T^2, T^3",
      "this is why the thesis left the approach: each derivative loses about a digit, and a cubic's force, a "
      "straight line, cannot start and end at zero however good the images are"};
  return table;
}

// Beyond the thesis: leave-one-out cross-validation of the approaches to the contact.

namespace {

Cell error_cell(const std::optional<double>& error, double unit) {
  return error ? computed_only(unit * *error) : text_cell("-");
}

/// The pulse beside the approaches fitted to the other images; nothing where it cannot be computed.
std::optional<contact::CrossValidation> cross_validation(const ThesisInputs& m, const thesis::Condition& c) {
  const auto pulse = contact::SpinPulse::make(contact::spin_pulse_input(c, impact::PulseForm::exact));
  if (!pulse) return std::nullopt;
  const auto errors = contact::leave_one_out(m.used.contact.at(c.name()), contact_scale(m, c),
                                             contact::end_velocities(c), contact::trajectory_of(*pulse));
  if (!errors) return std::nullopt;
  return *errors;
}

Row row_of(const std::string& set, const contact::CrossValidation& errors) {
  Row row{set, {computed_only(errors.n)}};
  const auto add = [&row](const contact::LeaveOneOutRms& of, double unit) {
    for (const auto& error : {of.pulse, of.cubic, of.spline}) row.cells.push_back(error_cell(error, unit));
  };
  add(errors.x_m, 1e3);
  add(errors.y_m, 1e3);
  add(errors.rotation_rad, degrees(1.0));
  return row;
}

/// Root mean square over the rows, each set counting alike; the count of images is their sum.
Row overall(const Table& table) {
  Row row{"all sets", {}};
  for (std::size_t column = 0; column < table.columns.size(); ++column) {
    double sum = 0.0;
    double squares = 0.0;
    int n = 0;
    for (const Row& set : table.rows) {
      const auto value = set.cells[column].computed;
      if (!value) continue;
      sum += *value;
      squares += *value * *value;
      ++n;
    }
    const bool count = column == 0;
    row.cells.push_back(n == 0 ? text_cell("-") : computed_only(count ? sum : std::sqrt(squares / n)));
  }
  return row;
}

}  // namespace

Table cross_validation_table(const ThesisInputs& m) {
  Table table{.id = "cross_validation",
              .title = "Error of an image in contact that the approach was not shown"};
  table.columns = {{"n", "images", "", 0},
                   {"x_pulse_mm", "x by pulse", "mm", 2},
                   {"x_cubic_mm", "cubic", "mm", 2},
                   {"x_spline_mm", "spline", "mm", 2},
                   {"y_pulse_mm", "y by pulse", "mm", 2},
                   {"y_cubic_mm", "cubic", "mm", 2},
                   {"y_spline_mm", "spline", "mm", 2},
                   {"rotation_pulse_deg", "rotation by pulse", "deg", 2},
                   {"rotation_cubic_deg", "cubic", "deg", 2},
                   {"rotation_spline_deg", "spline", "deg", 2}};
  for (const thesis::Condition* c : m.conditions())
    if (const auto errors = cross_validation(m, *c)) table.rows.push_back(row_of(c->name(), *errors));
  if (table.rows.size() > 1) table.rows.push_back(overall(table));
  table.notes = {
      "root mean square over the images between touchdown and lift-off: the smaller, the better the approach "
      "predicts an image it has not seen; all sets: root mean square of the rows above",
      "cubic and spline are fitted anew without each image in turn, the spline held to the velocities and "
      "spins of the flight and to no force at both ends; the pulse (exact, with grip) never sees an image, "
      "only touchdown, e, mu and dwell time",
      "y is the top of the ball, the pulse's the centre; rotation: the fractions times the total that the "
      "mechanics gives"};
  return table;
}

}  // namespace strobe::thesis
