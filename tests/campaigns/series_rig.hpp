// Rigs for series that are interrupted: short shots, a strobed that comes again, and instants of shots to strike at.
#pragma once

#include "tests/campaigns/campaign.hpp"
#include "tests/hil/rig_fixture.hpp"

namespace strobe::campaigns {

/// How long a host is waited for that is to end.
inline constexpr std::chrono::seconds kSeriesEnds{240};

/// Nothing here judges flashes: a loop that is awake before each would only take a core from the others.
hil::RigFixtureOptions series_rig(std::uint64_t seed, bool full_exposure = false);

/// strobed again whenever it has ended, until the rig is taken down.
hil::RigFixtureOptions with_strobed_again(hil::RigFixtureOptions options);

/// Waits from the shutter's next opening on for a drawn time. False if no shot came, as where the host has ended before.
bool reach_instant_of_a_shot(const hil::RigFixture& rig, testing::Process& host, Draws& draws, int latest_ms);

void take_down(hil::RigFixture& rig);

}  // namespace strobe::campaigns
