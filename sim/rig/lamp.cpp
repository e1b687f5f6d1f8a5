#include "sim/rig/lamp.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::sim {

namespace {}  // namespace

Draws& LampModel::draws(int shot) {
  if (!draws_ || draws_shot_ != shot) {
    const Purpose purpose = lamp_ == Lamp::a ? Purpose::lamp_a : Purpose::lamp_b;
    draws_.emplace(seed_, purpose, static_cast<std::uint64_t>(shot));
    draws_shot_ = shot;
  }
  return *draws_;
}

FlashTimes LampModel::on_pulse(MonoTime edge, const FlashPlace& place, std::vector<FaultKind>& occurred) {
  // Drawn for every pulse, so that a fault does not shift the jitter of the flashes after it.
  Draws& jitter = draws(place.shot);
  const double delay_s = std::max(0.0, jitter.normal(scene_.lamps.delay_s, scene_.lamps.jitter_s));
  sensor_jitter_s_ = jitter.normal(0.0, scene_.sensors.jitter_s);
  if (shot_fault(scene_.faults, FaultKind::lamp_dead, place.shot, lamp_)) {
    occurred.push_back(FaultKind::lamp_dead);
    return {};
  }
  if (flash_fault(scene_.faults, FaultKind::flash_missing, place, lamp_)) {
    occurred.push_back(FaultKind::flash_missing);
    return {};
  }
  MonoTime flash = edge + from_seconds(delay_s);
  if (const Fault* late = flash_fault(scene_.faults, FaultKind::flash_late, place, lamp_)) {
    occurred.push_back(FaultKind::flash_late);
    flash = flash + late->delay;
  }
  if (known(last_flash_) && flash - last_flash_ < from_seconds(scene_.lamps.recharge_s)) return {};
  last_flash_ = flash;
  FlashTimes flashes{flash};
  if (const Fault* twice = flash_fault(scene_.faults, FaultKind::flash_double, place, lamp_)) {
    occurred.push_back(FaultKind::flash_double);
    flashes.push_back(flash + twice->delay);  // the fault is that it does so without a full capacitor
    last_flash_ = flashes.back();
  }
  return flashes;
}

bool LampModel::sensor_works(int shot) const {
  return shot_fault(scene_.faults, FaultKind::sensor_dead, shot, lamp_) == nullptr;
}

}  // namespace strobe::sim
