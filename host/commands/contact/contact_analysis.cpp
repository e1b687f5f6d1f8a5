// The analysis behind `strobe contact`.
#include "host/commands/contact/contact_report.hpp"

namespace strobe::host {

namespace {

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

}  // namespace

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

}  // namespace strobe::host
