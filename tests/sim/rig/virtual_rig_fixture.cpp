#include "tests/sim/rig/virtual_rig_fixture.hpp"

#include <algorithm>

namespace strobe::sim::test {

namespace {

struct Event {
  MonoTime at;
  RigLine line;
  int level;
};

/// Lags as a rig file states them; the scene's may differ.
constexpr Duration kShutterLag = milliseconds(45);
constexpr Duration kMachineLag = milliseconds(310);
constexpr Duration kPulse = microseconds(50);

std::vector<Event> plan(MonoTime start, const ShotTimes& times) {
  const MonoTime shutter = start + milliseconds(300), open = shutter + kShutterLag;
  std::vector<Event> events{{shutter, RigLine::shutter, 1}, {shutter + times.exposure, RigLine::shutter, 0}};
  if (times.throw_ball) {
    const MonoTime trigger = open + times.impact_after - kMachineLag;
    events.push_back({trigger, RigLine::trigger, 1});
    events.push_back({trigger + milliseconds(20), RigLine::trigger, 0});
  }
  for (MonoTime flash = open; flash < open + times.exposure; flash = flash + times.period) {
    for (const RigLine lamp : {RigLine::strobe_a, RigLine::strobe_b}) {
      events.push_back({flash, lamp, 1});
      events.push_back({flash + kPulse, lamp, 0});
    }
  }
  std::ranges::stable_sort(events, {}, &Event::at);
  return events;
}

}  // namespace

Scene plain_scene() {
  Scene scene;
  scene.name = "plain";
  scene.machine.speed_mps = 17.0;
  scene.machine.angle_rad = -23.0 * std::numbers::pi / 180.0;
  scene.bounce.e_speed_mps = 17.0 * 0.39;
  make_exact(scene);
  return scene;
}

void make_exact(Scene& scene) {
  scene = without_spread(scene);
  scene.lamps.jitter_s = scene.sensors.jitter_s = scene.shutter.lag_sd_s = 0.0;
  scene.tablet.centre_sd_m = scene.tablet.equator_sd_rad = 0.0;
}

Exposure VirtualRigFixture::shoot(const ShotTimes& times) {
  drives_.clear();
  std::vector<Exposure> exposures;
  for (const Event& event : plan(now_, times)) {
    rig_.collect(event.at, drives_, exposures);
    rig_.line_changed(event.line, event.level, event.at);
    now_ = event.at;
  }
  now_ = now_ + milliseconds(500);
  rig_.collect(now_, drives_, exposures);
  return exposures.empty() ? Exposure{} : exposures.back();
}

std::vector<Drive> VirtualRigFixture::drives_of(RigLine line, int level) const {
  std::vector<Drive> result;
  std::ranges::copy_if(drives_, std::back_inserter(result),
                       [&](const Drive& d) { return d.line == line && d.level == level; });
  return result;
}

}  // namespace strobe::sim::test
