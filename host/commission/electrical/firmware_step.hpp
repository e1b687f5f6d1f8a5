// Whether the firmware is heard, is the lab's, and has nothing that it cannot do. Moves nothing.
#pragma once

#include "host/commission/core/step.hpp"

namespace strobe::commission {

class FirmwareStep final : public Step {
 public:
  const std::vector<StepInfo>& infos() const override;
  Needs needs() const override { return {}; }
  std::string briefing(const host::RigFile& rig) const override;
  void begin(const Situation& situation) override;
  Request step(const Situation& situation) override;

 private:
  HostTime begun_;
  std::int64_t last_mono_ns_ = 0;
  int heartbeats_ = 0;
};

}  // namespace strobe::commission
