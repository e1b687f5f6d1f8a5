// The shipped programs on a simulated bench, the host across a link that loses, or killed at random instants
// of a shot, or the firmware killed: and what both sides' folders hold in the end. Real time; one thread.
#pragma once

#include <string>

#include "tests/campaigns/campaign.hpp"
#include "tests/campaigns/lossy_link.hpp"

namespace strobe::loss {

enum class Victim { nobody, host, firmware };

struct Trial {
  std::string name{};  ///< its row in the table
  Victim victim = Victim::nobody;
  LinkFaults faults{};
  double cut_s = 0.0;  ///< the link is cut for so long, from an instant of the first shot on; 0: never
  int shots = 1;       ///< that must count, where nobody is killed
  int kills = 0;  ///< one in each shot, at an instant drawn from the shutter's opening to after the readout
  bool full_exposure = false;  ///< else a third of the flashes
};

/// Counts what the audit does, "kills" and what became of "packets".
campaigns::Verdict run_trial(const Trial& trial, campaigns::Draws& draws);

/// Of which kinds a campaign is. Neither links nor kills: both, with a hundred kills of each side.
struct Choice {
  bool links = false;
  int shots = 3, kills = 0;
  double kill_loss = 0.0;
  bool full_exposure = false;
};

/// The trials of a choice in turns: each link, the host killed, strobed killed.
Trial drawn(const Choice& choice, const campaigns::Draws& draws);

}  // namespace strobe::loss
