// Commands come from the network: any bytes are ignored unless sealed; sealed ones are executed by the rules
// or ignored, without much memory.
#include <cstddef>
#include <cstdint>
#include <strobe_msgs/command_t.hpp>

#include "common/authentication/seal.hpp"
#include "common/messages/plan_lcm.hpp"
#include "common/messages/well_formed.hpp"
#include "firmware/core/pulse_schedule.hpp"
#include "firmware/publisher/receiver.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;

namespace {

using namespace strobe;

void decode_body(std::span<const std::uint8_t> body) {
  using namespace strobe::firmware;
  static const Rig rig;
  if (!strobe::messages::well_formed<strobe_msgs::command_t>(body.data(), body.size())) return;
  strobe_msgs::command_t command{};
  if (command.decode(body.data(), 0, static_cast<int>(body.size())) < 0) return;
  require(find_age(command, 50'000'000'000).size() <= 160);
  const auto plan = messages::plan_from_lcm(command.plan);
  if (!find_defect(command, rig).empty() || command.kind != strobe_msgs::command_t::FIRE) return;
  require(flash_count(plan) >= 1 && flash_count(plan) <= rig.lamps.max_flashes);
  require(!plan.code.empty() || plan.period >= rig.lamps.min_period);
  require(plan.exposure <= rig.shutter.max_open);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto key = authentication::Key::random();
  const std::span<const std::uint8_t> bytes(data, size);
  require(!authentication::unseal(key, "bench", bytes));  // no chance to guess the key
  decode_body(bytes);
  if (const auto sealed = authentication::seal(key, "bench", bytes)) {
    const auto opened = authentication::unseal(key, "bench", *sealed);
    require(opened && opened->size() == size);
  }
  return 0;
}
