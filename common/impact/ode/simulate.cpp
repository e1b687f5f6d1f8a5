// contact_ode.hpp's entry points: by the method asked for, and by the integrator where collocation gives up.
#include "common/impact/ode/collocation_summary.hpp"
#include "common/impact/ode/contact_integrator.hpp"

namespace strobe::impact {

namespace {

bool tolerance_in_range(double tolerance) { return tolerance >= 1e-12 && tolerance <= 1e-3; }

ContactLiftOff lift_off_of(const ContactSummary& s) {
  return {s.lift_off, s.regime, s.dwell_s, s.skid_to_grip_s, s.dwell_distance_m, s.rotation_rad, s.method};
}

ContactLiftOff lift_off_of(const detail::CollocationConstants& c, const detail::CollocatedContact& contact) {
  const detail::System& s = c.system;
  const double second = 1.0 / s.frequency_radps;
  const double metre = s.speed_mps * second;
  const detail::TangentialState& end = contact.release;
  ContactLiftOff out;
  out.lift_off = {s.speed_mps * (s.vx0 + c.vx_change(end, contact.tau)), -s.speed_mps * contact.rate,
                  s.speed_mps * c.spin(end) / s.radius_m};
  out.regime = contact.regime();
  out.dwell_s = contact.tau * second;
  if (const auto tau = contact.skid_to_grip_tau()) out.skid_to_grip_s = *tau * second;
  out.dwell_distance_m = metre * s.path(contact.tau, c.path_change(end, contact.tau));
  out.rotation_rad = metre * (s.w0 * contact.tau + end.angle) / s.radius_m;
  out.method = ContactMethod::collocation;
  return out;
}

}  // namespace

tl::expected<ContactSummary, InputError> simulate(const ball::Ball& ball, const Motion& touchdown,
                                                  const ContactCoefficients& coefficients,
                                                  const ContactOptions& options) {
  const auto system = detail::make_system(ball, touchdown, coefficients);
  if (!system) return tl::unexpected(system.error());
  if (options.method == ContactMethod::collocation && tolerance_in_range(options.tolerance)) {
    if (const auto constants = detail::CollocationConstants::make(*system)) {
      detail::Segments segments;
      const auto contact = detail::collocate(*constants, options.tolerance, true, &segments);
      if (const auto summary = contact ? detail::summary_of(*constants, *contact, segments) : std::nullopt)
        return *summary;
    }
  }
  return detail::integrate(*system, options, nullptr);
}

tl::expected<ContactLiftOff, InputError> lift_off(const ball::Ball& ball, const Motion& touchdown,
                                                  const ContactCoefficients& coefficients,
                                                  const ContactOptions& options) {
  const auto system = detail::make_system(ball, touchdown, coefficients);
  if (!system) return tl::unexpected(system.error());
  if (options.method == ContactMethod::collocation && tolerance_in_range(options.tolerance)) {
    if (const auto constants = detail::CollocationConstants::make(*system))
      if (const auto contact = detail::collocate(*constants, options.tolerance, false, nullptr))
        return lift_off_of(*constants, *contact);
  }
  return detail::integrate(*system, options, nullptr).map([](const ContactSummary& s) {
    return lift_off_of(s);
  });
}

}  // namespace strobe::impact
