#include "tests/campaigns/series_lab.hpp"

#include <csignal>
#include <cstdlib>
#include <stdexcept>

#include "tests/hil/line_changes.hpp"

namespace strobe::campaigns {

using namespace std::chrono_literals;

hil::RigFixtureOptions series_rig(const Draws& draws, bool again, bool full_exposure) {
  hil::RigFixtureOptions options;
  options.seed = draws.seed();
  if (!full_exposure) options.rig_edits = hil::kShortExposure;
  if (std::getenv("STROBE_HIL_WAKE_AHEAD") == nullptr)
    options.rig_edits.emplace_back("wake_ahead_us = 4000", "wake_ahead_us = 0");
  if (again) options.shell = "until [ -e \"$5/stop\" ]; do \"$@\"; done";
  return options;
}

SeriesLab::SeriesLab(const hil::RigFixtureOptions& options, Draws& draws) : draws_(draws), rig_(options) {
  if (!rig_.ready()) throw std::runtime_error("strobed does not start: " + rig_.log());
}

std::optional<testing::ExitStatus> SeriesLab::end_of(testing::Process& host) {
  const auto status = host.wait(240s);
  verdict_.words += host.err();
  return status;
}

bool SeriesLab::reach_instant_of_a_shot(testing::Process& host, int latest_ms) {
  hil::LineWatcher watch(rig_.chip_dir());
  // A host waits for lost answers, a machine stands still.
  const std::int64_t end = testing::monotonic_now_ns() + 60'000 * hil::kMs;
  for (bool over = false; watch.wait_for("SHUTTER", 1, 200ms) == 0;) {
    if (over) return false;
    over = !host.running() || testing::monotonic_now_ns() > end;  // once more: it may have come just before
  }
  testing::sleep_for(std::chrono::milliseconds(draws_.between(0, latest_ms)));
  return true;
}

void SeriesLab::take_down() {
  testing::write_text(rig_.session() / "stop", "");
  if (const pid_t guardian = rig_.guardian(); guardian != 0) kill(guardian, SIGTERM);
  rig_.sim().wait(20s);
  verdict_.words += rig_.log();
}

}  // namespace strobe::campaigns
