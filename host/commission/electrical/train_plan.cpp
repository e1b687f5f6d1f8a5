#include "host/commission/electrical/train_plan.hpp"

#include <algorithm>

namespace strobe::commission {

ShotPlan dry_train(const host::RigFile& rig, Lamps lamps, int flashes) {
  ShotPlan plan;
  plan.dry = true;
  plan.period = std::max(rig.plan.even.period, rig.limits.lamp_period);
  const auto room = static_cast<int>(rig.limits.longest_exposure / plan.period) - 1;
  const int count = std::clamp(
      flashes, 1, std::max(1, std::min({room, rig.limits.max_flashes, static_cast<int>(kMaxCodedFlashes)})));
  for (int k = 0; k < count; ++k) plan.code.push_back({plan.period * k, lamps});
  plan.exposure = plan.period * (count + 1);
  plan.impact_at = plan.exposure / 2;
  return plan;
}

}  // namespace strobe::commission
