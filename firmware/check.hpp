// strobed --check: tries everything that strobed needs and reports what is missing.
#pragma once

#include "firmware/core/rig.hpp"
#include "firmware/worker/options.hpp"

namespace strobe::firmware {

/// Prints one line (or JSON object) per item, and lines for root's shell that mend what can be mended.
/// Returns 0 if none is a fault, else 1; advice, and with --allow-no-rt missing real-time rights, are no
/// faults. Changes nothing but the resistors of inputs (linux/input_bias.hpp). As root, with the service's
/// rig file, it checks the service's key and folder (service_files.hpp).
int check_rig(const Rig& rig, const Options& options);

/// Moves every movable interrupt off the loop's CPU; prints which were moved, refused and cannot be moved.
/// Returns 2 if the rig file names no CPU, 1 if some were refused, else 0.
int move_interrupts(const Rig& rig);

}  // namespace strobe::firmware
