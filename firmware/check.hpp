// strobed --check: tries what strobed needs and tells what is wrong in words.
#pragma once

#include "firmware/core/rig.hpp"
#include "firmware/options.hpp"

namespace strobe::firmware {

/// Prints one line (or JSON object) per item; returns 0 if all are well, else 1. Takes and changes no line.
/// Advice and what --allow-no-rt tolerates do not count.
int check_rig(const Rig& rig, const Options& options);

/// Keeps every interrupt that can be moved off the loop's CPU; prints what was moved, refused, and is fixed.
/// 2: the rig file names no CPU; 1: some were refused.
int move_interrupts(const Rig& rig);

}  // namespace strobe::firmware
