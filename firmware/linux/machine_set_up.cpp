#include "firmware/linux/machine_set_up.hpp"

#include <map>

#include "firmware/linux/interrupts.hpp"

namespace strobe::firmware {

std::string add_boot_options(const std::string& options, const SystemFiles& files) {
  const std::string raspberry_pi = "boot/firmware/cmdline.txt";
  if (files.read(raspberry_pi)) return "sed -i '1s/$/ " + options + "/' /" + raspberry_pi;
  return "mkdir -p /etc/default/grub.d && echo 'GRUB_CMDLINE_LINUX=\"$GRUB_CMDLINE_LINUX " + options +
         "\"' > /etc/default/grub.d/strobe.cfg && update-grub";
}

std::optional<std::string> install_rt_kernel(const SystemFiles& files) {
  const std::string machine = files.read("proc/sys/kernel/arch").value_or("");
  if (machine == "x86_64") return "apt install linux-image-rt-amd64";
  if (machine == "aarch64") return "apt install linux-image-rt-arm64";
  return std::nullopt;
}

std::string set_performance_governor(int cpu) {
  return "echo performance > /sys/devices/system/cpu/cpu" + std::to_string(cpu) + "/cpufreq/scaling_governor";
}

std::string set_real_time_runtime() {
  return "echo kernel.sched_rt_runtime_us=950000 > /etc/sysctl.d/60-strobe.conf && sysctl --system";
}

std::string allow_at_login(const std::string& limit) {
  return "echo '@gpio - " + limit + "' >> /etc/security/limits.d/strobe.conf";
}

int best_cpu(const SystemFiles& files) {
  std::map<int, int> fixed;  // by CPU
  for (const int cpu : parse_cpu_list(files.read("sys/devices/system/cpu/online").value_or("0")))
    fixed[cpu] = 0;
  for (const Interrupt& interrupt : read_interrupts(files)) {
    if (interrupt.movable) continue;
    for (const int cpu : interrupt.cpus)
      if (fixed.contains(cpu)) ++fixed[cpu];
  }
  int best = 0;
  int fewest = -1;
  for (const auto& [cpu, count] : fixed) {
    if (fewest >= 0 && count > fewest) continue;
    best = cpu;
    fewest = count;
  }
  return best;
}

}  // namespace strobe::firmware
