// Implementation of contact_ode.hpp: what ContactSummary has besides the lift-off, from a contact's segments.
// Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include "common/impact/ode/contact_collocation.hpp"

namespace strobe::impact::detail {

/// Returns nullopt where there are more events than a summary holds.
std::optional<ContactSummary> summary_of(const CollocationConstants& constants,
                                         const CollocatedContact& contact, const Segments& segments);

/// Both leave out what only a summary has.
ContactLiftOff lift_off_of(const CollocationConstants& constants, const CollocatedContact& contact);
ContactLiftOff lift_off_of(const ContactSummary& summary);

/// In joules, by the node sums of the segments.
ContactEnergy energy_of(const CollocationConstants& constants, const CollocatedContact& contact,
                        const Segments& segments);

}  // namespace strobe::impact::detail
