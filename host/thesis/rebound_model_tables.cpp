// Beyond the thesis: the rebound models fitted to all sets and compared with them, what slides and what
// grips, and the rolling friction.
#include <fmt/format.h>

#include "common/contact/condition_inputs.hpp"
#include "common/impact/fit/cross_validation.hpp"
#include "common/impact/fit/regime.hpp"
#include "common/impact/fit/rolling_friction.hpp"
#include "common/impact/fit/skid_and_energy.hpp"
#include "host/thesis/tables.hpp"

namespace strobe::thesis {

namespace {

using impact::Comparison;
using impact::FittedParameter;
using impact::ModelFit;
using impact::Observation;
using impact::Parameter;
using impact::ReboundModel;
using impact::ResidualStatistics;

constexpr ReboundModel kModels[] = {ReboundModel::slide_roll, ReboundModel::grip, ReboundModel::grip_offset};

std::vector<Observation> observations(const ThesisInputs& m) {
  return impact::observations_of(m.used.conditions, impact::Spread::replicate);
}

/// Fits are of all sets, also where one is shown.
std::optional<ModelFit> fitted(std::span<const Observation> all, ReboundModel model) {
  auto fit = impact::fit(all, impact::default_options(model));
  if (!fit) return std::nullopt;
  return *std::move(fit);
}

Cell or_dash(const std::optional<double>& value) { return value ? computed_only(*value) : text_cell("-"); }

struct Side {
  const char* id;
  const char* title;
  const char* unit;
  int decimals;
  double (*measured)(const Observation&);
  double (*sd)(const Observation&);
  double (*predicted)(const Comparison&);
  std::optional<double> Comparison::*z;
  std::optional<double> Comparison::*z_with_inputs;
};

Table model_table(const ThesisInputs& m, const Side& side) {
  Table table{.id = side.id, .title = side.title};
  table.columns.push_back({"measured", "measured", side.unit, side.decimals});
  for (const ReboundModel model : kModels) {
    const std::string name(impact::name(model));
    table.columns.push_back({name, name, side.unit, side.decimals});
    table.columns.push_back({name + "_z", "z", "", 1});
    table.columns.push_back({name + "_z_with_inputs", "z all", "", 1});
  }
  const std::vector<Observation> all = observations(m);
  std::vector<std::optional<ModelFit>> fits;
  for (const ReboundModel model : kModels) fits.push_back(fitted(all, model));
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!m.shows(all[i].name)) continue;
    Row row{all[i].name, {computed_only(side.measured(all[i]), side.sd(all[i]))}};
    for (const auto& fit : fits) {
      const Comparison* c = fit ? &fit->comparisons[i] : nullptr;
      row.cells.push_back(c ? computed_only(side.predicted(*c)) : text_cell("-"));
      row.cells.push_back(c ? or_dash(c->*side.z) : text_cell("-"));
      row.cells.push_back(c ? or_dash(c->*side.z_with_inputs) : text_cell("-"));
    }
    table.rows.push_back(std::move(row));
  }
  table.notes = {
      "models fitted to all sets (table \"fits\"), each set with its measured e; z: measured less predicted "
      "over the printed sd of lift-off; z all: over that and the prediction's, from the printed sds of "
      "touchdown and e",
      "slide-roll: rigid body, Brody's choice; grip: with tangential restitution; grip-offset: besides, the "
      "normal force ahead of the centre"};
  return table;
}

const Column kFitColumns[] = {{"mu", "mu", "", 3},
                              {"e_x", "e_x", "", 3},
                              {"offset_mm", "d", "mm", 2},
                              {"reference_mps", "u0", "m/s", 2},
                              {"alpha", "alpha", "", 3},
                              {"rms_vx_mps", "rms vx LO", "m/s", 3},
                              {"rms_omega_radps", "rms omega LO", "rad/s", 2},
                              {"within_vx", "vx within sd", "", 0},
                              {"within_omega", "omega within sd", "", 0}};

Cell parameter_cell(ReboundModel model, const ModelFit& fit, Parameter p) {
  if (!impact::has_parameter(model, p)) return {};
  const FittedParameter& f = fit.parameters[impact::index(p)];
  const double unit = p == Parameter::offset_m ? 1e3 : 1.0;
  Cell cell = computed_only(unit * f.value);
  if (f.sd) cell.computed_sd = unit * *f.sd;
  if (f.status != impact::ParameterStatus::fitted && f.status != impact::ParameterStatus::fixed)
    cell.remark = std::string(impact::name(f.status)) +
                  (f.limit ? fmt::format(", 95 % limit {:.3g}", unit * *f.limit) : std::string());
  return cell;
}

void add_statistics(Row& row, const ResidualStatistics& a) {
  row.cells.push_back(computed_only(a.rms_vx_mps));
  row.cells.push_back(computed_only(a.rms_omega_radps));
  row.cells.push_back(text_cell(fmt::format("{} of {}", a.within_sd_vx, a.count)));
  row.cells.push_back(text_cell(fmt::format("{} of {}", a.within_sd_omega, a.count)));
}

Row fit_row(const std::string& label, ReboundModel model, const ModelFit& fit,
            const ResidualStatistics& statistics) {
  Row row{label, {}};
  for (const Parameter p : {Parameter::mu, Parameter::e_x, Parameter::offset_m,
                            Parameter::offset_reference_mps, Parameter::alpha})
    row.cells.push_back(parameter_cell(model, fit, p));
  add_statistics(row, statistics);
  return row;
}

Row statistics_row(const std::string& label, const ResidualStatistics& statistics) {
  Row row{label, {}};
  row.cells.resize(5);
  add_statistics(row, statistics);
  return row;
}

void add_model(Table& table, std::span<const Observation> all, const std::string& name, ReboundModel model,
               const impact::FitOptions& options) {
  const auto fit = impact::fit(all, options);
  if (!fit) return;
  table.rows.push_back(fit_row(name, model, *fit, fit->statistics));
  if (const auto spins = impact::leave_one_group_out(all, options, impact::CrossValidationGroup::spin)) {
    for (const impact::HeldOutGroup& left : spins->groups)
      table.rows.push_back(fit_row("  without " + left.group, model, left.fit, left.statistics));
    table.rows.push_back(statistics_row("  each spin left out", spins->statistics));
  }
  if (const auto series = impact::leave_one_group_out(all, options, impact::CrossValidationGroup::series))
    table.rows.push_back(statistics_row("  each set left out", series->statistics));
}

}  // namespace

Table vx_model_table(const ThesisInputs& m) {
  return model_table(m, {"vx-models", "In/out models against all sets: speed along the surface at lift-off",
                         "m/s", 2, [](const Observation& o) { return o.lift_off.vx_mps; },
                         [](const Observation& o) { return o.lift_off_sd.vx_mps; },
                         [](const Comparison& c) { return c.predicted.lift_off.vx_mps; }, &Comparison::z_vx,
                         &Comparison::z_vx_with_inputs});
}

Table omega_model_table(const ThesisInputs& m) {
  return model_table(m, {"omega-models", "In/out models against all sets: spin at lift-off", "rad/s", 1,
                         [](const Observation& o) { return o.lift_off.omega_radps; },
                         [](const Observation& o) { return o.lift_off_sd.omega_radps; },
                         [](const Comparison& c) { return c.predicted.lift_off.omega_radps; },
                         &Comparison::z_omega, &Comparison::z_omega_with_inputs});
}

Table fit_table(const ThesisInputs& m) {
  Table table{.id = "fits", .title = "In/out models fitted to all sets, and judged on what was left out"};
  table.columns.assign(std::begin(kFitColumns), std::end(kFitColumns));
  const std::vector<Observation> all = observations(m);
  for (const ReboundModel model : kModels)
    add_model(table, all, std::string(impact::name(model)), model, impact::default_options(model));
  impact::FitOptions free = impact::default_options(ReboundModel::grip_offset);
  free.free[impact::index(Parameter::alpha)] = true;
  add_model(table, all, "grip-offset, alpha free", ReboundModel::grip_offset, free);
  table.notes = {
      "± sd: from the residuals; without: fitted without that spin and judged on it; within sd: of the "
      "printed "
      "replicate sds",
      "the replicates' sd, pooled, is .38 m/s and 11.5 rad/s"};
  return table;
}

Table regime_table(const ThesisInputs& m) {
  Table table{.id = "regimes", .title = "What slides throughout and what grips, measured and by the models"};
  table.columns = {{"measured", "measured", "", 0},
                   {"slip_lo_mps", "slip LO", "m/s", 2},
                   {"shortfall_mps", "short of rolling", "m/s", 2},
                   {"brody", "slide-roll", "", 0},
                   {"brody_probability", "P(slides)", "", 3},
                   {"offset", "grip-offset", "", 0},
                   {"offset_z", "z", "", 1},
                   {"offset_probability", "P(slides)", "", 3}};
  const std::vector<Observation> all = observations(m);
  const auto rigid = fitted(all, ReboundModel::slide_roll);
  const auto offset = fitted(all, ReboundModel::grip_offset);
  if (!rigid || !offset) return table;
  for (const Observation& o : all) {
    if (!m.shows(o.name)) continue;
    const auto a = impact::classify_regime(o, ReboundModel::slide_roll, *rigid, ball::kThesisDiameter_m);
    const auto b = impact::classify_regime(o, ReboundModel::grip_offset, *offset, ball::kThesisDiameter_m);
    if (!a || !b) continue;
    table.rows.push_back(
        {o.name,
         {text_cell(std::string(name(a->measured))), computed_only(b->slip_lo_mps, b->slip_lo_sd_mps),
          computed_only(a->shortfall_mps, a->shortfall_sd_mps), text_cell(std::string(name(a->predicted))),
          or_dash(a->probability_slides), text_cell(std::string(name(b->predicted))), or_dash(b->z),
          or_dash(b->probability_slides)}});
  }
  table.notes = {
      "measured: slides when the change of vx is more than two sd short of what rolling off needs, grips "
      "when "
      "it is not short; the thesis's rule after (16a), put right for signed slip, tells all sets as "
      "measured"};
  return table;
}

Table rolling_table(const ThesisInputs& m) {
  Table table{.id = "rolling", .title = "Rolling friction of each set, from angular momentum alone"};
  table.columns = {{"offset_mm", "d", "mm", 2},
                   {"sd_alpha_mm", "sd by alpha", "mm", 2},
                   {"coefficient", "d/R", "", 4},
                   {"z", "from d = 0", "sd", 1},
                   {"rolling_speed_mps", "rolling speed", "m/s", 1}};
  std::vector<impact::RollingFriction> each;
  for (const Observation& o : observations(m)) {
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

// Beyond the thesis: the contact's mechanics fitted to all sets: springs, skid-to-grip time, energy.

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
