// The shipped programs on a simulated bench, the host across a link that loses, or killed at random instants
// of a shot, or the firmware killed: and what both sides' folders hold in the end. Real time; one thread.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "tests/loss/audit.hpp"
#include "tests/loss/lossy_link.hpp"

namespace strobe::loss {

struct TrialResult {
  Audit audit;
  LinkCounts link;
  double duration_s = 0.0;
  bool fired = false;  ///< the series came to its end as ordered
  int kills = 0;
  std::string words;  ///< what the programs said, for a person who looks for the cause
};

struct LinkTrial {
  LinkFaults faults;
  double cut_s = 0.0;  ///< the link is cut for so long, from an instant of the first shot on; 0: never
  int shots = 1;       ///< that must count
  std::uint64_t seed = 1;
  bool short_exposure = true;  ///< a third of the flashes
};
TrialResult run_trial(const LinkTrial& trial);

enum class Victim { host, firmware };

struct KillTrial {
  Victim victim = Victim::host;
  int kills = 1;  ///< one in each shot, at an instant drawn from the shutter's opening to after the readout
  double loss = 0.0;  ///< of the link between host and firmware, meanwhile
  std::uint64_t seed = 1;
  bool short_exposure = true;
  std::function<void(int kills)> progress = [](int) {};
};
TrialResult run_trial(const KillTrial& trial);

}  // namespace strobe::loss
