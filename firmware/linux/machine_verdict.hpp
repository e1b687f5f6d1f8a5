// What a trial of the machine (machine_trial.hpp) says in words: whether it can fire, who kept flashes
// waiting, and what to change. Set-up only, not real-time.
#pragma once

#include <string>
#include <vector>

#include "firmware/core/rig.hpp"
#include "firmware/linux/check_item.hpp"
#include "firmware/linux/machine_trial.hpp"
#include "firmware/linux/system_files.hpp"

namespace strobe::firmware {

/// Probability that a shot as the rig file plans it is aborted.
struct AbortRisk {
  double of_shot = 0.0;
  double of_shot_max = 0.0;  ///< 95 % upper limit
};
/// Aborts as a Poisson process over the time played: aborts / played; the limit for none seen is 3 / played
/// ("rule of three"), else aborts + 2 sqrt(aborts) + 2.
AbortRisk abort_risk(const Rig& rig, const MachineTrial& trial);

/// Counters of the kernel that tell of what no thread sees; -1 where it has none.
struct MachineCounters {
  long throttled = -1;   ///< by heat, times, of the loop's CPUs
  int pi_firmware = -1;  ///< a Raspberry Pi's get_throttled
  long frequency = -1;   ///< changes of the loop's CPUs
  long steal_ms = -1;    ///< that the hypervisor gave to others, of the loop's CPUs
  long smis = -1;        ///< since the trial began (SmiCounter); read_counters() does not know
};
MachineCounters read_counters(const std::set<int>& cpus, const SystemFiles& files);

/// Known-bad kernels by version.
CheckItem kernel_item(const SystemFiles& files);

/// heat, frequency, steal, smi, trial, culprits, machine: in this order, the verdict last.
std::vector<CheckItem> machine_verdict(const Rig& rig, const MachineTrial& trial,
                                       const MachineCounters& before, const MachineCounters& after,
                                       const SystemFiles& files);

}  // namespace strobe::firmware
