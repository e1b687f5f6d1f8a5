// What `strobe digitize` tells a person of a photograph. Pure; they allocate.
#pragma once

#include <string>
#include <vector>

#include "host/digitize/digitize.hpp"

namespace strobe::host {

/// A table of the images, the surface, the scale, remarks.
std::vector<std::string> digitization_lines(const digitize::Digitization& digitization,
                                            const std::string& photograph,
                                            const digitize::DigitizeSettings& settings);

/// One line for each place or part that was not measured.
std::vector<std::string> unmeasured_lines(const digitize::Digitization& digitization);

/// The time spent, by stage. A time never belongs to a result's bytes: it is for standard error.
std::string stages_line(const digitize::Digitization& digitization);

}  // namespace strobe::host
