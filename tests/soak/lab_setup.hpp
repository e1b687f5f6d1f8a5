// Set-up of one run: scene and shot plan, drawn from a seed. Pure; thread-safe.
#pragma once

#include <string_view>

#include "common/reduction/frame.hpp"
#include "common/result.hpp"
#include "host/config/plan_file.hpp"
#include "sim/scene/scene.hpp"
#include "tests/soak/random.hpp"

namespace strobe::soak {

enum class PlanKind {
  shipped,   ///< the shipped rig file's: 167 flashes in 0.5 s
  brief,     ///< free trains of 70 to 110 ms around the impact
  gated,     ///< bursts after the light gate
  coded,     ///< as brief, at unequal intervals, some flashes left out, some of one lamp
  mixed,     ///< one run in ten as shipped, one in ten gated, the others brief
  extremes,  ///< mixed, of balls that are slowest, fastest, grazing, steep, most spun, or hardly seen
};

struct LabSetup {
  sim::Scene scene;
  host::PlanFile plan;
  reduction::Record notes;
};

LabSetup draw_lab_setup(PlanKind kind, const host::PlanFile& shipped, Random& random);

/// "shipped", "brief", "gated", "coded", "mixed", "extremes".
Result<PlanKind> find_plan_kind(std::string_view word);

}  // namespace strobe::soak
