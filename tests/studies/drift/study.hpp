// How soon a drift of scale, clock, tilt or a lamp is told, what is named as its cause, and how often sound shots
// alarm: simulated shots with stamps of both lamps' sensors and heartbeats between them, of which one thing is
// changed after some. Deterministic from the seed, whatever the number of threads. Thread-safe; allocates.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string_view>
#include <vector>

#include "host/series/drift.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::studies {

/// Of a digitizer, or of a person. [px]
struct DigitizingNoise {
  double centre_px = 0.05, diameter_px = 0.06, equator_rad = 0.001;
};

enum class DriftKind { scale, clock, tilt, lamp };
inline constexpr std::array<std::string_view, 4> kDriftKindNames{"scale", "clock", "tilt", "lamp"};

struct DriftPlan {
  std::vector<sim::Scene> scenes;
  DigitizingNoise noise;
  int runs = 20;    ///< of each drift and condition
  int before = 20;  ///< sound shots of each, then
  int after = 60;   ///< with the drift, at most
  int later = 10;   ///< after the alarm the cause is asked for once more
  int sound = 20000;
  double scale = 0.003, clock = 0.003, tilt_deg = 0.5, lamp_us = 10.0;
  std::uint64_t seed = 1;
  int threads = 2;
};

struct DriftTold {
  std::vector<int> shots;  ///< with the drift until it was told, the telling one included, ascending
  int runs = 0, early = 0;  ///< early: alarms before the drift began; these runs are left out
  int right = 0, right_later = 0;  ///< the cause alone is named
  int among = 0;                   ///< it is among those that cannot be told apart
  std::array<int, host::kWitnessCount> told_by{};
};

struct DriftStudy {
  std::array<DriftTold, kDriftKindNames.size()> told;  ///< index: DriftKind
  int sound = 0, false_alarms = 0;
  std::array<int, host::kWitnessCount> false_by{};
};

/// `done` counts runs, of which there are `total_runs`.
DriftStudy run(const DriftPlan& plan, std::atomic<int>& done);
int total_runs(const DriftPlan& plan);

}  // namespace strobe::studies
