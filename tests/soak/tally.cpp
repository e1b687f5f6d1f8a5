#include "tests/soak/tally.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tests/soak/judge.hpp"

namespace strobe::soak {

namespace {

template <std::size_t N>
void add_each(std::array<std::int64_t, N>& sum, const std::array<std::int64_t, N>& more) {
  for (std::size_t i = 0; i < N; ++i) sum[i] += more[i];
}

}  // namespace

void Tally::add(const Tally& other) {
  const auto sum = [&](std::int64_t Tally::*field) { this->*field += other.*field; };
  for (const auto field : {&Tally::campaigns,
                           &Tally::shots,
                           &Tally::planned,
                           &Tally::unfinished,
                           &Tally::triggers,
                           &Tally::boots,
                           &Tally::hosts,
                           &Tally::good,
                           &Tally::flagged,
                           &Tally::withheld,
                           &Tally::compared,
                           &Tally::explained,
                           &Tally::mismatched,
                           &Tally::packets,
                           &Tally::packets_lost,
                           &Tally::packets_doubled,
                           &Tally::packets_reordered,
                           &Tally::events_journalled,
                           &Tally::events_missing,
                           &Tally::events_unheard,
                           &Tally::events_lost_dying,
                           &Tally::violations}) {
    sum(field);
  }
  add_each(flags, other.flags);
  add_each(explained_by, other.explained_by);
  add_each(bench_faults, other.bench_faults);
  add_each(hazards, other.hazards);
  for (std::size_t i = 0; i < largest_z.size(); ++i)
    largest_z[i] = std::max(largest_z[i], other.largest_z[i]);
  virtual_s += other.virtual_s;
  digest += other.digest;
}

std::string table_of(const Tally& tally) {
  std::string text;
  const auto line = [&text](std::string_view what, const auto& value) {
    text += fmt::format("{:<44} {:>14}\n", what, value);
  };
  line("campaigns", tally.campaigns);
  line("shots fired", tally.shots);
  line("  of campaigns that wanted", tally.planned);
  line("campaigns that gave up", tally.unfinished);
  line("hours on the virtual clock", fmt::format("{:.1f}", tally.virtual_s / 3600.0));
  line("starts of the firmware, of hosts", fmt::format("{}, {}", tally.boots, tally.hosts));
  line("pulses of the machine's trigger", tally.triggers);
  line("readouts that count", tally.good);
  line("readouts with numbers that do not count", tally.flagged);
  line("readouts without numbers", tally.withheld);
  line("numbers held against truth", tally.compared);
  line(fmt::format("  beyond {:.2f} sd, explained by a flag", soak_limit()), tally.explained);
  line("  dwells off by a period, an image overlooked", tally.mismatched);
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    if (tally.flags[i] == 0) continue;
    line(fmt::format("  readouts with {}, off with it", reduction::kFlagNames[i]),
         fmt::format("{}, {}", tally.flags[i], tally.explained_by[i]));
  }
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i)
    line(fmt::format("  largest z unexplained, {}", reduction::kQuantityNames[i]),
         fmt::format("{:.2f}", tally.largest_z[i]));
  for (std::size_t i = 0; i < tally.bench_faults.size(); ++i)
    line(fmt::format("exposures struck by {}", sim::kFaultNames[i]), tally.bench_faults[i]);
  for (std::size_t i = 0; i < kHazardCount; ++i)
    line(fmt::format("times {}", kHazardNames[i]), tally.hazards[i]);
  line("packets, times receivers", tally.packets);
  line("  lost, doubled, reordered",
       fmt::format("{}, {}, {}", tally.packets_lost, tally.packets_doubled, tally.packets_reordered));
  line("events journalled", tally.events_journalled);
  line("  missing on the hosts in the end", tally.events_missing);
  line("  of boots that ended before a host heard them", tally.events_unheard);
  line("events in the queue of a process that died", tally.events_lost_dying);
  line("violations", tally.violations);
  line("digest", fmt::format("{:016x}", tally.digest));
  return text;
}

}  // namespace strobe::soak
