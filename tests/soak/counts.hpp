// Counts of a soak. Trivially copyable, so that processes can pass it through a pipe.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <type_traits>

#include "common/reduction/readout.hpp"
#include "tests/soak/lab_setup.hpp"

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
  std::array<std::int64_t, kRigFaultCount> rig_faults{};  ///< exposures that each struck
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

// Compares a readout with the truth: whether an error is larger than its stated uncertainty allows, and
// whether a flag says so. Pure; thread-safe.

/// The limit in standard deviations that by chance `false_alarms` of `comparisons` normal errors exceed.
double sigma_limit(double comparisons, double false_alarms);

/// 16 numbers a shot, a million shots, one false alarm in a thousand such runs: 6.6 sd.
double soak_sigma_limit();

/// Whether the flag says that numbers may be wrong beyond their stated uncertainty:
///  - flags of a shot that does not count and is fired again do, and sensor_missing, since a flash's time is
///    then that of one lamp, or of none;
///  - spin_aliased, surface_suspect, scale_contradicts_ball and residuals_exceed_noise do: every number of the shot;
///  - the other flags (an image or a surface point left out, few images, sds from residuals) excuse no wrong number.
bool explains(reduction::Flag flag);

struct TruthComparison {
  int compared = 0;
  double largest_z = 0.0;                             ///< of the numbers that no flag explains
  std::array<double, reduction::kQuantityCount> z{};  ///< 0: not compared
  /// Numbers beyond the limit.
  int explained = 0;
  int mismatched = 0;  ///< dwell times and distances where the images are ambiguous, see Truth
  std::array<bool, reduction::kFlagCount> by_flag{};  ///< explained at least one of them
  std::string wrong;                                  ///< the others, as text; empty if none
};

/// True values of a shot.
struct Truth {
  reduction::Quantities value;
  /// The photograph lacks an image of a flash that was seen, or has one too many, or a flash's time or sensor
  /// was disturbed. Next to the contact the host then takes one match for another once in a while, as its
  /// stated odds say (common/reduction/matching/flash_match.hpp): the dwell time is off by a period. Such numbers are
  /// counted apart.
  bool images_ambiguous = false;
};

/// A number that the truth lacks (all of them without a ball) is wrong if stated, unless a flag explains it.
TruthComparison compare_with_truth(const reduction::Readout& readout, const Truth& truth, double limit);

}  // namespace strobe::soak
