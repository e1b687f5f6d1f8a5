// Which interrupts may run on a CPU, and how to keep them off it. Set-up only, not real-time. What the kernel
// says of them: Documentation/core-api/irq/irq-affinity.rst.
#pragma once

#include <string>
#include <vector>

#include "firmware/linux/system_files.hpp"

namespace strobe::firmware {

struct Interrupt {
  int number = 0;
  std::string name;     ///< of the devices that use it; empty: none is told
  std::set<int> cpus;   ///< on which it may run
  bool movable = true;  ///< false: the kernel lets nobody move it (one queue for each CPU, say)
};

/// Every interrupt with a number and a list of CPUs. The timer's and the others of a CPU itself have none.
std::vector<Interrupt> read_interrupts(const SystemFiles& files);

struct InterruptMoves {
  std::vector<Interrupt> away;     ///< moved off the CPU
  std::vector<Interrupt> refused;  ///< movable, but not by this user, or there is no other CPU
  std::vector<Interrupt> fixed;
};
/// Takes the CPU out of the list of every interrupt that may run there. Needs root.
InterruptMoves move_interrupts_off(int cpu, const SystemFiles& files);

}  // namespace strobe::firmware
