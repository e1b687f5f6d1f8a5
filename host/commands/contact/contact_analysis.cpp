// The analysis behind `strobe contact`.
#include "host/commands/contact/contact_report.hpp"

namespace strobe::host {

namespace {

template <typename T>
Result<T> with_message(tl::expected<T, impact::InputError> value) {
  if (!value) return fail(std::string(impact::message(value.error())));
  return *std::move(value);
}

/// Rotation in radians needs a total: the one given, or the one that brings the fractions closest to the
/// pulse.
void choose_total(const ContactJob& job, ContactReport& r) {
  if (job.total_rotation_rad) {
    r.scale.total_rotation_rad = *job.total_rotation_rad;
    r.rotation_source = "given";
  } else if (r.spin_score && r.spin_score->rotation) {
    r.scale.total_rotation_rad = r.spin_score->rotation->fitted_total.total_rad;
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
  const contact::SetScale scale{.dwell_distance_m = r.scale.dwell_distance_m,
                                .diameter_m = r.scale.diameter_m,
                                .total_rotation_rad = r.scale.total_rotation_rad};
  auto score = contact::score(job.set, contact::trajectory_of(r.spline), scale);
  if (!score) return tl::unexpected(score.error());
  r.spline_score = *score;
  r.spline_force = contact::largest_normal_force(r.spline);
  return {};
}

}  // namespace

Result<ContactReport> analyse(const ContactJob& job) {
  const auto estimate = contact::estimate_error(job.set, job.inputs);
  if (!estimate) return tl::unexpected(estimate.error());
  ContactReport r;
  r.estimate = *estimate;
  r.fits = contact::fit_fractions(job.set);
  r.scale = {.dwell_time_s = job.inputs.dwell_time_s,
             .dwell_distance_m = job.inputs.dwell_distance_m,
             .total_rotation_rad = 0.0,
             .diameter_m = job.pulse.ball.diameter_m,
             .mass_kg = job.pulse.ball.mass_kg,
             .alpha = job.pulse.ball.alpha};
  const auto pulse = with_message(contact::SpinPulse::make(job.pulse));
  if (!pulse) return tl::unexpected(pulse.error());
  const auto peaks = with_message(contact::peaks(job.pulse, job.pulse_sd));
  if (!peaks) return tl::unexpected(peaks.error());
  const auto stiffness = with_message(contact::stiffness(job.pulse));
  if (!stiffness) return tl::unexpected(stiffness.error());
  const auto drop = contact::drop_ratio(job.set, job.pulse, job.pulse_sd);
  if (!drop) return tl::unexpected(drop.error());
  r.peaks = *peaks;
  r.stiffness = *stiffness;
  r.drop = *drop;
  r.lift_off = pulse->at_fraction(1.0);
  if (job.omega_td_radps) {
    const auto score = contact::score(job.set, contact::trajectory_of(*pulse),
                                      {.dwell_distance_m = r.scale.dwell_distance_m,
                                       .diameter_m = r.scale.diameter_m,
                                       .total_rotation_rad = job.total_rotation_rad});
    if (!score) return tl::unexpected(score.error());
    r.spin_score = *score;
  }
  const auto rotation_fit = r.fits.rotation;  // reported in fractions whether or not radians can be had
  choose_total(job, r);
  if (job.omega_td_radps) {
    const auto mechanics = contact::score_mechanics(job.set, job.pulse.ball, job.pulse.touchdown,
                                                    {.e = job.pulse.e, .dwell_s = job.pulse.dwell_s},
                                                    {.dwell_distance_m = r.scale.dwell_distance_m,
                                                     .diameter_m = r.scale.diameter_m,
                                                     .total_rotation_rad = job.total_rotation_rad});
    if (mechanics) r.mechanics = *mechanics;  // its springs need e of at least .001
  }
  r.zeros = contact::zero_crossings(r.fits, r.scale);
  r.fits.rotation = rotation_fit;
  if (const auto ok = add_spline(job, r, *pulse); !ok) return tl::unexpected(ok.error());
  return r;
}

}  // namespace strobe::host
