// Which interrupts may run on a CPU, and how to move them to others. Set-up only, not real-time. Source: the
// kernel's Documentation/core-api/irq/irq-affinity.rst.
#pragma once

#include <string>
#include <vector>

#include "firmware/linux/system_files.hpp"

namespace strobe::firmware {

struct Interrupt {
  int number = 0;
  std::string name;     ///< of the devices that use it; may be empty
  std::set<int> cpus;   ///< on which it may run
  bool movable = true;  ///< false: the kernel manages it, e.g. one queue for each CPU
};

/// Every numbered interrupt with its CPUs; those of a CPU itself (timer ...) have no number.
std::vector<Interrupt> read_interrupts(const SystemFiles& files);

/// Whether an interrupt that is requested from now on may run on the CPU.
bool newcomers_may_run_on(int cpu, const SystemFiles& files);

struct InterruptMoves {
  std::vector<Interrupt> away;     ///< moved off the CPU
  std::vector<Interrupt> refused;  ///< not permitted, or there is no other CPU
  std::vector<Interrupt> fixed;
  bool newcomers_kept_off = true;  ///< those that are requested later
};
/// Removes the CPU from the list of every interrupt that may run there, and from that of interrupts to come.
/// Needs root; lasts until the machine is started anew.
InterruptMoves move_interrupts_off(int cpu, const SystemFiles& files);

}  // namespace strobe::firmware
