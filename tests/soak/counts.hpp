// Counts of a soak. Trivially copyable, so that processes can pass it through a pipe.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <type_traits>

#include "common/reduction/readout.hpp"
#include "tests/soak/fault_plan.hpp"

namespace strobe::soak {

struct SoakCounts {
  std::int64_t runs = 0;
  std::int64_t shots = 0;       ///< fired: their summaries were published
  std::int64_t planned = 0;     ///< shots that were to count
  std::int64_t unfinished = 0;  ///< runs that gave up: no retries left, or the firmware not ready
  std::int64_t triggers = 0, boots = 0, hosts = 0;
  std::int64_t good = 0;        ///< readouts that count
  std::int64_t flagged = 0;     ///< readouts with numbers that do not count
  std::int64_t withheld = 0;    ///< readouts without any number
  std::int64_t compared = 0;    ///< numbers held against truth
  std::int64_t mismatched = 0;  ///< dwells beyond it, an image having been overlooked or doubled
  std::int64_t explained = 0;   ///< numbers beyond the limit that a flag explains
  std::array<std::int64_t, reduction::kFlagCount> flags{};         ///< readouts that carry each
  std::array<std::int64_t, reduction::kFlagCount> explained_by{};  ///< readouts in which it explained some
  std::array<double, reduction::kQuantityCount> largest_z{};       ///< of numbers that no flag explains
  std::array<std::int64_t, sim::kFaultNames.size()> rig_faults{};  ///< exposures that each struck
  std::array<std::int64_t, kHazardCount> hazards{};
  std::int64_t packets = 0, packets_lost = 0, packets_doubled = 0, packets_reordered = 0;
  std::int64_t strangers = 0;           ///< packets that strangers sent
  std::int64_t acts = 0;                ///< of persons, who gave the command to fire
  std::int64_t stops_reached = 0;       ///< of the drawn ones
  std::int64_t stops_asked = 0;         ///< at hosts
  std::int64_t stops_confirmed = 0;     ///< shown as confirmed there
  std::int64_t stops_told_missing = 0;  ///< shown as not confirmed there within a second
  std::int64_t stopped_triggers = 0;    ///< pulses between a stop and the next act
  std::int64_t events_journalled = 0;
  std::int64_t events_missing = 0;         ///< journalled and on no host in the end
  std::int64_t events_never_received = 0;  ///< of boots that ended before any host heard of them
  std::int64_t events_lost_dying = 0;      ///< in the queue of a process that died: never journalled
  std::int64_t violations = 0;
  double virtual_s = 0.0;
  std::uint64_t digest = 0;  ///< of the outputs' changes and the readouts; a sum over the runs

  void add(const SoakCounts& other);
};
static_assert(std::is_trivially_copyable_v<SoakCounts>);

/// Lines of text for a person.
std::string table_of(const SoakCounts& counts);

}  // namespace strobe::soak
