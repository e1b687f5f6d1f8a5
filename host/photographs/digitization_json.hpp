// A measured photograph as JSON, as `strobe digitize` prints it and as a session keeps it. Pure; allocates.
#pragma once

#include <string>

#include "host/digitize/digitize.hpp"

namespace strobe::host {

/// The frame as one line, and beside its keys (which readers of frames ignore): "photograph", "inputs",
/// "scale" (by the ball's diameter on its images), where there are images, "no_surface" where there is no
/// surface line, "surface_source":"hand" where a person gave it, "remarks" where there are any, and if asked
/// for "unmeasured".
std::string digitization_json(const digitize::Digitization& digitization, const std::string& photograph,
                              const digitize::DigitizeSettings& settings, bool explain);

}  // namespace strobe::host
