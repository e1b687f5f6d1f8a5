#include "tests/soak/counts.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tests/soak/truth_comparison.hpp"

namespace strobe::soak {

namespace {

template <std::size_t N>
void add_each(std::array<std::int64_t, N>& sum, const std::array<std::int64_t, N>& more) {
  for (std::size_t i = 0; i < N; ++i) sum[i] += more[i];
}

}  // namespace

void SoakCounts::add(const SoakCounts& other) {
  const auto sum = [&](std::int64_t SoakCounts::*field) { this->*field += other.*field; };
  for (const auto field : {&SoakCounts::runs,
                           &SoakCounts::shots,
                           &SoakCounts::planned,
                           &SoakCounts::unfinished,
                           &SoakCounts::triggers,
                           &SoakCounts::boots,
                           &SoakCounts::hosts,
                           &SoakCounts::good,
                           &SoakCounts::flagged,
                           &SoakCounts::withheld,
                           &SoakCounts::compared,
                           &SoakCounts::explained,
                           &SoakCounts::mismatched,
                           &SoakCounts::packets,
                           &SoakCounts::packets_lost,
                           &SoakCounts::packets_doubled,
                           &SoakCounts::packets_reordered,
                           &SoakCounts::strangers,
                           &SoakCounts::acts,
                           &SoakCounts::stops_reached,
                           &SoakCounts::stops_asked,
                           &SoakCounts::stops_confirmed,
                           &SoakCounts::stops_told_missing,
                           &SoakCounts::stopped_triggers,
                           &SoakCounts::events_journalled,
                           &SoakCounts::events_missing,
                           &SoakCounts::events_never_received,
                           &SoakCounts::events_lost_dying,
                           &SoakCounts::violations})
    sum(field);
  add_each(flags, other.flags);
  add_each(explained_by, other.explained_by);
  add_each(rig_faults, other.rig_faults);
  add_each(hazards, other.hazards);
  for (std::size_t i = 0; i < largest_z.size(); ++i)
    largest_z[i] = std::max(largest_z[i], other.largest_z[i]);
  virtual_s += other.virtual_s;
  digest += other.digest;
}

std::string table_of(const SoakCounts& counts) {
  std::string text;
  const auto line = [&text](std::string_view what, const auto& value) {
    text += fmt::format("{:<44} {:>14}\n", what, value);
  };
  line("runs", counts.runs);
  line("shots fired", counts.shots);
  line("  of runs that wanted", counts.planned);
  line("runs that gave up", counts.unfinished);
  line("hours on the virtual clock", fmt::format("{:.1f}", counts.virtual_s / 3600.0));
  line("starts of the firmware, of hosts", fmt::format("{}, {}", counts.boots, counts.hosts));
  line("pulses of the machine's trigger", counts.triggers);
  line("readouts that count", counts.good);
  line("readouts with numbers that do not count", counts.flagged);
  line("readouts without numbers", counts.withheld);
  line("numbers held against truth", counts.compared);
  line(fmt::format("  beyond {:.2f} sd, explained by a flag", soak_sigma_limit()), counts.explained);
  line("  dwells off by a period, images ambiguous", counts.mismatched);
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    if (counts.flags[i] == 0) continue;
    line(fmt::format("  readouts with {}, off with it", reduction::kFlagNames[i]),
         fmt::format("{}, {}", counts.flags[i], counts.explained_by[i]));
  }
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i)
    line(fmt::format("  largest z unexplained, {}", reduction::kQuantityNames[i]),
         fmt::format("{:.2f}", counts.largest_z[i]));
  for (std::size_t i = 0; i < counts.rig_faults.size(); ++i)
    line(fmt::format("exposures with {}", sim::kFaultNames[i]), counts.rig_faults[i]);
  for (std::size_t i = 0; i < kHazardCount; ++i)
    line(fmt::format("times {}", kHazardNames[i]), counts.hazards[i]);
  line("acts of persons, to fire", counts.acts);
  line("stops that reached the rig", counts.stops_reached);
  line("stops asked for at hosts", counts.stops_asked);
  line("  shown as confirmed", counts.stops_confirmed);
  line("  shown as not confirmed within a second", counts.stops_told_missing);
  line("trigger pulses between a stop and an act", counts.stopped_triggers);
  line("packets, times receivers", counts.packets);
  line("  lost, doubled, reordered",
       fmt::format("{}, {}, {}", counts.packets_lost, counts.packets_doubled, counts.packets_reordered));
  line("  sent by strangers", fmt::format("{}", counts.strangers));
  line("events journalled", counts.events_journalled);
  line("  missing on the hosts in the end", counts.events_missing);
  line("  of boots that ended before a host heard them", counts.events_never_received);
  line("events in the queue of a process that died", counts.events_lost_dying);
  line("violations", counts.violations);
  line("digest", fmt::format("{:016x}", counts.digest));
  return text;
}

}  // namespace strobe::soak
