#include "host/thesis/tables.hpp"

#include <fmt/format.h>

#include "common/impact/closed_form/sine_pulse.hpp"
#include "host/thesis/table.hpp"

namespace strobe::thesis {

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
      {"depth", "drop of the top over that of the centre", depth_table},
      {"cross_validation", "images predicted without them, by each approach", cross_validation_table},
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

// Tables 2 to 10: means of the 21 conditions, and what follows from them.

namespace {

using thesis::Condition;
using thesis::MeanSd;

constexpr double kLastDigit = 0.01;

/// One quantity of tables_02_to_10.csv, and how it follows from the others, if it does.
struct Quantity {
  const char* field;
  const char* head;
  const char* unit;
  MeanSd Condition::*member;
  DerivedValue (*derive)(const Condition&);
};

DerivedValue theta_in(const Condition& c) { return angle_deg(c.vx_td_mps, c.vy_td_mps); }
DerivedValue theta_out(const Condition& c) { return angle_deg(c.vx_lo_mps, c.vy_lo_mps); }
DerivedValue v_td(const Condition& c) { return speed(c.vx_td_mps, c.vy_td_mps); }
DerivedValue v_lo(const Condition& c) { return speed(c.vx_lo_mps, c.vy_lo_mps); }

constexpr Quantity kIncoming[] = {
    {"theta_in_deg", "theta in", "deg", &Condition::theta_in_deg, theta_in},
    {"vx_td_mps", "vx TD", "m/s", &Condition::vx_td_mps, nullptr},
    {"vy_td_mps", "vy TD", "m/s", &Condition::vy_td_mps, nullptr},
    {"v_td_mps", "v TD", "m/s", &Condition::v_td_mps, v_td},
    {"omega_td_radps", "omega TD", "rad/s", &Condition::omega_td_radps, nullptr},
};

constexpr Quantity kRebound[] = {
    {"theta_out_deg", "theta out", "deg", &Condition::theta_out_deg, theta_out},
    {"vx_lo_mps", "vx LO", "m/s", &Condition::vx_lo_mps, nullptr},
    {"vy_lo_mps", "vy LO", "m/s", &Condition::vy_lo_mps, nullptr},
    {"v_lo_mps", "v LO", "m/s", &Condition::v_lo_mps, v_lo},
    {"omega_lo_radps", "omega LO", "rad/s", &Condition::omega_lo_radps, nullptr},
};

constexpr Quantity kSystem[] = {
    {"e", "e", "", &Condition::e, restitution},
    {"mu", "mu", "", &Condition::mu, impulse_ratio},
    {"dwell_distance_cm", "distance", "cm", &Condition::dwell_distance_cm, nullptr},
    {"dwell_time_ms", "time", "ms", &Condition::dwell_time_ms, nullptr},
};

Printed printed_of(const Condition& c, const Quantity& q) {
  return {(c.*q.member).mean, kLastDigit, (c.*q.member).sd};
}

/// A mean without anything to compute it from: as it stands, or as corrected.
Cell mean_cell(const ThesisInputs& m, const Condition& printed, const Condition& used, const Quantity& q,
               const thesis::Correction* erratum) {
  Cell cell = as_measured(printed_of(printed, q));
  const MeanSd& value = used.*q.member;
  if (m.corrected && value.mean != *cell.printed) {
    cell.computed = value.mean;
    cell.reason = Reason::unexplained;
    explain(cell, erratum);
  }
  const std::string sd_field = std::string(q.field).insert(std::string(q.field).rfind('_'), "_sd");
  if (const auto* sd = thesis::erratum(m, printed.name(), sd_field, {"tables_02_to_10"}))
    cell.remark = fmt::format("sd {} should be {}: {}", sd->printed, sd->corrected, sd->reason);
  return cell;
}

Cell cell_of(const ThesisInputs& m, const Condition& used, const Quantity& q, const std::string& own_table) {
  const Condition& printed = *m.printed.condition(used.name());
  const auto* reason = erratum(m, used.name(), q.field, {"tables_02_to_10", own_table});
  if (!q.derive) return mean_cell(m, printed, used, q, reason);
  const DerivedValue derived = q.derive(used);
  Cell cell = compared(printed_of(printed, q), derived.value, derived.tolerance);
  explain(cell, reason);
  return cell;
}

template <std::size_t N>
Table mean_table(const ThesisInputs& m, int number, std::string_view spin, std::string title,
                 const Quantity (&quantities)[N], int Condition::*count) {
  Table table{.id = std::to_string(number), .title = std::move(title)};
  table.columns.push_back({"n", "n", "", 0});
  for (const Quantity& q : quantities) table.columns.push_back({q.field, q.head, q.unit, 2});
  const std::string own_table = fmt::format("table_{:02}", number);
  for (const Condition* c : m.conditions(spin)) {
    Row row{c->name(), {as_measured({static_cast<double>(c->*count), 1.0, {}})}};
    for (const Quantity& q : quantities) row.cells.push_back(cell_of(m, *c, q, own_table));
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// The thesis repeats the angle of incidence with the system's parameters.
Cell repeated_angle(const ThesisInputs& m, const Condition& c, const std::string& number) {
  const auto* printed = thesis::find(m.values, number, c.name(), "theta_in");
  if (!printed) {
    Cell cell = computed_only(c.theta_in_deg.mean, {}, Reason::not_at_hand);
    return cell;
  }
  Cell cell = compared({printed->value, printed->last_digit, {}}, c.theta_in_deg.mean);
  explain(cell, erratum(m, c.name(), "theta_in_deg", {fmt::format("table_{:0>2}", number)}));
  return cell;
}

/// Distance that a friction of mu times the pulse's normal force gives.
Cell pulse_distance(const Condition& c, impact::PulseForm form) {
  const auto pulse = impact::SinePulse::make(form, {.vx_td_mps = c.vx_td_mps.mean,
                                                    .vy_td_mps = c.vy_td_mps.mean,
                                                    .e = c.e.mean,
                                                    .impulse_ratio = c.mu.mean,
                                                    .dwell_s = c.dwell_time_ms.mean / 1e3});
  return computed_only(pulse ? std::optional(1e2 * pulse->at_fraction(1.0).x_m) : std::nullopt);
}

}  // namespace

Table incoming_table(const ThesisInputs& m, int number, std::string_view spin) {
  Table table = mean_table(m, number, spin, fmt::format("Incoming ball, {}: mean ± sd", spin_phrase(spin)),
                           kIncoming, &Condition::n_incoming);
  table.notes.push_back(
      "anew: theta in = atan2(vy, vx) and v = hypot(vx, vy) of the means; velocities and spin are means of "
      "replicates that are not at hand");
  return table;
}

Table rebound_table(const ThesisInputs& m, int number, std::string_view spin) {
  Table table = mean_table(m, number, spin, fmt::format("Rebounding ball, {}: mean ± sd", spin_phrase(spin)),
                           kRebound, &Condition::n_rebound);
  table.columns.push_back({"slip_lo_mps", "slip LO", "m/s", 2});
  for (Row& row : table.rows) {
    const Condition& c = *m.used.condition(row.label);
    const double radius_m = ball::kThesisDiameter_m / 2.0;
    // Replicates' spreads, taken as independent: their correlation is not printed.
    row.cells.push_back(computed_only(c.vx_lo_mps.mean + radius_m * c.omega_lo_radps.mean,
                                      std::hypot(c.vx_lo_mps.sd, radius_m * c.omega_lo_radps.sd)));
  }
  table.notes.push_back(
      "slip LO (beyond the thesis): vx + R omega at lift-off, 0 for a rolling ball; its sd takes the printed "
      "sds as independent");
  return table;
}

Table system_table(const ThesisInputs& m, int number, std::string_view spin) {
  Table table =
      mean_table(m, number, spin, fmt::format("System parameters, {}: mean ± sd", spin_phrase(spin)), kSystem,
                 &Condition::n_system);
  table.columns.insert(table.columns.begin() + 1, {"theta_in_deg", "theta in", "deg", 2});
  table.columns.push_back({"mean_speed_mps", "distance/time", "m/s", 2});
  table.columns.push_back({"speed_limits_mps", "vx LO to TD", "m/s", 2});
  table.columns.push_back({"pulse_distance_cm", "by pulse", "cm", 2});
  for (Row& row : table.rows) {
    const Condition& c = *m.used.condition(row.label);
    row.cells.insert(row.cells.begin() + 1, repeated_angle(m, c, table.id));
    row.cells.push_back(computed_only(10.0 * c.dwell_distance_cm.mean / c.dwell_time_ms.mean));
    row.cells.push_back(text_cell(fmt::format("{:.2f} to {:.2f}", c.vx_lo_mps.mean, c.vx_td_mps.mean)));
    row.cells.push_back(pulse_distance(c, impact::PulseForm::exact));
  }
  table.notes.push_back(
      "anew: e = -vy LO/vy TD and mu = (vx TD - vx LO)/(vy LO - vy TD) of the means; distance and time are "
      "means of replicates");
  table.notes.push_back(
      "distance/time must lie between the speeds along the surface at lift-off and touchdown; by pulse: what "
      "a friction of mu F_y gives (damped sine, exact): it is longer where the ball grips early");
  return table;
}

Table spread_table(const ThesisInputs& m) {
  Table table{.id = "spread", .title = "Spread of the angles against those of components and speed"};
  table.columns = {{"theta_in_sd_deg", "sd theta in", "deg", 2},
                   {"theta_out_sd_deg", "sd theta out", "deg", 2}};
  for (const Condition* used : m.conditions()) {
    // The spreads belong to each other as they are printed.
    const Condition& c = *m.printed.condition(used->name());
    Row row{c.name(), {}};
    const DerivedValue in = angle_sd_deg(c.vx_td_mps, c.vy_td_mps, c.v_td_mps);
    const DerivedValue out = angle_sd_deg(c.vx_lo_mps, c.vy_lo_mps, c.v_lo_mps);
    row.cells.push_back(compared({c.theta_in_deg.sd, kLastDigit, {}}, in.value, in.tolerance));
    row.cells.push_back(compared({c.theta_out_deg.sd, kLastDigit, {}}, out.value, out.tolerance));
    explain(row.cells[0], erratum(m, c.name(), "theta_in_sd_deg", {"table_02", "table_03", "table_04"}));
    explain(row.cells[1], erratum(m, c.name(), "theta_out_sd_deg", {"table_05", "table_06", "table_07"}));
    table.rows.push_back(std::move(row));
  }
  table.notes.push_back(
      "anew: sd(vx)^2 + sd(vy)^2 = sd(v)^2 + v^2 sd(theta)^2, whatever the correlation of the components");
  return table;
}

}  // namespace strobe::thesis
