// contact_ode.hpp's entry points: by the method asked for, and by the integrator where collocation gives up.
#include "common/impact/ode/collocation_summary.hpp"
#include "common/impact/ode/contact_integrator.hpp"

namespace strobe::impact {

tl::expected<ContactSummary, InputError> simulate(const ball::Ball& ball, const Motion& touchdown,
                                                  const ContactCoefficients& coefficients,
                                                  const ContactOptions& options) {
  const auto system = detail::make_system(ball, touchdown, coefficients);
  if (!system) return tl::unexpected(system.error());
  if (detail::collocates(options)) {
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
  if (detail::collocates(options)) {
    if (const auto constants = detail::CollocationConstants::make(*system))
      if (const auto contact = detail::collocate(*constants, options.tolerance, false, nullptr))
        return detail::lift_off_of(*constants, *contact);
  }
  return detail::integrate(*system, options, nullptr).map([](const ContactSummary& s) {
    return detail::lift_off_of(s);
  });
}

}  // namespace strobe::impact
