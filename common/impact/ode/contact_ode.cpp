#include "common/impact/ode/contact_ode.hpp"

#include "common/impact/ode/contact_integrator.hpp"

namespace strobe::impact {

tl::expected<ContactSummary, InputError> simulate(const ball::Ball& ball, const Motion& touchdown,
                                                  const ContactCoefficients& coefficients,
                                                  const ContactOptions& options) {
  const auto system = detail::make_system(ball, touchdown, coefficients);
  if (!system) return tl::unexpected(system.error());
  return detail::run(*system, options, nullptr);
}

}  // namespace strobe::impact
