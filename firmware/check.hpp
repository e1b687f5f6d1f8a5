// strobed --check: tries what strobed needs and tells what is wrong in words.
#pragma once

#include "firmware/core/rig.hpp"
#include "firmware/options.hpp"

namespace strobe::firmware {

/// Prints one line (or JSON object) per item; returns 0 if all are well, else 1. Takes and changes no line.
int check_rig(const Rig& rig, const Options& options);

}  // namespace strobe::firmware
