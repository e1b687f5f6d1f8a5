// Carries a contact from touchdown to release, one step after another with its events: the inside of
// contact_ode.hpp. No allocation but for the steps kept on request; thread-safe.
#pragma once

#include <vector>

#include "common/impact/ode/contact_system.hpp"

namespace strobe::impact::detail {

/// A step as taken; `slope` is the derivative at its start.
struct ContactStep {
  double tau = 0.0;
  double size = 0.0;
  ContactMode mode = ContactMode::grips;
  State start{};
  State slope{};
};

/// Runs a checked system. `kept` gets every step if it is not null (and is cleared first). Times of the
/// summary's events in seconds. Errors: tolerance_out_of_range, no_release, too_many_steps.
tl::expected<ContactSummary, InputError> run(const System& system, const ContactOptions& options,
                                             std::vector<ContactStep>* kept);

}  // namespace strobe::impact::detail
