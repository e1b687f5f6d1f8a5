#include "tests/campaigns/series_rig.hpp"

#include <csignal>
#include <cstdlib>

#include "tests/hil/line_watcher.hpp"

namespace strobe::campaigns {

using namespace std::chrono_literals;

hil::RigFixtureOptions series_rig(std::uint64_t seed, bool full_exposure) {
  hil::RigFixtureOptions options;
  options.seed = seed;
  if (!full_exposure) options.rig_edits = hil::kShortExposure;
  if (std::getenv("STROBE_HIL_WAKE_AHEAD") == nullptr)
    options.rig_edits.emplace_back("wake_ahead_us = 4000", "wake_ahead_us = 0");
  return options;
}

hil::RigFixtureOptions with_strobed_again(hil::RigFixtureOptions options) {
  options.shell = "until [ -e \"$5/stop\" ]; do \"$@\"; done";
  return options;
}

bool reach_instant_of_a_shot(const hil::RigFixture& rig, testing::Process& host, Draws& draws,
                             int latest_ms) {
  constexpr std::int64_t kShotComes =
      60'000 * hil::kMs;  // a host waits for lost answers, a machine stands still
  hil::LineWatcher watch(rig.chip_dir());
  const std::int64_t end = testing::monotonic_now_ns() + kShotComes;
  for (bool over = false; watch.wait_for("SHUTTER", 1, 200ms) == 0;) {
    if (over) return false;
    over = !host.running() || testing::monotonic_now_ns() > end;  // once more: it may have come just before
  }
  testing::sleep_for(std::chrono::milliseconds(draws.between(0, latest_ms)));
  return true;
}

void take_down(hil::RigFixture& rig) {
  testing::write_text(rig.session() / "stop", "");
  if (const pid_t guardian = rig.guardian(); guardian != 0) kill(guardian, SIGTERM);
  rig.sim().wait(20s);
}

}  // namespace strobe::campaigns
