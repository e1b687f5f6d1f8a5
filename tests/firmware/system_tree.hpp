// A tree of a machine's /proc and /sys in a folder of its own, of two CPUs: well set up until a test says
// else.
#pragma once

#include <filesystem>
#include <string>

#include "firmware/linux/system_files.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::testing {

class SystemTree {
 public:
  SystemTree() {
    put("sys/devices/system/cpu/online", "0-1");
    put("sys/devices/system/cpu/isolated", "1");
    put("sys/devices/system/cpu/nohz_full", "1");
    put("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc");
    put("proc/sys/kernel/sched_rt_runtime_us", "950000");
    put("proc/sys/kernel/sched_rt_period_us", "1000000");
    put("proc/sys/kernel/version", "#1 SMP PREEMPT_RT Debian 6.1.176-1 (2026-11-02)");
    put("proc/sys/kernel/osrelease", "6.1.0-50-amd64");
    interrupt(24, "ttyS0", "0");
  }
  void put(const std::string& path, const std::string& text) {
    std::filesystem::create_directories((folder_ / path).parent_path());
    write_text(folder_ / path, text + "\n");
  }
  void interrupt(int number, const std::string& device, const std::string& cpus) {
    const std::string folder = "proc/irq/" + std::to_string(number);
    std::filesystem::create_directories(folder_ / folder / device);
    put(folder + "/smp_affinity_list", cpus);
  }
  /// As the kernel shows one that it lets nobody move.
  void fixed_interrupt(int number, const std::string& device, const std::string& cpus) {
    interrupt(number, device, cpus);
    std::filesystem::permissions(folder_ / ("proc/irq/" + std::to_string(number) + "/smp_affinity_list"),
                                 std::filesystem::perms::owner_read);
  }
  /// A link to a folder of the tree, which is made if need be; `to` as seen from the link's own folder.
  void link(const std::string& path, const std::string& to) {
    const std::filesystem::path at = folder_ / path;
    std::filesystem::create_directories(at.parent_path());
    std::filesystem::create_directories(at.parent_path() / to);
    std::filesystem::create_directory_symlink(to, at);
  }
  firmware::SystemFiles files() const { return firmware::SystemFiles(folder_.path()); }

 private:
  TemporaryFolder folder_;
};

}  // namespace strobe::testing
