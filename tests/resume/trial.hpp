// A session that is interrupted again and again, and gone on with: the shipped programs on a simulated bench, the host
// killed, stopped by a person, or on a full disk, the firmware killed, each at an instant drawn from a seed. In the end
// the host's table is held against the firmware's journals and the simulator's truth. Real time; one thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace strobe::resume {

struct Trial {
  std::uint64_t seed = 1;
  int shots = 3;  ///< that the session is to hold
  int interruptions = 4;
  bool photographs = false;  ///< rendered and digitized, else points of the simulated tablet
};

struct Verdict {
  std::vector<std::string> violations;  ///< in words; empty: all that must hold does
  std::string happened;                 ///< the interruptions in their order, for a person
  std::string words;                    ///< what the programs said
  int fired = 0;                        ///< shots in the journals, dry ones left out
  int cut_off = 0;                      ///< of them without an end, since the firmware died in them
  int rows = 0;                         ///< in the table
  int counted = 0;                      ///< of them, shots that count
};

Verdict run_trial(const Trial& trial);

}  // namespace strobe::resume
