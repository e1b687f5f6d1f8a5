#include "firmware/flash_sequencer/train_edges.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::firmware {

using flash_sequencer::bit;
using flash_sequencer::kMaxEdges;
using flash_sequencer::kMinDelay;
using flash_sequencer::kTick_ns;
using flash_sequencer::Limits;
using flash_sequencer::OutputLine;
using flash_sequencer::Ticks;
using flash_sequencer::Track;

namespace {

std::uint8_t lines_of(const PlannedPulse& pulse) {
  switch (pulse.output) {
    case Output::shutter:
      return bit(OutputLine::shutter);
    case Output::trigger:
      return bit(OutputLine::trigger);
    case Output::strobes:
      return static_cast<std::uint8_t>((has_a(pulse.lamps) ? bit(OutputLine::strobe_a) : 0) |
                                       (has_b(pulse.lamps) ? bit(OutputLine::strobe_b) : 0));
  }
  return 0;
}

Ticks to_ticks(Duration duration, double drift) {
  return std::llround(static_cast<double>(duration.count()) /
                      ((1.0 + drift) * static_cast<double>(kTick_ns)));
}

Ticks longest(std::uint8_t lines, const Limits& limits) {
  Ticks longest = flash_sequencer::kMaxAhead;
  for (std::size_t line = 0; line < limits.max_on_us.size(); ++line) {
    if (((lines >> line) & 1U) != 0)
      longest = std::min(longest, flash_sequencer::ticks_of_us(limits.max_on_us[line]));
  }
  return longest;
}

}  // namespace

Limits on_time_limits(const Rig& rig) {
  const auto us = [](Duration limit) { return static_cast<std::uint32_t>(limit / microseconds(1)); };
  Limits limits;
  const auto set = [&limits](OutputLine line, std::uint32_t max_on_us) {
    limits.max_on_us[static_cast<std::size_t>(line)] = max_on_us;
  };
  set(OutputLine::shutter, us(rig.shutter.max_open));
  set(OutputLine::trigger, us(rig.machine.max_on));
  set(OutputLine::strobe_a, us(rig.lamps.max_on));
  set(OutputLine::strobe_b, us(rig.lamps.max_on));
  return limits;
}

TrainEdges::TrainEdges() {
  changes_.reserve(2 * kMaxEdges);
  edges_.reserve(kMaxEdges);
}

void TrainEdges::clear() noexcept {
  changes_.clear();
  edges_.clear();
}

bool TrainEdges::build(std::span<const PlannedPulse> pulses, Track track, Duration ahead, double drift,
                       const Limits& limits) noexcept {
  clear();
  for (std::size_t i = 0; i < pulses.size(); ++i) {
    const std::uint8_t lines = lines_of(pulses[i]);
    if ((lines & flash_sequencer::outputs_of(track)) == 0) continue;
    if (changes_.size() + 2 > changes_.capacity()) return false;
    const Ticks on = to_ticks(pulses[i].at + ahead, drift);
    const Ticks width =
        std::min(std::max<Ticks>(to_ticks(pulses[i].width, drift), kMinDelay), longest(lines, limits));
    changes_.push_back({on, i, true, lines, 0});
    changes_.push_back({on + width, i, false, lines, 0});
  }
  std::sort(changes_.begin(), changes_.end(), [](const Change& a, const Change& b) {
    return a.at != b.at ? a.at < b.at : a.on != b.on ? b.on : a.pulse < b.pulse;
  });
  Ticks played = 0;
  std::uint32_t levels = 0;
  for (Change& change : changes_) {
    levels = change.on ? levels | change.levels : levels & ~std::uint32_t{change.levels};
    const bool together = !edges_.empty() && change.at <= played;
    if (!together) {
      if (edges_.size() == kMaxEdges) return false;
      const Ticks delay = std::max<Ticks>(change.at - played, kMinDelay);
      if (delay > flash_sequencer::kMaxAhead) return false;
      edges_.push_back({static_cast<std::uint32_t>(delay), 0});
      played += delay;
    }
    edges_.back().levels = levels;
    change.at = played;
    change.edge = static_cast<std::uint16_t>(edges_.size() - 1);
  }
  return true;
}

}  // namespace strobe::firmware
