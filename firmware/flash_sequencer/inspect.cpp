#include "firmware/flash_sequencer/inspect.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <set>
#include <string>
#include <utility>

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

CheckItem answer_times(FlashSequencerLink& link, Clock& clock) {
  constexpr std::size_t kRequests = 100;
  constexpr Duration kPatience = milliseconds(100);
  const char* name = "sequencer.line";
  std::vector<Duration> took;
  while (took.size() < kRequests) {
    const MonoTime asked = clock.now();
    link.ask(flash_sequencer::to_frame(flash_sequencer::Request::hello));
    bool answered = false;
    for (const MonoTime end = asked + kPatience; !answered && clock.now() < end;) {
      link.wait(end);
      if (!link.take()) return {name, Verdict::fault, "the line is gone"};
      answered = link.take_answer().has_value();
    }
    if (!answered)
      return {name, Verdict::fault,
              "request " + std::to_string(took.size()) + " of " + std::to_string(kRequests) +
                  " was not answered in 100 ms"};
    took.push_back(clock.now() - asked);
  }
  std::sort(took.begin(), took.end());
  std::array<char, 96> words{};
  std::snprintf(words.data(), words.size(), "answers within %.1f ms (half of %zu requests), %.1f ms (all)",
                1e3 * to_seconds(took[kRequests / 2]), kRequests, 1e3 * to_seconds(took.back()));
  if (took.back() <= FlashSequencerLink::kAnswerTime) return {name, Verdict::ok, words.data()};
  return {name, Verdict::advice,
          std::string(words.data()) +
              ": shots may not be loaded in time. An adapter from USB that holds "
              "bytes back (latency_timer)? A busy machine?"};
}

CheckItem replies_item(const Rig& rig, const SystemFiles& files) {
  const std::string mask = "sys/devices/virtual/workqueue/cpumask";
  const int cpu = rig.real_time.cpu;
  const std::string where = "CPU " + std::to_string(cpu);
  if (!parse_cpu_mask(files.read(mask).value_or("")).contains(cpu))
    return {"sequencer.replies", Verdict::ok, "no kernel worker for them is known to run on the loop's CPU"};
  std::set<int> others = allowed_cpus(-1, files);
  others.erase(cpu);
  if (others.empty()) return {"sequencer.replies", Verdict::ok, "there is one CPU only"};
  const std::string cure = "echo " + format_cpu_mask(others) + " > /" + mask;
  return {"sequencer.replies",
          Verdict::advice,
          "the kernel's workers, which hand them over, may run on " + where +
              " and wait there for as long as it stands still: as root, " + cure,
          {cure}};
}

std::vector<CheckItem> inspect_flash_sequencer(const Rig& rig) {
  constexpr Duration kPatience = milliseconds(2000);
  auto line = TtyLine::open(rig);
  if (!line) return {{"sequencer.port", Verdict::fault, line.error().message}};
  SystemClock clock;
  Heartbeat heartbeat(**line, clock);
  FlashSequencerLink link(**line, heartbeat, clock);
  if (auto done = link.connect(kPatience); !done)
    return {{"sequencer.port", Verdict::fault, done.error().message}};
  const bool hung = link.reset_by_watchdog();
  const std::string port = rig.flash_sequencer.port;
  return {hung ? CheckItem{"sequencer.port", Verdict::advice,
                           port + ": the flash sequencer's watchdog had reset it: its program hung, or its "
                                  "supply dips; note it, and take its power away once"}
               : CheckItem{"sequencer.port", Verdict::ok, port},
          answer_times(link, clock), clock_item(link.clock_relation(), link.status().received),
          replies_item(rig, SystemFiles()), inputs_item(link.inputs())};
}

}  // namespace strobe::firmware
