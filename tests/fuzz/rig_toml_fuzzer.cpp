// Rig files come from people: any bytes are either a rig within its limits or an error of one line.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "firmware/core/pulse_schedule.hpp"
#include "firmware/core/rig_file.hpp"

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace strobe::firmware;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto rig = read_rig(text, "fuzz.toml");
  if (!rig) {
    require(rig.error().message.starts_with("fuzz.toml:"));
    require(rig.error().message.find('\n') == std::string::npos);
    return 0;
  }
  require(rig->lamps.pulse <= rig->lamps.max_on && rig->lamps.max_on < rig->lamps.min_period);
  require(rig->machine.pulse <= rig->machine.max_on);
  require(check_plan(rig->plan, *rig).has_value());
  PulseSchedule plan;
  plan.reserve(rig->lamps.max_flashes);
  const auto capacity = plan.pulses.capacity();
  build_schedule(rig->plan, *rig, plan);
  require(plan.pulses.capacity() == capacity);
  require(plan.pulses.front().at == strobe::Duration{});
  return 0;
}
