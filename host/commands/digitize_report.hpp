// What `strobe digitize` tells of a photograph: as JSON and as text. Pure; they allocate.
#pragma once

#include <string>
#include <vector>

#include "host/digitize/digitize.hpp"

namespace strobe::host {

/// The frame as one line, and beside its keys (which readers of frames ignore): "photograph", "inputs",
/// "scale" (by the ball's diameter on its images) where there are some, "no_surface" where there is no surface
/// line, "remarks" where there are any, and if asked for "unmeasured".
std::string digitization_json(const digitize::Digitization& digitization, const std::string& photograph,
                              const digitize::DigitizeSettings& settings, bool explain);

/// A table of the images, the surface, the scale, remarks.
std::vector<std::string> digitization_lines(const digitize::Digitization& digitization,
                                            const std::string& photograph,
                                            const digitize::DigitizeSettings& settings);

/// One line for each place or part that was not measured.
std::vector<std::string> unmeasured_lines(const digitize::Digitization& digitization);

/// The time spent, by stage. A time never belongs to a result's bytes: it is for standard error.
std::string stages_line(const digitize::Digitization& digitization);

}  // namespace strobe::host
