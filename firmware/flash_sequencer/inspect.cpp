#include "firmware/flash_sequencer/inspect.hpp"

#include <array>
#include <cstdio>
#include <string>
#include <utility>

#include "firmware/flash_sequencer/link.hpp"
#include "firmware/flash_sequencer/tty_line.hpp"
#include "firmware/linux/system_clock.hpp"

namespace strobe::firmware {

namespace {

using flash_sequencer::InputLine;
using Verdict = CheckItem::Verdict;

CheckItem clock_item(const ClockRelation& relation, flash_sequencer::Ticks now) {
  std::array<char, 96> words{};
  std::snprintf(words.data(), words.size(), "related to this computer's to %.1f us",
                to_microseconds(relation.sd(now)));
  return {"sequencer.clock", Verdict::ok, words.data()};
}

CheckItem inputs_item(std::uint8_t inputs) {
  const auto on = [inputs](InputLine line) { return (inputs & flash_sequencer::bit(line)) != 0; };
  std::string words = std::string("key ") + (on(InputLine::key) ? "on" : "off") + ", e-stop " +
                      (on(InputLine::estop) ? "pressed" : "released");
  if (on(InputLine::gate)) words += ", the gate is interrupted";
  for (const auto& [line, name] :
       {std::pair{InputLine::sensor_a, "sensor_a"}, {InputLine::sensor_b, "sensor_b"}})
    if (on(line))
      return {"sequencer.inputs", Verdict::fault, words + ", " + name + " is active without a flash"};
  return {"sequencer.inputs", Verdict::ok, words};
}

}  // namespace

std::vector<CheckItem> inspect_flash_sequencer(const Rig& rig) {
  constexpr Duration kPatience = milliseconds(2000);
  auto line = TtyLine::open(rig);
  if (!line) return {{"sequencer.port", Verdict::fault, line.error().message}};
  SystemClock clock;
  Heartbeat heartbeat(**line, clock);
  FlashSequencerLink link(**line, heartbeat, clock);
  if (auto done = link.connect(kPatience); !done)
    return {{"sequencer.port", Verdict::fault, done.error().message}};
  return {{"sequencer.port", Verdict::ok, rig.flash_sequencer.port},
          clock_item(link.clock_relation(), link.status().received),
          inputs_item(link.inputs())};
}

}  // namespace strobe::firmware
