// A session that is interrupted again and again, and gone on with: the shipped programs on a simulated bench, the host
// killed, stopped by a person, or on a full disk, the firmware killed, each at an instant drawn from a seed. In the end
// the host's table is held against the firmware's journals and the simulator's truth. Real time; one thread.
#pragma once

#include "tests/campaigns/campaign.hpp"

namespace strobe::resume {

struct Trial {
  int shots = 4;  ///< that the session is to hold
  int interruptions = 6;
  bool photographs = false;  ///< rendered and digitized, else points of the simulated tablet
};

/// Every fourth one with photographs, and all if `wanted` says so.
Trial drawn(const Trial& wanted, const campaigns::Draws& draws);

/// Counts shots: those "fired", as the journals say, dry ones left out; of them those "without an end", since the firmware
/// died in them; "rows" of the table, and those that "count".
campaigns::Verdict run_trial(const Trial& trial, campaigns::Draws& draws);

}  // namespace strobe::resume
