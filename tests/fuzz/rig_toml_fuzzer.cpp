// Rig files come from people: any bytes are either a rig within its limits or an error of one line.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "firmware/core/pulse_schedule.hpp"
#include "firmware/core/rig.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace strobe::firmware;
  const std::string_view text = text_of(data, size);
  const auto rig = read_rig(text, "fuzz.toml");
  if (!rig) return require_one_line(rig.error().message, "fuzz.toml:"), 0;
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
