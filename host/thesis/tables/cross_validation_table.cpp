// Beyond the thesis: leave-one-out cross-validation of the approaches to the contact.
#include <cmath>
#include <initializer_list>

#include "common/contact/condition_inputs.hpp"
#include "common/contact/cross_validation.hpp"
#include "common/units/angles.hpp"
#include "host/thesis/contact_scale.hpp"
#include "host/thesis/tables/tables.hpp"

namespace strobe::report {

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

}  // namespace strobe::report
