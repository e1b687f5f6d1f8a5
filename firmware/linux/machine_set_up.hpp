// Lines for root's shell that set a machine up for real time, as it is found. Set-up only, not real-time.
#pragma once

#include <optional>
#include <set>
#include <string>

#include "firmware/linux/system_files.hpp"

namespace strobe::firmware {

/// Adds to the kernel's command line: where a Raspberry Pi's firmware reads it, else by GRUB. Good after a reboot.
std::string add_boot_options(const std::string& options, const SystemFiles& files);

/// Installs Debian's kernel with PREEMPT_RT; nullopt for a machine that has none.
std::optional<std::string> install_rt_kernel(const SystemFiles& files);

std::string set_performance_governor(int cpu);
std::string set_real_time_runtime();

/// Adds a limit to those that a login of the group gpio gets, e.g. "rtprio 99".
std::string allow_at_login(const std::string& limit);

/// The CPU to give to the loop: of those with the fewest interrupts that nobody can move, the last one.
int best_cpu(const SystemFiles& files);

}  // namespace strobe::firmware
