// What a rig's lines are on: a GPIO chip, a chip whose PIO plays the outputs, or a flash sequencer. Opened
// before strobed forks; the worker then gets the loop's ports from it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "firmware/core/rig.hpp"
#include "firmware/linux/event_fd.hpp"
#include "firmware/linux/held_outputs.hpp"
#include "firmware/linux/shared_status.hpp"
#include "firmware/ports/clock.hpp"
#include "firmware/ports/edge_source.hpp"
#include "firmware/ports/scheduled_outputs.hpp"

namespace strobe::firmware {

/// Of the loop; they belong to the device.
struct DevicePorts {
  EdgeSource& edges;
  ScheduledOutputs& outputs;
  std::vector<std::string> warnings;  ///< for a person
};

class RigDevice : public HeldOutputs {
 public:
  /// Takes the rig's outputs, inactive from the start. rig must outlive the device.
  static Result<std::unique_ptr<RigDevice>> open(const Rig& rig);
  /// In the worker, once. wake: an eventfd that ends the loop's waits. clock and page must outlive the
  /// device.
  virtual Result<DevicePorts> open_ports(Clock& clock, SharedStatus& page, int wake) = 0;
};

/// Makes outputs inactive that were found but not taken yet; retries for so long.
using Takeover = std::function<Result<void>(Duration patience)>;
/// Of a rig whose strobed is gone, or lost its own hold on the outputs.
Result<Takeover> prepare_takeover(const Rig& rig);

}  // namespace strobe::firmware
