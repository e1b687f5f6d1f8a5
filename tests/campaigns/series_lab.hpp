// A rig for series that are interrupted: short shots, a strobed that comes again, and instants of shots to strike at.
#pragma once

#include "tests/campaigns/campaign.hpp"
#include "tests/hil/rig_fixture.hpp"

namespace strobe::campaigns {

/// Nothing here judges flashes: a loop that is awake before each would only take a core from the others.
/// again: strobed is begun anew whenever it has ended, until the rig is taken down.
hil::RigFixtureOptions series_rig(const Draws& draws, bool again, bool full_exposure = false);

class SeriesLab {
 protected:
  /// std::runtime_error if strobed does not start.
  SeriesLab(const hil::RigFixtureOptions& options, Draws& draws);

  std::filesystem::path host_folder() const { return rig_.folder() / "host"; }
  /// Waits for a host that is to end; what it said is kept.
  std::optional<testing::ExitStatus> end_of(testing::Process& host);
  /// Waits from the shutter's next opening on for a drawn time. False if no shot came, as where the host has ended.
  bool reach_instant_of_a_shot(testing::Process& host, int latest_ms);
  void take_down();

  Draws& draws_;
  hil::RigFixture rig_;
  Verdict verdict_;
};

}  // namespace strobe::campaigns
