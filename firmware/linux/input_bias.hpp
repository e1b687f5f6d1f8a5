// Inputs with the bias that the rig file wants, and what becomes of chips that have no such resistor. Set-up
// only, not real-time.
//
// Linux tells a refusal only where a driver gives one (or where it is older than 5.5). Of a chip without
// resistors it grants the request in silence and shows the bias as if it were set: only the level of an open
// wire tells.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/gpio/gpio_chip.hpp"
#include "firmware/linux/check_item.hpp"

namespace strobe::firmware {

struct BiasedInputs {
  InputRequest request;
  std::vector<std::string> warnings;  ///< one line for each wire whose break would not stop the rig by itself
};
/// Takes the inputs `lines`, which have `specs`. A bias that the chip refuses is done without if it is the
/// default, and a failure if the file asks for it.
Result<BiasedInputs> request_biased(GpioChip& chip, const Rig& rig, std::span<const Line> lines,
                                    std::vector<InputLineSpec> specs);

/// Tries the bias of a line that nobody uses, e.g. as "lines.estop.bias"; no item for a line that has none
/// and needs none. Of key and e-stop it tries both pulls, the wanted one last, for some milliseconds: an open
/// wire follows.
std::vector<CheckItem> try_bias(GpioChip& chip, const Rig& rig, Line which, unsigned offset);

}  // namespace strobe::firmware
