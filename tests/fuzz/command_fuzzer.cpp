// Commands come from the network: any bytes are either obeyed by the rules or ignored, without much memory.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <strobe_msgs/command_t.hpp>

#include "firmware/core/shot_plan.hpp"
#include "firmware/publisher/receiver.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace strobe::firmware;
  static const Rig rig;
  if (!well_formed(data, size)) return 0;
  strobe_msgs::command_t command{};
  if (command.decode(data, 0, static_cast<int>(size)) < 0) return 0;
  const auto plan = from_message(command.plan);
  if (defect_of(command, rig).empty() && command.kind == strobe_msgs::command_t::FIRE) {
    if (flash_count(plan) < 1 || flash_count(plan) > rig.lamps.max_flashes) std::abort();
    if (plan.period < rig.lamps.min_period || plan.exposure > rig.shutter.max_open) std::abort();
  }
  return 0;
}
