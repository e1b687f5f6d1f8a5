// What `strobe shot` tells of a shot besides its readout. Pure; they allocate.
#pragma once

#include <string>
#include <vector>

#include "host/archive/stored_session.hpp"

namespace strobe::host {

/// {"shot":"3","utc":…,"photograph":…,"digitizations":[{"source":"auto",…,"counts":true}]} on one line; keys in fixed order,
/// what is absent null. before: the readout before a change; null: there was none, and the key is left out.
std::string measurement_json(const StoredSession& session, const StoredShot& shot, const ShotResult* before);

/// Which photograph, which digitizations, which of them counts.
std::vector<std::string> measurement_lines(const StoredSession& session, const StoredShot& shot);

/// Each number before and after a change of the digitization.
std::vector<std::string> comparison_lines(const ShotResult& before, const ShotResult& after);

}  // namespace strobe::host
