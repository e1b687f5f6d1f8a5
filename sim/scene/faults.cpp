#include "sim/scene/faults.hpp"

#include <cmath>
#include <string>

namespace strobe::sim {

namespace {

constexpr double kMaxDelay_us = 1e6;
constexpr double kMaxDelay_s = 3600.0;

bool concerns_one_flash(FaultKind kind) {
  return kind == FaultKind::flash_late || kind == FaultKind::flash_missing ||
         kind == FaultKind::flash_double || kind == FaultKind::flash_dim ||
         kind == FaultKind::sensor_dropout || kind == FaultKind::sensor_bounce ||
         kind == FaultKind::image_unseen;
}

bool concerns_a_lamp(FaultKind kind) {
  return kind == FaultKind::flash_late || kind == FaultKind::flash_missing ||
         kind == FaultKind::flash_double || kind == FaultKind::flash_dim || kind == FaultKind::lamp_dead ||
         kind == FaultKind::sensor_dead || kind == FaultKind::sensor_dropout ||
         kind == FaultKind::sensor_bounce;
}

bool has_delay(FaultKind kind) {
  return kind == FaultKind::flash_late || kind == FaultKind::flash_double ||
         kind == FaultKind::sensor_bounce || kind == FaultKind::gate_chatter ||
         kind == FaultKind::frame_late || kind == FaultKind::machine_double ||
         kind == FaultKind::camera_vanishes;
}

FaultKind read_kind(config::TomlTable& table) {
  if (!table.has("kind")) {
    table.error_at("kind", "is missing");
    return FaultKind::flash_late;
  }
  const std::string word = table.choice_or("kind", kFaultNames[0], {kFaultNames.begin(), kFaultNames.end()});
  std::size_t i = 0;
  while (kFaultNames[i] != word) ++i;
  return static_cast<FaultKind>(i);
}

void read_place(config::TomlTable& table, Fault& fault) {
  if (table.has("flash_from_impact") && table.has("flash_index"))
    table.error_at("flash_index", "excludes flash_from_impact");
  if (table.has("flash_from_impact")) {
    const auto k = table.integer("flash_from_impact", {-1000, 1000});
    if (k == 0) table.error_at("flash_from_impact", "must not be 0: -1 is the last flash before touchdown");
    fault.flash_from_impact = static_cast<int>(k);
  }
  if (table.has("flash_index"))
    fault.flash_index = static_cast<int>(table.integer("flash_index", {0, 100000}));
}

Duration read_delay(config::TomlTable& table, FaultKind kind) {
  if (kind == FaultKind::frame_late || kind == FaultKind::camera_vanishes) {
    const double delay_s = table.number("delay_s", {0.0, kMaxDelay_s});
    return nanoseconds(std::llround(delay_s * 1e9));
  }
  const double delay_us = table.number("delay_us", {0.0, kMaxDelay_us});
  return nanoseconds(std::llround(delay_us * 1e3));
}

Fault read_fault(config::TomlTable& table) {
  Fault fault;
  fault.kind = read_kind(table);
  fault.shot = static_cast<int>(table.integer_or("shot", 0, {0, 1000000}));
  if (concerns_one_flash(fault.kind)) read_place(table, fault);
  if (concerns_a_lamp(fault.kind)) {
    const std::string lamp = table.choice_or("lamp", "both", {"a", "b", "both"});
    fault.lamp_a = lamp != "b";
    fault.lamp_b = lamp != "a";
  }
  if (has_delay(fault.kind)) fault.delay = read_delay(table, fault.kind);
  return fault;
}

bool at_place(const Fault& fault, const FlashPlace& place) {
  if (fault.shot != 0 && fault.shot != place.shot) return false;
  if (fault.flash_index) return *fault.flash_index == place.index;
  if (fault.flash_from_impact) return place.from_impact && *fault.flash_from_impact == *place.from_impact;
  return true;
}

}  // namespace

std::vector<Fault> read_faults(config::TomlTable& scene) {
  std::vector<Fault> faults;
  for (config::TomlTable& table : scene.tables("fault")) faults.push_back(read_fault(table));
  return faults;
}

const Fault* flash_fault(const std::vector<Fault>& faults, FaultKind kind, const FlashPlace& place,
                         Lamp lamp) {
  for (const Fault& fault : faults) {
    if (fault.kind == kind && fault.concerns(lamp) && at_place(fault, place)) return &fault;
  }
  return nullptr;
}

const Fault* shot_fault(const std::vector<Fault>& faults, FaultKind kind, int shot) {
  for (const Fault& fault : faults) {
    if (fault.kind == kind && (fault.shot == 0 || fault.shot == shot)) return &fault;
  }
  return nullptr;
}

const Fault* shot_fault(const std::vector<Fault>& faults, FaultKind kind, int shot, Lamp lamp) {
  for (const Fault& fault : faults) {
    if (fault.kind == kind && fault.concerns(lamp) && (fault.shot == 0 || fault.shot == shot)) return &fault;
  }
  return nullptr;
}

}  // namespace strobe::sim
