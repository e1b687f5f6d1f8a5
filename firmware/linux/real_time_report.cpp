#include "firmware/linux/real_time_report.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <optional>
#include <sstream>
#include <utility>

#include "firmware/core/cpu_budget.hpp"
#include "firmware/linux/interrupts.hpp"

namespace strobe::firmware {

namespace {

/// How far the kernel lets a real-time thread interrupt other programs' system calls, which bounds how late a
/// wake-up comes on a busy CPU.
enum class Preemption {
  none,       ///< a wake-up waits until a system call on its CPU returns or blocks
  voluntary,  ///< or reaches an explicit preemption point
  full,       ///< until locks are released and interrupt handlers end (also: lazy)
  real_time,  ///< PREEMPT_RT: those are preempted, too
  unknown     ///< cannot be read
};

struct PreemptionModel {
  Preemption model = Preemption::unknown;
  std::string source;       ///< the file it was read from
  bool switchable = false;  ///< by preempt=... on the kernel's command line, or by root at run time
};

std::optional<Preemption> by_name(const std::string& name) {
  if (name == "none") return Preemption::none;
  if (name == "voluntary") return Preemption::voluntary;
  if (name == "full" || name == "lazy") return Preemption::full;
  return std::nullopt;
}

bool has_word(const std::string& text, const std::string& word) {
  std::istringstream words(text);
  for (std::string each; words >> each;) {
    if (each == word) return true;
  }
  return false;
}

/// "none (voluntary) full": the one in brackets rules.
std::optional<Preemption> in_brackets(const std::string& models) {
  const std::size_t open = models.find('(');
  const std::size_t close = models.find(')', open);
  if (open == std::string::npos || close == std::string::npos) return std::nullopt;
  return by_name(models.substr(open + 1, close - open - 1));
}

/// Of several the last one counts.
std::optional<Preemption> on_command_line(const std::string& line) {
  const std::string key = "preempt=";
  std::optional<Preemption> chosen;
  std::istringstream words(line);
  for (std::string word; words >> word;) {
    if (word.compare(0, key.size(), key) != 0) continue;
    if (const auto model = by_name(word.substr(key.size()))) chosen = model;
  }
  return chosen;
}

std::optional<Preemption> in_configuration(const std::string& text) {
  constexpr std::array<std::pair<const char*, Preemption>, 4> kChoices{
      {{"CONFIG_PREEMPT_NONE=y", Preemption::none},
       {"CONFIG_PREEMPT_VOLUNTARY=y", Preemption::voluntary},
       {"CONFIG_PREEMPT=y", Preemption::full},
       {"CONFIG_PREEMPT_LAZY=y", Preemption::full}}};
  for (const auto& [option, model] : kChoices) {
    if (has_word(text, option)) return model;
  }
  return std::nullopt;
}

/// From /sys/kernel/realtime, the kernel's version, and for one built with PREEMPT_DYNAMIC: debugfs, the
/// command line, the kernel's configuration in /boot, in this order.
PreemptionModel read_preemption(const SystemFiles& files) {
  const std::string realtime = "sys/kernel/realtime";
  const std::string version = "proc/sys/kernel/version";
  const std::string flags = files.read(version).value_or("");
  if (files.read(realtime) == "1") return {Preemption::real_time, "/" + realtime, false};
  if (has_word(flags, "PREEMPT_RT")) return {Preemption::real_time, "/" + version, false};

  const std::string configuration = "boot/config-" + files.read("proc/sys/kernel/osrelease").value_or("");
  const bool dynamic = has_word(flags, "PREEMPT_DYNAMIC");
  if (dynamic) {
    const std::string debug = "sys/kernel/debug/sched/preempt";
    if (const auto model = in_brackets(files.read(debug).value_or(""))) return {*model, "/" + debug, true};
    const std::string line = "proc/cmdline";
    if (const auto model = on_command_line(files.read(line).value_or(""))) return {*model, "/" + line, true};
  } else if (has_word(flags, "PREEMPT")) {
    return {Preemption::full, "/" + version, false};
  }
  if (const auto model = in_configuration(files.read(configuration).value_or("")))
    return {*model, "/" + configuration, dynamic};
  return {Preemption::unknown, flags.empty() ? "" : "/" + version, dynamic};
}

/// Adds to the kernel's command line: where a Raspberry Pi's firmware reads it, else by GRUB. Good after a
/// reboot.
std::string add_boot_options(const std::string& options, const SystemFiles& files) {
  const std::string raspberry_pi = "boot/firmware/cmdline.txt";
  if (files.read(raspberry_pi)) return "sed -i '1s/$/ " + options + "/' /" + raspberry_pi;
  return "mkdir -p /etc/default/grub.d && echo 'GRUB_CMDLINE_LINUX=\"$GRUB_CMDLINE_LINUX " + options +
         "\"' > /etc/default/grub.d/strobe.cfg && update-grub";
}

/// Installs Debian's kernel with PREEMPT_RT; nullopt for a machine that has none.
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

/// Adds a limit to those that a login of the group gpio gets, e.g. "rtprio 99".
std::string allow_at_login(const std::string& limit) {
  return "echo '@gpio - " + limit + "' >> /etc/security/limits.d/strobe.conf";
}

/// The CPU to give to the loop: of those with the fewest interrupts that nobody can move, the last one.
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

using Verdict = CheckItem::Verdict;

const std::string kCpuFolder = "sys/devices/system/cpu/";

CheckItem ok(const char* name, std::string found) { return {name, Verdict::ok, std::move(found)}; }
CheckItem advice(const char* name, std::string words) { return {name, Verdict::advice, std::move(words)}; }
CheckItem tried(const char* name, const std::string& fault, std::string found,
                std::vector<std::string> paste = {}) {
  if (fault.empty()) return ok(name, std::move(found));
  return {name, Verdict::fault, fault, std::move(paste)};
}

CheckItem pinning(const Rig& rig, const RealTimeRights& trial, const SystemFiles& files) {
  const int cpu = rig.real_time.cpu;
  if (cpu >= 0) return tried("pinning", trial.pinning, "CPU " + std::to_string(cpu));
  const std::set<int> online = allowed_cpus(rig.real_time.cpu, files);
  if (online.size() < 2) {
    const std::string one = "there is one CPU only";
    if (rig.tolerance.wake_ahead <= rig.tolerance.spin) return ok("pinning", one);
    return advice("pinning", one +
                                 ": with [tolerance] wake_ahead_us above 0 journal and network wait until "
                                 "a train is over");
  }
  return advice("pinning", "the loop may run on any CPU: set [real_time] cpu, e.g. to " +
                               std::to_string(best_cpu(files)) + ", and keep other work off it");
}

CheckItem tick_item(const Tick& tick) {
  if (!tick.known()) return ok("tick", "none is seen on the loop's CPU");
  return ok("tick", "every " + std::to_string(tick.period / microseconds(1)) + " us for " +
                        std::to_string(tick.length / microseconds(1)) +
                        " us: shots start so that flashes fall between, where the period allows");
}

CheckItem governor(const Rig& rig, const SystemFiles& files) {
  std::set<int> slow;
  bool scaled = false;
  std::string name;
  for (const int cpu : allowed_cpus(rig.real_time.cpu, files)) {
    const auto chosen = files.read(kCpuFolder + "cpu" + std::to_string(cpu) + "/cpufreq/scaling_governor");
    if (!chosen) continue;
    scaled = true;
    if (*chosen == "performance") continue;
    slow.insert(cpu);
    name = *chosen;
  }
  if (!scaled) return ok("governor", "the CPU's frequency is not the kernel's to change");
  if (slow.empty()) return ok("governor", "performance");
  CheckItem item = advice("governor", "\"" + name + "\" slows CPU " + format_cpu_list(slow) +
                                          " down between flashes: cpupower -c " + format_cpu_list(slow) +
                                          " frequency-set -g performance");
  for (const int cpu : slow) item.paste.push_back(set_performance_governor(cpu));
  return item;
}

/// The largest share of time that the loop is awake: before every pulse, and through it.
double awake_share(const Rig& rig) {
  const Duration awake = std::max(rig.tolerance.spin, rig.tolerance.wake_ahead) + rig.lamps.pulse;
  const double wanted =
      static_cast<double>(awake.count()) / static_cast<double>(rig.lamps.min_period.count());
  return std::min(CpuBudget::kMaxShare, wanted);
}

CheckItem throttling(const Rig& rig, const SystemFiles& files) {
  const auto runtime = files.read("proc/sys/kernel/sched_rt_runtime_us");
  const auto period = files.read("proc/sys/kernel/sched_rt_period_us");
  if (!runtime || !period) return ok("throttling", "the kernel has none");
  const double runtime_us = std::atof(runtime->c_str());
  const double period_us = std::max(1.0, std::atof(period->c_str()));
  if (runtime_us < 0.0) return ok("throttling", "off");
  const int needed = static_cast<int>(std::min(100.0, 100.0 * awake_share(rig) + 2.0));
  const std::string allowed = *runtime + " of " + *period + " us";
  if (100.0 * runtime_us / period_us >= needed) {
    return ok("throttling", allowed + " allowed, at most " + std::to_string(needed) + " % needed");
  }
  return {"throttling",
          Verdict::fault,
          "real-time threads may run " + allowed + " only, " + std::to_string(needed) +
              " % are needed: sysctl kernel.sched_rt_runtime_us=950000 (of 1000000)",
          {set_real_time_runtime()}};
}

/// Whether RCU's callbacks are kept off the CPU; nohz_full does that, too.
bool without_callbacks(int cpu, const SystemFiles& files) {
  const std::string key = "rcu_nocbs=";
  std::istringstream words(files.read("proc/cmdline").value_or(""));
  for (std::string word; words >> word;)
    if (word.starts_with(key) && parse_cpu_list(word.substr(key.size())).contains(cpu)) return true;
  return false;
}

CheckItem isolation(const Rig& rig, const SystemFiles& files) {
  const int cpu = rig.real_time.cpu;
  if (cpu < 0) return advice("isolation", "no CPU is the loop's own: set [real_time] cpu first");
  const std::string number = std::to_string(cpu);
  std::string missing;
  if (!parse_cpu_list(files.read(kCpuFolder + "isolated").value_or("")).contains(cpu))
    missing += " isolcpus=" + number;
  if (!parse_cpu_list(files.read(kCpuFolder + "nohz_full").value_or("")).contains(cpu))
    missing += " nohz_full=" + number + (without_callbacks(cpu, files) ? "" : " rcu_nocbs=" + number);
  if (missing.empty()) return ok("isolation", "isolcpus and nohz_full hold CPU " + number);
  return {"isolation",
          Verdict::advice,
          "other work and the timer's tick run on CPU " + number + ", too; best booted with" + missing +
              " on the kernel's command line",
          {add_boot_options(missing.substr(1), files)}};
}

std::string named(const std::vector<Interrupt>& interrupts) {
  constexpr std::size_t kMaxNamed = 6;
  std::string text;
  for (std::size_t i = 0; i < std::min(kMaxNamed, interrupts.size()); ++i) {
    text += (i == 0 ? "" : ", ") + std::to_string(interrupts[i].number);
    if (!interrupts[i].name.empty()) text += " (" + interrupts[i].name + ")";
  }
  if (interrupts.size() > kMaxNamed)
    text += " and " + std::to_string(interrupts.size() - kMaxNamed) + " more";
  return text;
}

bool irqbalance_runs(const SystemFiles& files) {
  for (const std::string& entry : files.list("proc")) {
    if (std::atoi(entry.c_str()) > 0 && files.read("proc/" + entry + "/comm").value_or("") == "irqbalance")
      return true;
  }
  return false;
}

std::string another_cpu(int cpu, const SystemFiles& files) {
  const int best = best_cpu(files);
  return best == cpu ? "" : "take CPU " + std::to_string(best) + ", which has fewer, or ";
}

void interrupts(const Rig& rig, const SystemFiles& files, std::vector<CheckItem>& items) {
  const int cpu = rig.real_time.cpu;
  std::vector<Interrupt> movable;
  std::vector<Interrupt> fixed;
  for (Interrupt& interrupt : read_interrupts(files)) {
    if (cpu >= 0 && interrupt.cpus.contains(cpu)) (interrupt.movable ? movable : fixed).push_back(interrupt);
  }
  const std::string where = "CPU " + std::to_string(cpu);
  if (cpu < 0) {
    items.push_back(
        advice("interrupts", "none can be kept off a loop that runs anywhere: set [real_time] cpu first"));
    items.push_back(ok("fixed_interrupts", "not looked for"));
    return;
  }
  const std::vector<std::string> paste{"strobed --config " + rig.file_name + " --move-interrupts"};
  if (movable.empty() && !newcomers_may_run_on(cpu, files)) {
    items.push_back(ok("interrupts", "none that could be moved runs on " + where));
  } else if (movable.empty()) {
    items.push_back({"interrupts", Verdict::advice,
                     "those that are requested later may run on " + where +
                         ": as root, strobed --config RIG.toml --move-interrupts",
                     paste});
  } else {
    const std::string balancer =
        irqbalance_runs(files)
            ? "; irqbalance runs and brings them back: IRQBALANCE_BANNED_CPULIST=" + std::to_string(cpu)
            : "";
    items.push_back({"interrupts", Verdict::advice,
                     std::to_string(movable.size()) + " may run on " + where + ": " + named(movable) +
                         ": as root, strobed --config RIG.toml --move-interrupts" + balancer,
                     paste});
  }
  if (fixed.empty()) {
    items.push_back(ok("fixed_interrupts", "none on " + where));
  } else {
    items.push_back(advice("fixed_interrupts", "cannot be moved from " + where + ": " + named(fixed) + ": " +
                                                   another_cpu(cpu, files) + "leave their devices idle"));
  }
}

CheckItem clock_source(const SystemFiles& files) {
  const std::string folder = "sys/devices/system/clocksource/clocksource0/";
  const std::string current = files.read(folder + "current_clocksource").value_or("");
  if (current.empty()) return ok("clock_source", "the kernel does not say");
  constexpr std::array<const char*, 5> kSlow{"hpet", "acpi_pm", "jiffies", "pit", "refined-jiffies"};
  if (std::find(kSlow.begin(), kSlow.end(), current) == kSlow.end()) return ok("clock_source", current);
  return {"clock_source", Verdict::fault,
          "\"" + current + "\" takes a system call and microseconds to read: echo one of \"" +
              files.read(folder + "available_clocksource").value_or("") + "\" > /" + folder +
              "current_clocksource, or boot with tsc=reliable"};
}

std::string how_to_preempt(bool switchable) {
  return switchable
             ? "boot with preempt=full, or as root: echo full > /sys/kernel/debug/sched/preempt"
             : "boot a kernel with PREEMPT, better PREEMPT_RT (Debian: linux-image-rt-amd64 or -arm64)";
}

/// A thread that is awake need not be let in.
std::string until_then(const Rig& rig) {
  return rig.tolerance.wake_ahead > Duration{} ? "; until then the loop is awake before each flash of a train"
                                               : "; until then set [tolerance] wake_ahead_us";
}

CheckItem preemption(const Rig& rig, const SystemFiles& files) {
  const char* name = "preemption";
  const PreemptionModel found = read_preemption(files);
  const std::string cure = how_to_preempt(found.switchable) + until_then(rig);
  const std::string late = ", under memory or disk load for milliseconds: ";
  const auto better = [&](const std::string& words) {
    CheckItem item = advice(name, words);
    if (const auto line = install_rt_kernel(files)) item.paste.push_back(*line);
    return item;
  };
  switch (found.model) {
    case Preemption::real_time:
      return ok(name, "PREEMPT_RT: the loop interrupts nearly all that the kernel does");
    case Preemption::full:
      return ok(name, "full: the loop interrupts other programs' system calls, save where locks are held");
    case Preemption::voluntary:
      return better("voluntary: other programs' system calls give way at chosen places only" + late + cure);
    case Preemption::none:
      return better("none: the loop waits for the end of other programs' system calls" + late + cure);
    case Preemption::unknown:
      break;
  }
  if (found.switchable) {
    return better(
        "PREEMPT_DYNAMIC, whose model this user may not read: as root look into "
        "/sys/kernel/debug/sched/preempt; " +
        cure);
  }
  if (found.source.empty()) return ok(name, "the kernel does not say");
  return better("none or voluntary: the loop waits for other programs' system calls" + late + cure);
}

}  // namespace

std::vector<CheckItem> real_time_report(const Rig& rig, const RealTimeRights& trial, const Tick& tick,
                                        const SystemFiles& files) {
  std::vector<CheckItem> items{tried("policy", trial.policy, "SCHED_FIFO", {allow_at_login("rtprio 99")}),
                               tried("priority", trial.priority, std::to_string(rig.real_time.priority),
                                     {allow_at_login("rtprio 99")}),
                               tried("memory", trial.memory, "locked", {allow_at_login("memlock unlimited")}),
                               pinning(rig, trial, files),
                               trial.latency.empty() ? ok("latency", "/dev/cpu_dma_latency is held at 0")
                                                     : advice("latency", trial.latency),
                               tick_item(tick),
                               governor(rig, files),
                               throttling(rig, files),
                               isolation(rig, files),
                               preemption(rig, files)};
  interrupts(rig, files, items);
  items.push_back(clock_source(files));
  return items;
}

}  // namespace strobe::firmware
