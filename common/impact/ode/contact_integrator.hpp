// Implementation of contact_ode.hpp: integrates a contact from touchdown to release with its events.
// Allocates only for the steps stored on request; thread-safe.
#pragma once

#include <vector>

#include "common/impact/ode/contact_system.hpp"

namespace strobe::impact::detail {

/// A step; `derivative` is that at its start.
struct ContactStep {
  double tau = 0.0;
  double size = 0.0;
  ContactMode mode = ContactMode::grips;
  State start{};
  State derivative{};
};

/// `system`: from make_system(). `steps` is replaced by the steps taken if it is not null. collocation: by
/// dormand_prince, to 1e-12. Errors:
/// tolerance_out_of_range, no_release, too_many_steps.
tl::expected<ContactSummary, InputError> integrate(const System& system, const ContactOptions& options,
                                                   std::vector<ContactStep>* steps);

}  // namespace strobe::impact::detail
