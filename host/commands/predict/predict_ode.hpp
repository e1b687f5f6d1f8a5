// Output of `strobe predict --model ode`: the contact as JSON and text, its trajectory as CSV. Prints to
// stdout.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/impact/ode/contact_trajectory.hpp"

namespace strobe::host {

/// Adds the contact's results besides lift-off: times, extremes, events, energy budget, and with
/// `samples` > 0 that many states from touchdown to release.
void add_contact_json(nlohmann::ordered_json& out, const impact::ContactTrajectory& contact, int samples);

void print_contact(const impact::ContactTrajectory& contact);

/// A header and `samples` rows, equally spaced from touchdown to release: time, place, angle, speeds, forces
/// on the ball, mode.
std::string contact_csv(const impact::ContactTrajectory& contact, int samples);

}  // namespace strobe::host
