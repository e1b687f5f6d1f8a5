// strobe contact: the images in contact against the damped sine pulse and cubic fits.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>

#include "common/command_line/command_line.hpp"
#include "common/config/files.hpp"
#include "common/contact/condition_inputs.hpp"
#include "common/data/thesis_data.hpp"
#include "common/units/angles.hpp"
#include "host/commands/command.hpp"
#include "host/commands/contact_report.hpp"

namespace strobe::host {

namespace {

struct ContactOptions {
  std::string set;
  std::optional<double> vx_td_mps;
  std::optional<double> vy_td_mps;
  std::optional<double> e;
  std::optional<double> mu;
  std::optional<double> dwell_time_ms;
  std::optional<double> dwell_distance_cm;
  std::optional<double> omega_td_radps;
  std::optional<double> omega_lo_radps;
  std::optional<double> vx_lo_mps;
  std::optional<double> vy_lo_mps;
  std::optional<double> total_rotation_deg;
  double offset_mm = 0.0;
  double diameter_m = ball::kThesisDiameter_m;
  double mass_kg = ball::kThesisMass_kg;
  double alpha = ball::kMeasuredAlpha;
  std::string form = "exact";
  bool as_printed = false;
  bool json = false;
};

/// Defaults that a project's set brings with it; none for a file.
struct Source {
  data::ContactSet set;
  std::optional<thesis::Condition> means;
};

Result<data::ContactSet> read_contacts(const std::string& path) {
  const auto text = config::read_file(path);
  if (!text) return tl::unexpected(text.error());
  return data::parse_contact_csv(*text, path);
}

/// A pipe counts: the shell's <(...) and /dev/stdin.
bool is_file(const std::string& path) {
  std::error_code ignored;
  const auto status = std::filesystem::status(path, ignored);
  return std::filesystem::is_regular_file(status) || std::filesystem::is_fifo(status);
}

Result<Source> find_source(const ContactOptions& options) {
  if (is_file(options.set)) {
    if (options.as_printed)
      return fail(options.set + ": --as-printed is for the project's own sets; a file is read as it stands");
    auto set = read_contacts(options.set);
    if (!set) return tl::unexpected(set.error());
    return Source{*std::move(set), std::nullopt};
  }
  const auto share = config::share_folder();
  if (!share) return tl::unexpected(share.error());
  const auto version = options.as_printed ? thesis::Version::as_printed : thesis::Version::corrected;
  auto data = thesis::load(*share / "thesis", version);
  if (!data) return tl::unexpected(data.error());
  const thesis::Condition* means = data->condition(options.set);
  if (!means)
    return fail(options.set + ": neither a file nor one of the project's sets (zero_17 to back_68)");
  return Source{data->contact.at(options.set), *means};
}

/// The option's value, else the mean of the project's set.
Result<double> value_or_mean(const std::optional<double>& given, const char* option, const Source& source,
                             thesis::MeanSd thesis::Condition::*mean) {
  if (given) return *given;
  if (source.means) return ((*source.means).*mean).mean;
  return fail(std::string("contact: ") + option + " is needed with a file");
}

/// The option's value, else the mean of the project's set, else nothing.
std::optional<double> value_if_known(const std::optional<double>& given, const Source& source,
                                     thesis::MeanSd thesis::Condition::*mean) {
  if (given || !source.means) return given;
  return ((*source.means).*mean).mean;
}

Result<contact::ContactInputs> thesis_inputs(const ContactOptions& o, const Source& source) {
  using thesis::Condition;
  const auto vx = value_or_mean(o.vx_td_mps, "--vx-td", source, &Condition::vx_td_mps);
  const auto vy = value_or_mean(o.vy_td_mps, "--vy-td", source, &Condition::vy_td_mps);
  const auto e = value_or_mean(o.e, "--e", source, &Condition::e);
  const auto mu = value_or_mean(o.mu, "--mu", source, &Condition::mu);
  const auto time = value_or_mean(o.dwell_time_ms, "--dwell-time-ms", source, &Condition::dwell_time_ms);
  const auto distance =
      value_or_mean(o.dwell_distance_cm, "--dwell-distance-cm", source, &Condition::dwell_distance_cm);
  for (const auto* value : {&vx, &vy, &e, &mu, &time, &distance})
    if (!*value) return tl::unexpected(value->error());
  return contact::ContactInputs{
      .vx_td_mps = *vx,
      .vy_td_mps = *vy,
      .e = *e,
      .mu = *mu,
      .dwell_time_s = *time / 1e3,
      .dwell_distance_m = *distance / 1e2,
      .diameter_m = o.diameter_m,
      .form = o.form == "simplified" ? impact::PulseForm::simplified : impact::PulseForm::exact};
}

contact::SpinPulseInput pulse_input(const ContactOptions& o, const contact::ContactInputs& in,
                                    double omega_radps) {
  return {.ball = {.diameter_m = in.diameter_m, .mass_kg = o.mass_kg, .alpha = o.alpha},
          .touchdown = {in.vx_td_mps, in.vy_td_mps, omega_radps},
          .e = in.e,
          .mu = std::abs(in.mu),
          .dwell_s = in.dwell_time_s,
          .offset_m = o.offset_mm / 1e3,
          .form = in.form};
}

/// What the splines must meet. Lift-off velocities that are not given follow from e and mu, which are ratios
/// of them. The published sds belong to the means; what was given instead has none.
contact::EndVelocities end_velocities(const ContactOptions& o, const ContactJob& job, const Source& source) {
  const contact::ContactInputs& in = job.inputs;
  contact::EndVelocities ends;
  if (source.means) ends = contact::end_velocities(*source.means);
  const auto take = [](ValueSd& into, const std::optional<double>& given, bool known, double derived) {
    if (given || !known) into = {given.value_or(derived), 0.0};
  };
  take(ends.vx_td_mps, o.vx_td_mps, source.means.has_value(), in.vx_td_mps);
  take(ends.vy_td_mps, o.vy_td_mps, source.means.has_value(), in.vy_td_mps);
  take(ends.vx_lo_mps, o.vx_lo_mps, source.means.has_value(),
       in.vx_td_mps + in.mu * (1.0 + in.e) * in.vy_td_mps);
  take(ends.vy_lo_mps, o.vy_lo_mps, source.means.has_value(), 0.0 - in.e * in.vy_td_mps);
  take(ends.omega_td_radps, o.omega_td_radps, source.means.has_value(), 0.0);
  take(ends.omega_lo_radps, o.omega_lo_radps, source.means.has_value(), 0.0);
  return ends;
}

Result<ContactJob> prepare(const ContactOptions& o) {
  using thesis::Condition;
  auto source = find_source(o);
  if (!source) return tl::unexpected(source.error());
  const auto inputs = thesis_inputs(o, *source);
  if (!inputs) return tl::unexpected(inputs.error());
  ContactJob job;
  job.name = o.set;
  job.project_set = source->means.has_value();
  job.corrected = job.project_set && !o.as_printed;
  job.inputs = *inputs;
  const Source& known = *source;
  job.dwell_time_ms = *value_or_mean(o.dwell_time_ms, "", known, &Condition::dwell_time_ms);
  job.dwell_distance_cm = *value_or_mean(o.dwell_distance_cm, "", known, &Condition::dwell_distance_cm);
  job.omega_td_radps = value_if_known(o.omega_td_radps, known, &Condition::omega_td_radps);
  job.omega_lo_radps = value_if_known(o.omega_lo_radps, known, &Condition::omega_lo_radps);
  job.pulse = pulse_input(o, *inputs, job.omega_td_radps.value_or(0.0));
  if (known.means) job.pulse_sd = contact::spin_pulse_sd(*known.means);
  if (o.total_rotation_deg) job.total_rotation_rad = radians(*o.total_rotation_deg);
  job.ends = end_velocities(o, job, known);
  job.set = std::move(source->set);
  return job;
}

template <typename T>
Result<T> with_message(tl::expected<T, impact::InputError> value) {
  if (!value) return fail(std::string(impact::message(value.error())));
  return *std::move(value);
}

contact::FractionScale fraction_scale(const ContactReport& r, std::optional<double> total_rotation_rad) {
  return {.dwell_distance_m = r.scale.dwell_distance_m,
          .diameter_m = r.scale.diameter_m,
          .total_rotation_rad = total_rotation_rad};
}

/// Rotation in radians needs a total: the one given, or the one that brings the fractions closest to the
/// pulse.
void choose_total(const ContactJob& job, ContactReport& r) {
  if (job.total_rotation_rad) {
    r.scale.total_rotation_rad = *job.total_rotation_rad;
    r.rotation_source = "given";
  } else if (r.spin_errors && r.spin_errors->rotation) {
    r.scale.total_rotation_rad = r.spin_errors->rotation->fitted_total.total_rad;
    r.rotation_source = "fitted to the pulse";
  } else {
    r.fits.rotation.reset();  // fractions of an unknown angle say nothing in radians
  }
}

bool knows_rotation(const ContactJob& job, const ContactReport& r) {
  return job.omega_td_radps && job.omega_lo_radps && r.scale.total_rotation_rad != 0.0;
}

Result<void> add_spline(const ContactJob& job, ContactReport& r, const contact::SpinPulse& pulse) {
  auto spline = contact::fit_constrained_motion(job.set, r.scale, job.ends);
  if (!spline) return tl::unexpected(spline.error());
  r.spline = *std::move(spline);
  auto cross = contact::leave_one_out(job.set, r.scale, job.ends, contact::trajectory_of(pulse));
  if (!cross) return tl::unexpected(cross.error());
  r.cross = *cross;
  if (!knows_rotation(job, r)) {
    r.spline.rotation.reset();
    r.cross.rotation_rad = {};
  }
  const auto errors = contact::standard_errors(job.set, contact::trajectory_of(r.spline),
                                               fraction_scale(r, r.scale.total_rotation_rad));
  if (!errors) return tl::unexpected(errors.error());
  r.spline_errors = *errors;
  r.spline_force = contact::largest_normal_force(r.spline);
  return {};
}

/// Absent where the ODE refuses the inputs: its spring needs e of at least .001.
std::optional<MechanicsReport> mechanics(const ContactJob& job, const ContactReport& r) {
  const auto ode = impact::ContactTrajectory::make(job.pulse.ball, job.pulse.touchdown,
                                                   {.e = job.pulse.e, .dwell_s = job.pulse.dwell_s});
  if (!ode) return std::nullopt;
  const auto errors = contact::standard_errors(job.set, contact::trajectory_of(*ode),
                                               fraction_scale(r, job.total_rotation_rad));
  if (!errors) return std::nullopt;
  return MechanicsReport{*errors, ode->summary()};
}

/// What the integration approach computes: everything of the pulse.
Result<void> add_integration(const ContactJob& job, ContactReport& r, const contact::SpinPulse& pulse) {
  const auto peaks = with_message(contact::peaks(job.pulse, job.pulse_sd));
  if (!peaks) return tl::unexpected(peaks.error());
  const auto stiffness = with_message(contact::stiffness(job.pulse));
  if (!stiffness) return tl::unexpected(stiffness.error());
  const auto drop = contact::drop_ratio(job.set, job.pulse, job.pulse_sd);
  if (!drop) return tl::unexpected(drop.error());
  r.damping_f = pulse.damping();
  r.peaks = *peaks;
  r.stiffness = *stiffness;
  r.drop = *drop;
  r.lift_off = pulse.at_fraction(1.0);
  if (!job.omega_td_radps) return {};
  const auto errors = contact::standard_errors(job.set, contact::trajectory_of(pulse),
                                               fraction_scale(r, job.total_rotation_rad));
  if (!errors) return tl::unexpected(errors.error());
  r.spin_errors = *errors;
  return {};
}

Result<ContactReport> analyse(const ContactJob& job) {
  const auto thesis_errors = contact::pulse_standard_errors(job.set, job.inputs);
  if (!thesis_errors) return tl::unexpected(thesis_errors.error());
  ContactReport r;
  r.thesis_errors = *thesis_errors;
  r.fits = contact::fit_fractions(job.set);
  r.scale = {.dwell_time_s = job.inputs.dwell_time_s,
             .dwell_distance_m = job.inputs.dwell_distance_m,
             .total_rotation_rad = 0.0,
             .diameter_m = job.pulse.ball.diameter_m,
             .mass_kg = job.pulse.ball.mass_kg,
             .alpha = job.pulse.ball.alpha};
  const auto pulse = with_message(contact::SpinPulse::make(job.pulse));
  if (!pulse) return tl::unexpected(pulse.error());
  if (const auto ok = add_integration(job, r, *pulse); !ok) return tl::unexpected(ok.error());
  const auto rotation_fit = r.fits.rotation;  // reported in fractions even where the total is unknown
  choose_total(job, r);
  if (job.omega_td_radps) r.mechanics = mechanics(job, r);
  r.zeros = contact::zero_crossings(r.fits, r.scale);
  r.fits.rotation = rotation_fit;
  if (const auto ok = add_spline(job, r, *pulse); !ok) return tl::unexpected(ok.error());
  return r;
}

int run_contact(const ContactOptions& options) {
  const auto job = prepare(options);
  if (!job) return bad_input(job.error().message);
  const auto report = analyse(*job);
  if (!report) {
    const int repeated = job->set.repeated;
    return bad_input(
        options.set + ": " + report.error().message +
        (repeated > 0 ? fmt::format(" ({} rows repeat others and do not count)", repeated) : ""));
  }
  options.json ? print_contact_json(*job, *report) : print_contact_table(*job, *report);
  return kDone;
}

}  // namespace

void add_contact_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<ContactOptions>();
  CLI::App* command =
      app.add_subcommand("contact", "Motion and forces of a ball in contact, from its images");
  command
      ->add_option(
          "SET", options->set,
          "CSV file with the columns time_fraction,x_fraction,y_fraction,rotation_fraction, read as it "
          "stands; or one of the project's sets (zero_17 to back_68), whose means are the defaults below")
      ->required();
  command->add_option("--vx-td", options->vx_td_mps, "Speed along the surface at touchdown, m/s");
  command->add_option("--vy-td", options->vy_td_mps,
                      "Speed normal to the surface at touchdown, m/s; negative");
  command->add_option("--e", options->e, "Coefficient of restitution, 0 to 1");
  command->add_option("--mu", options->mu,
                      "Impulse ratio; negative where the surface drove the ball forward");
  command->add_option("--dwell-time-ms", options->dwell_time_ms, "Touchdown to lift-off, ms");
  command->add_option("--dwell-distance-cm", options->dwell_distance_cm, "Along the surface, cm");
  command->add_option("--omega-td", options->omega_td_radps,
                      "Spin at touchdown, rad/s, backspin positive; without it spin is not analysed");
  command->add_option("--omega-lo", options->omega_lo_radps, "Spin at lift-off, rad/s, for the spline");
  command->add_option("--vx-lo", options->vx_lo_mps,
                      "Speed along the surface at lift-off, m/s, for the spline; default from e and mu");
  command->add_option("--vy-lo", options->vy_lo_mps,
                      "Speed normal to the surface at lift-off, m/s, for the spline; default from e");
  command->add_option(
      "--total-rotation-deg", options->total_rotation_deg,
      "Total rotation from touchdown to lift-off, of which the file has fractions (default: the one "
      "that fits best)");
  command->add_option("--offset-mm", options->offset_mm, "Normal force ahead of the centre, mm")
      ->capture_default_str();
  command->add_option("--mass-kg", options->mass_kg, "Mass of the ball, kg")->capture_default_str();
  command->add_option("--alpha", options->alpha, "Moment of inertia over m R^2")->capture_default_str();
  command->add_option("--diameter-m", options->diameter_m, "Diameter of the ball, m")->capture_default_str();
  command->add_option("--form", options->form, "Integral of the pulse: exact, or simplified as in the thesis")
      ->check(CLI::IsMember({"exact", "simplified"}))
      ->capture_default_str();
  command->add_flag("--as-printed", options->as_printed, "A project's set without its corrections");
  command->add_flag("--json", options->json, "One JSON object on stdout");
  command_line::for_experts(
      *command, {"--omega-td", "--omega-lo", "--vx-lo", "--vy-lo", "--total-rotation-deg", "--offset-mm",
                 "--mass-kg", "--alpha", "--diameter-m", "--form", "--as-printed"});
  command->footer(
      "Examples: strobe contact zero_23 --form simplified\n"
      "          strobe contact shot.csv --vx-td 15.62 --vy-td -6.701 --e 0.865 --mu 0.55 "
      "--dwell-time-ms 5.1996 --dwell-distance-cm 6.29 --omega-td 2.6 --omega-lo -313 --json");
  command->callback([options, &exit_status] { exit_status = run_contact(*options); });
}

}  // namespace strobe::host
