// The chip and lines that a rig file names, found or told in words that name the file's line and key. Set-up only,
// not real-time.
#pragma once

#include <string>

#include "common/result.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/linux/gpio_chip.hpp"

namespace strobe::firmware {

/// `what` after the file's name, the line's place there, and its key.
std::string line_message(const Rig& rig, Line which, const std::string& what);
/// The same as an error.
tl::unexpected<Error> line_failure(const Rig& rig, Line which, const std::string& what);
Result<GpioChip> open_chip(const Rig& rig);
/// Its offset on the chip.
Result<unsigned> find_line(const GpioChip& chip, const Rig& rig, Line which);
/// Why a line could not be taken, an errno, and by whom it is used.
std::string request_error(const GpioChip& chip, unsigned offset, int error);

}  // namespace strobe::firmware
