// The report of `strobe contact`: JSON for programs, a page for people.
#include "host/commands/contact_report.hpp"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/messages/parsed_json.hpp"
#include "common/units/angles.hpp"

namespace strobe::host {

namespace {

using contact::CubicFit;
using nlohmann::ordered_json;

ordered_json poly(const std::optional<CubicFit>& fit) {
  return fit ? ordered_json(fit->coefficients) : ordered_json();
}

ordered_json poly_errors(const std::optional<CubicFit>& fit) {
  return fit ? messages::or_null(fit->standard_errors) : ordered_json();
}

ordered_json r_squared(const std::optional<CubicFit>& fit) {
  return fit ? messages::or_null(fit->r_squared) : ordered_json();
}

/// An sd of 0 is not known.
ordered_json sd_json(double sd) { return sd > 0.0 ? ordered_json(sd) : ordered_json(); }

/// Number by number into `values`, its sd under the same name into `sds`.
void put(ordered_json& values, ordered_json& sds, const std::string& key, const ValueSd& v,
         double unit = 1.0) {
  values[key] = v.value * unit;
  sds[key] = sd_json(v.sd * unit);
}

void put_peak(ordered_json& out, ordered_json& sds, const std::string& key, const char* unit,
              const contact::Peak& peak) {
  put(out, sds, key + unit, peak.size);
  put(out, sds, key + "_time_ms", peak.time_s, 1e3);
  put(out, sds, key + "_fraction", peak.fraction);
}

void put_peaks(ordered_json& out, const ContactJob& job, const ContactReport& r) {
  ordered_json sds;
  put_peak(out, sds, "max_normal_force", "_n", r.peaks.normal_force);
  put_peak(out, sds, "max_deformation", "_m", r.peaks.deformation);
  if (job.omega_td_radps) {
    put_peak(out, sds, "max_friction_force", "_n", r.peaks.friction_force);
    if (r.peaks.grip_fraction) {
      put(out, sds, "grip_fraction", *r.peaks.grip_fraction);
      put(out, sds, "grip_time_ms", *r.peaks.grip_time_s, 1e3);
    } else {
      out["grip_fraction"] = nullptr;
    }
    put(out, sds, "pulse_rotation_deg", r.peaks.total_rotation_rad, degrees(1.0));
  }
  out["sd"] = job.project_set ? sds : ordered_json();
}

/// With the total rotation given, else with each motion's best.
const contact::RotationError& error_used(const contact::RotationErrors& errors) {
  return errors.given_total ? *errors.given_total : errors.fitted_total;
}

void put_spin(ordered_json& out, const ContactReport& r) {
  out["see_rotation_rad"] = nullptr;
  out["see_rotation_fraction"] = nullptr;
  if (!r.spin_errors) return;
  out["see_grip_x_m"] = r.spin_errors->see_x_m;
  out["vx_lo_mps"] = r.lift_off.vx_mps;
  out["omega_lo_radps"] = r.lift_off.omega_radps;
  if (!r.spin_errors->rotation) return;
  const contact::RotationErrors& errors = *r.spin_errors->rotation;
  const contact::RotationError& used = error_used(errors);
  out["see_rotation_rad"] = used.see_rad;
  out["see_rotation_fraction"] = messages::or_null(used.see_fraction);
  out["total_rotation_deg"] = degrees(used.total_rad);
  out["total_rotation_sd_deg"] =
      errors.given_total ? ordered_json() : sd_json(degrees(errors.fitted_total_sd_rad.value_or(0.0)));
  out["total_rotation_source"] = r.rotation_source;
}

ordered_json growth(const std::optional<CubicFit>& fit) {
  const auto g = fit ? contact::error_growth(*fit) : std::nullopt;
  if (!g) return nullptr;
  return {{"position", g->position}, {"velocity", g->velocity}, {"force", g->force}};
}

ordered_json cubic_json(const ContactReport& r) {
  ordered_json out, sds;
  const auto ends = [&](const char* where, double t) {
    const contact::DerivedState s = contact::derive(r.fits, r.scale, t);
    const std::string suffix = where;
    if (s.vx_mps) put(out, sds, "vx_" + suffix + "_mps", *s.vx_mps);
    if (s.vy_mps) put(out, sds, "vy_" + suffix + "_mps", *s.vy_mps);
    if (s.omega_radps && r.scale.total_rotation_rad != 0.0)
      put(out, sds, "omega_" + suffix + "_radps", *s.omega_radps);
  };
  ends("td", 0.0);
  ends("lo", 1.0);
  out["slip_zero_fraction"] = r.zeros.slip;
  out["omega_zero_fraction"] = r.zeros.omega;
  out["rotation_zero_fraction"] = r.zeros.rotation;
  if (r.fits.y)
    out["condition_number"] = {{"monomial", r.fits.y->condition.monomial},
                               {"scaled", r.fits.y->condition.scaled},
                               {"centred", r.fits.y->condition.centred}};
  out["relative_sd"] = {
      {"x", growth(r.fits.x)}, {"y", growth(r.fits.y)}, {"rotation", growth(r.fits.rotation)}};
  out["sd"] = sds;
  return out;
}

ordered_json spline_json(const ContactReport& r) {
  ordered_json out;
  out["see_x_m"] = r.spline.x ? ordered_json(r.spline_errors.see_x_m) : ordered_json();
  out["see_y_m"] = r.spline.y ? ordered_json(r.spline_errors.see_y_m) : ordered_json();
  const bool turns = r.spline.rotation && r.spline_errors.rotation && r.spline_errors.rotation->given_total;
  out["see_rotation_rad"] =
      turns ? ordered_json(r.spline_errors.rotation->given_total->see_rad) : ordered_json();
  if (r.spline_force) {
    out["max_normal_force_n"] = r.spline_force->force_n.value;
    out["max_normal_force_sd_n"] = sd_json(r.spline_force->force_n.sd);
    out["max_normal_force_fraction"] = r.spline_force->fraction;
  }
  return out;
}

ordered_json mechanics_json(const ContactReport& r) {
  if (!r.mechanics) return nullptr;
  const MechanicsReport& m = *r.mechanics;
  ordered_json out{{"see_x_m", m.errors.see_x_m}, {"see_y_m", m.errors.see_y_m}};
  out["see_rotation_rad"] =
      m.errors.rotation ? ordered_json(error_used(*m.errors.rotation).see_rad) : ordered_json();
  out["rotation_deg"] = degrees(m.summary.rotation_rad);
  out["skid_to_grip_ms"] =
      m.summary.skid_to_grip_s ? ordered_json(1e3 * *m.summary.skid_to_grip_s) : ordered_json();
  out["max_normal_force_n"] = m.summary.max_force_n;
  out["max_deformation_m"] = m.summary.max_depth_m;
  return out;
}

ordered_json left_out_json(const contact::LeaveOneOutRms& l) {
  return {{"cubic", messages::or_null(l.cubic)},
          {"spline", messages::or_null(l.spline)},
          {"pulse", messages::or_null(l.pulse)}};
}

ordered_json stiffness_json(const contact::Stiffness& s) {
  return {{"half_period", s.half_period},
          {"secant", s.secant},
          {"energy", s.energy},
          {"compression", s.compression},
          {"peak_time", s.peak_time},
          {"kelvin_voigt", s.kelvin_voigt},
          {"kelvin_voigt_zeta", s.kelvin_voigt_zeta}};
}

ordered_json inputs_json(const ContactJob& job) {
  const contact::ContactInputs& in = job.inputs;
  ordered_json out{{"set", job.name},
                   {"repeated", job.set.repeated},
                   {"corrected", job.corrected},
                   {"vx_td_mps", in.vx_td_mps},
                   {"vy_td_mps", in.vy_td_mps},
                   {"e", in.e},
                   {"mu", in.mu},
                   {"dwell_time_ms", job.dwell_time_ms},
                   {"dwell_distance_cm", job.dwell_distance_cm},
                   {"diameter_m", in.diameter_m},
                   {"form", impact::name(in.form)}};
  out["omega_td_radps"] = messages::or_null(job.omega_td_radps);
  out["omega_lo_radps"] = messages::or_null(job.omega_lo_radps);
  out["vx_lo_mps"] = job.ends.vx_lo_mps.value;
  out["vy_lo_mps"] = job.ends.vy_lo_mps.value;
  out["mass_kg"] = job.pulse.ball.mass_kg;
  out["alpha"] = job.pulse.ball.alpha;
  out["offset_mm"] = 1e3 * job.pulse.offset_m;
  out["total_rotation_deg"] =
      job.total_rotation_rad ? ordered_json(degrees(*job.total_rotation_rad)) : ordered_json();
  return out;
}

// --- For people ------------------------------------------------------------------------------------------

void print_head(const ContactJob& job, const ContactReport& r) {
  const contact::ContactInputs& in = job.inputs;
  const char* version = !job.project_set ? "" : job.corrected ? " (corrected)" : " (as printed)";
  std::printf("%s%s: %d images between touchdown and lift-off", job.name.c_str(), version, r.thesis_errors.n);
  if (job.set.repeated > 0) std::printf(" (%d rows repeat others and do not count)", job.set.repeated);
  std::printf("\n");
  std::printf("  touchdown vx %g, vy %g m/s", in.vx_td_mps, in.vy_td_mps);
  if (job.omega_td_radps) std::printf(", spin %g rad/s", *job.omega_td_radps);
  std::printf("; e %g, mu %g; dwell %g ms, %g cm; diameter %g m\n", in.e, in.mu, job.dwell_time_ms,
              job.dwell_distance_cm, in.diameter_m);
}

/// Three digits of the value, and the sd to the same place.
void print_value(const char* what, const ValueSd& v, double unit, const char* name) {
  const double size = std::abs(v.value * unit);
  const int decimals = size >= 100.0 ? 0 : size >= 10.0 ? 1 : 2;
  std::printf("  %-30s %9.*f", what, decimals, v.value * unit);
  v.sd > 0.0 ? std::printf(" +- %-8.*f", decimals, v.sd * unit) : std::printf("%12s", "");
  std::printf(" %s\n", name);
}

void print_pulse(const ContactJob& job, const ContactReport& r) {
  std::printf("\nDamped sine pulse, %s form (damping f %.5f)\n",
              std::string(impact::name(job.inputs.form)).c_str(), r.damping_f);
  print_value("largest normal force", r.peaks.normal_force.size, 1.0, "N");
  print_value("  at", r.peaks.normal_force.time_s, 1e3, "ms");
  print_value("deepest", r.peaks.deformation.size, 1e3, "mm");
  print_value("  at", r.peaks.deformation.time_s, 1e3, "ms");
  if (job.omega_td_radps) {
    print_value("largest friction", r.peaks.friction_force.size, 1.0, "N");
    if (r.peaks.grip_fraction) {
      print_value("stops skidding after", *r.peaks.grip_time_s, 1e3, "ms");
      print_value("  share of the contact", *r.peaks.grip_fraction, 1e2, "%");
    } else {
      std::printf("  %-30s %9s\n", "stops skidding", "never");
    }
    print_value("turns", r.peaks.total_rotation_rad, degrees(1.0), "degrees");
  }
  print_value("stiffness m (pi/dwell)^2", {r.stiffness.half_period, 0.0}, 1e-3, "kN/m");
  print_value("  largest force over depth", {r.stiffness.secant, 0.0}, 1e-3, "kN/m");
  print_value("top's drop over that depth",
              {r.drop.ratio, std::hypot(r.drop.sd_images.value_or(0.0), r.drop.sd_inputs)}, 1.0, "");
}

std::string cell(const std::optional<double>& value, double unit, int decimals = 2) {
  if (!value) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.*f", decimals, *value * unit);
  return text;
}

std::optional<double> sd_of(const ValueSd& v) { return v.sd > 0.0 ? std::optional(v.sd) : std::nullopt; }

void print_left_out(const char* what, const contact::LeaveOneOutRms& l, double unit, const char* name) {
  std::printf("  %-22s %8s %8s %8s  %s\n", what, cell(l.pulse, unit).c_str(), cell(l.cubic, unit).c_str(),
              cell(l.spline, unit).c_str(), name);
}

void print_fit(const char* name, const std::optional<CubicFit>& fit) {
  if (!fit) {
    std::printf("  %-9s too few different times\n", name);
    return;
  }
  const auto& c = fit->coefficients;
  std::printf("  %-9s %9.4f %9.4f %9.4f %9.4f", name, c[0], c[1], c[2], c[3]);
  fit->r_squared ? std::printf("   %.4f", *fit->r_squared) : std::printf("        -");
  std::printf("   %d\n", fit->n);
}

void print_end(const char* what, const std::optional<ValueSd>& td, const ValueSd& measured_td,
               const std::optional<ValueSd>& lo, const ValueSd& measured_lo, const char* unit) {
  if (!td || !lo) return;
  std::printf("  %-6s %9.2f +- %-6s (%8.2f) %9.2f +- %-6s (%8.2f) %s\n", what, td->value,
              cell(sd_of(*td), 1.0).c_str(), measured_td.value, lo->value, cell(sd_of(*lo), 1.0).c_str(),
              measured_lo.value, unit);
}

void print_cubics(const ContactJob& job, const ContactReport& r) {
  std::printf("\nCubics in the time fraction        1         T        T2        T3       R2   rows\n");
  print_fit("x", r.fits.x);
  print_fit("y", r.fits.y);
  print_fit("rotation", r.fits.rotation);
  const contact::DerivedState td = contact::derive(r.fits, r.scale, 0.0);
  const contact::DerivedState lo = contact::derive(r.fits, r.scale, 1.0);
  std::printf("  their slopes at touchdown (measured in the air), at lift-off (measured)\n");
  print_end("vx", td.vx_mps, job.ends.vx_td_mps, lo.vx_mps, job.ends.vx_lo_mps, "m/s");
  print_end("vy", td.vy_mps, job.ends.vy_td_mps, lo.vy_mps, job.ends.vy_lo_mps, "m/s");
  if (job.omega_td_radps && job.omega_lo_radps && r.scale.total_rotation_rad != 0.0)
    print_end("omega", td.omega_radps, job.ends.omega_td_radps, lo.omega_radps, job.ends.omega_lo_radps,
              "rad/s");
  if (const auto g = r.fits.y ? contact::error_growth(*r.fits.y) : std::nullopt)
    std::printf("  relative error of y: position %.0f %%, velocity %.0f %%, force %.0f %%\n",
                1e2 * g->position, 1e2 * g->velocity, 1e2 * g->force);
}

void print_comparison(const ContactReport& r) {
  std::printf("\nDistance from the images, sqrt(sum/(N - 1))\n");
  std::printf("  pulse, friction throughout: along %.3f mm, normal %.3f mm\n", 1e3 * r.thesis_errors.see_x_m,
              1e3 * r.thesis_errors.see_y_m);
  if (r.spin_errors) {
    std::printf("  pulse, rolling once it grips: along %.3f mm", 1e3 * r.spin_errors->see_x_m);
    if (const auto& rotation = r.spin_errors->rotation) {
      const contact::RotationError& used = error_used(*rotation);
      std::printf(", rotation %.2f degrees of %.1f in all (%s)", degrees(used.see_rad),
                  degrees(used.total_rad), r.rotation_source);
    }
    std::printf("\n");
  }
  if (r.mechanics) {
    const MechanicsReport& m = *r.mechanics;
    std::printf("  contact mechanics (springs and grip): along %.3f mm, normal %.3f mm",
                1e3 * m.errors.see_x_m, 1e3 * m.errors.see_y_m);
    if (m.errors.rotation)
      std::printf(", rotation %.2f degrees of %.1f", degrees(error_used(*m.errors.rotation).see_rad),
                  degrees(error_used(*m.errors.rotation).total_rad));
    std::printf("\n");
  }
  if (r.spline.x && r.spline.y)
    std::printf("  spline through the measured end velocities: along %.3f mm, normal %.3f mm\n",
                1e3 * r.spline_errors.see_x_m, 1e3 * r.spline_errors.see_y_m);
  if (r.spline_force)
    std::printf("  the spline's largest normal force: %.0f +- %s N at %.0f %% (of the top, not the centre)\n",
                r.spline_force->force_n.value, cell(sd_of(r.spline_force->force_n), 1.0, 0).c_str(),
                1e2 * r.spline_force->fraction);
  std::printf("Error of an image that was left out      pulse    cubic   spline\n");
  print_left_out("              along", r.cross.x_m, 1e3, "mm");
  print_left_out("              normal", r.cross.y_m, 1e3, "mm");
  print_left_out("              rotation", r.cross.rotation_rad, degrees(1.0), "degrees");
}

}  // namespace

void print_contact_json(const ContactJob& job, const ContactReport& r) {
  ordered_json out{{"see_x_m", r.thesis_errors.see_x_m},
                   {"see_y_m", r.thesis_errors.see_y_m},
                   {"n", r.thesis_errors.n},
                   {"damping_f", r.damping_f},
                   {"x_poly", poly(r.fits.x)},
                   {"y_poly", poly(r.fits.y)},
                   {"rotation_poly", poly(r.fits.rotation)}};
  out["r2"] = {
      {"x", r_squared(r.fits.x)}, {"y", r_squared(r.fits.y)}, {"rotation", r_squared(r.fits.rotation)}};
  out["poly_se"] = {
      {"x", poly_errors(r.fits.x)}, {"y", poly_errors(r.fits.y)}, {"rotation", poly_errors(r.fits.rotation)}};
  out["condition"] = job.project_set ? ordered_json(job.name) : ordered_json();
  put_spin(out, r);
  put_peaks(out, job, r);
  out["mechanics"] = mechanics_json(r);
  out["stiffness_npm"] = stiffness_json(r.stiffness);
  out["drop_ratio"] = {{"ratio", r.drop.ratio},
                       {"sd_images", messages::or_null(r.drop.sd_images)},
                       {"sd_inputs", job.project_set ? ordered_json(r.drop.sd_inputs) : ordered_json()}};
  out["cubic"] = cubic_json(r);
  out["spline"] = spline_json(r);
  out["leave_one_out"] = {{"x_m", left_out_json(r.cross.x_m)},
                          {"y_m", left_out_json(r.cross.y_m)},
                          {"rotation_rad", left_out_json(r.cross.rotation_rad)}};
  out["inputs"] = inputs_json(job);
  std::printf("%s\n", messages::json_text(out).c_str());
}

void print_contact_table(const ContactJob& job, const ContactReport& r) {
  print_head(job, r);
  print_pulse(job, r);
  print_cubics(job, r);
  print_comparison(r);
}

}  // namespace strobe::host
