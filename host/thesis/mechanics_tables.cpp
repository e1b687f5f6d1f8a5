// Beyond the thesis: rolling friction, and the contact's mechanics fitted to all sets: springs, skid-to-grip
// time, energy.
#include <fmt/format.h>

#include "common/contact/condition_inputs.hpp"
#include "common/impact/fit/rolling_friction.hpp"
#include "common/impact/fit/skid_and_energy.hpp"
#include "host/thesis/tables.hpp"

namespace strobe::thesis {

namespace {

using impact::ContactFit;

Cell cell_of(const ValueSd& value, double unit) { return computed_only(unit * value.value, unit * value.sd); }

Cell time_cell(const std::optional<ValueSd>& value, const char* otherwise) {
  return value ? cell_of(*value, 1e3) : text_cell(otherwise);
}

Table failed(Table table, const std::string& why) {
  table.notes = {"not computed: " + why};
  return table;
}

}  // namespace

Table rolling_table(const ThesisInputs& m) {
  Table table{.id = "rolling", .title = "Rolling friction of each set, from angular momentum alone"};
  table.columns = {{"offset_mm", "d", "mm", 2},
                   {"sd_alpha_mm", "sd by alpha", "mm", 2},
                   {"coefficient", "d/R", "", 4},
                   {"z", "from d = 0", "sd", 1},
                   {"rolling_speed_mps", "rolling speed", "m/s", 1}};
  std::vector<impact::RollingFriction> each;
  for (const impact::Observation& o : impact::observations_of(m.used.conditions, impact::Spread::replicate)) {
    const auto r = impact::rolling_friction(o, ball::Ball{});
    if (!r) continue;
    each.push_back(*r);
    if (!m.shows(o.name)) continue;
    table.rows.push_back(
        {o.name,
         {computed_only(1e3 * r->offset_m, 1e3 * r->offset_sd_m), computed_only(1e3 * r->offset_sd_alpha_m),
          computed_only(r->coefficient, r->coefficient_sd), computed_only(r->z_from_symmetry),
          computed_only(r->rolling_speed_mps)}});
  }
  const impact::RollingFrictionSummary s = impact::summarize(each);
  table.notes = {
      fmt::format(
          "all {} sets: d = {:.2f} ± {:.2f} mm (sd between sets), {} positive; weighted {:.2f} ± {:.2f} "
          "± {:.2f} mm (statistical, alpha); one d for all: chi-square {:.0f} for {} degrees of freedom",
          s.count, 1e3 * s.mean_m, 1e3 * s.scatter_m, s.positive, 1e3 * s.weighted_mean_m,
          1e3 * s.weighted_mean_sd_m, 1e3 * s.mean_sd_alpha_m, s.chi2_of_one_value, s.count - 1),
      "± sd: of one shot, from the printed sds; alpha .55 ± .04"};
  return table;
}

Table mechanics_table(const ThesisInputs& m) {
  Table table{.id = "mechanics",
              .title = "Contact mechanics fitted to all sets, and judged on spins left out"};
  table.columns = {{"mu", "mu", "", 3},
                   {"stiffness_ratio", "kt/k", "", 2},
                   {"damping_ratio", "ct", "sqrt(kt m)", 2},
                   {"offset_share", "offset", "of footprint", 3},
                   {"alpha", "alpha", "", 3},
                   {"rms_vx_mps", "rms vx LO", "m/s", 3},
                   {"rms_omega_radps", "rms omega LO", "rad/s", 2}};
  const ContactFit& fit = m.mechanics;
  Row row{"all sets", {}};
  for (int i = 0; i < impact::kFitParameters; ++i)
    row.cells.push_back(computed_only(fit.value[i], fit.sd(static_cast<impact::ContactParameter>(i))));
  row.cells.push_back(computed_only(fit.vx_rms_mps));
  row.cells.push_back(computed_only(fit.omega_rms_radps));
  table.rows.push_back(std::move(row));
  if (const auto left_out = impact::leave_one_group_out(m.observations, m.mechanics_options)) {
    for (const impact::ContactHeldOutGroup& left : *left_out) {
      Row without{"without " + left.group, {}};
      for (int i = 0; i < impact::kFitParameters; ++i) without.cells.push_back(computed_only(left.value[i]));
      without.cells.push_back(computed_only(left.vx_rms_mps));
      without.cells.push_back(computed_only(left.omega_rms_radps));
      table.rows.push_back(std::move(without));
    }
  }
  table.notes = {
      "normal spring and dashpot of each set from its e and dwell time; the five numbers are common to all",
      "without: fitted without that spin, the rms is over the spin left out"};
  return table;
}

Table skid_table(const ThesisInputs& m) {
  Table table{.id = "skid", .title = "When skidding stops: three ways, for all sets"};
  table.columns = {{"dwell_ms", "dwell", "ms", 2},
                   {"grip_ms", "mechanics: grips", "ms", 2},
                   {"slip_zero_ms", "slip = 0", "ms", 2},
                   {"by_impulse_ms", "by impulse", "ms", 2},
                   {"pulse_ms", "by pulse", "ms", 2},
                   {"reversals", "reversals", "", 0},
                   {"slip_lo_mps", "slip LO computed", "m/s", 2},
                   {"measured_slip_lo_mps", "measured", "m/s", 2}};
  const auto conclusions = impact::skid_and_energy(m.observations, m.mechanics, m.mechanics_options);
  if (!conclusions) return failed(std::move(table), conclusions.error().message);
  for (const impact::SkidToGrip& s : conclusions->skid_to_grip) {
    if (!m.shows(s.name)) continue;
    const thesis::Condition& c = *m.used.condition(s.name);
    const auto peaks =
        contact::peaks(contact::spin_pulse_input(c, impact::PulseForm::exact), contact::spin_pulse_sd(c));
    const bool pulse = peaks && peaks->grip_time_s;
    table.rows.push_back(
        {s.name,
         {cell_of(s.dwell_s, 1e3), time_cell(s.grip_s, "never sticks"), time_cell(s.slip_zero_s, "never"),
          time_cell(s.by_impulse_s, "slides"),
          pulse ? computed_only(1e3 * peaks->grip_time_s->value, 1e3 * peaks->grip_time_s->sd)
                : text_cell("slides"),
          computed_only(s.friction_reversals), computed_only(s.slip_lo_mps),
          cell_of(s.measured_slip_lo_mps, 1.0)}});
  }
  table.notes = {
      "mechanics: the contact point sticks (grips); slip = 0: vx + R omega of the rigid ball; by impulse: "
      "from "
      "the velocities at both ends, friction at its limit until then; by pulse: the same with the set's mu",
      "± sd: of one shot, from the printed sds and the fit's covariance"};
  return table;
}

Table energy_table(const ThesisInputs& m) {
  Table table{.id = "energy", .title = "Where the energy of each set goes"};
  table.columns = {{"touchdown_j", "touchdown", "J", 2},    {"measured_loss_j", "lost, measured", "J", 2},
                   {"computed_loss_j", "computed", "J", 2}, {"normal_j", "normal damping", "J", 2},
                   {"sliding_j", "sliding", "J", 2},        {"tangential_j", "tangential", "J", 2},
                   {"offset_j", "rolling friction", "J", 2}};
  const auto conclusions = impact::skid_and_energy(m.observations, m.mechanics, m.mechanics_options);
  if (!conclusions) return failed(std::move(table), conclusions.error().message);
  for (const impact::EnergyBalance& e : conclusions->energy) {
    if (!m.shows(e.name)) continue;
    table.rows.push_back(
        {e.name,
         {cell_of(e.touchdown_j, 1.0), cell_of(e.measured_loss_j, 1.0), cell_of(e.computed_loss_j, 1.0),
          cell_of(e.normal_damping_j, 1.0), cell_of(e.sliding_j, 1.0), cell_of(e.tangential_j, 1.0),
          cell_of(e.offset_j, 1.0)}});
  }
  table.notes = {
      "kinetic energy of translation and rotation; the four parts sum to the computed loss; springs still "
      "stretched at lift-off are counted with their dashpots"};
  return table;
}

}  // namespace strobe::thesis
