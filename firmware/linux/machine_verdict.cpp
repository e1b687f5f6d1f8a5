#include "firmware/linux/machine_verdict.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <sstream>

namespace strobe::firmware {

namespace {

struct BadKernel {
  const char* series;
  int first;  ///< of the series
  int last;
  bool real_time_only;
  const char* reason;
};

// 6.12: linux-rt-users, May 2026: cyclictest 51,966 us under load at 6.12.87, 57 to 81 us with the commit
// reverted, as told; the thread itself could not be read, and no release that says it has the fix was found.
constexpr std::array kBadKernels{BadKernel{
    "6.12", 85, INT32_MAX, true,
    "PREEMPT_RT is delayed by up to 52 ms under load since 6.12.85, until a release says otherwise: "
    "boot 6.12.84 or earlier, or another series"}};

/// "6.12.87" of "6.12.87+deb13-rt-amd64" or, as Debian 12 writes it, of "#1 SMP ... Debian 6.1.176-1 (...)".
std::string kernel_version(const SystemFiles& files) {
  const std::string flags = files.read("proc/sys/kernel/version").value_or("");
  const std::string release = files.read("proc/sys/kernel/osrelease").value_or("");
  const std::string before = "Debian ";
  const std::size_t debian = flags.find(before);
  const std::string text = debian == std::string::npos ? release : flags.substr(debian + before.size());
  return text.substr(0, text.find_first_not_of("0123456789."));
}

bool is_bad(const BadKernel& bad, const std::string& version, bool real_time) {
  const std::string series = std::string(bad.series) + ".";
  if (!version.starts_with(series) || (bad.real_time_only && !real_time)) return false;
  const int patch = std::atoi(version.c_str() + series.size());
  return patch >= bad.first && patch <= bad.last;
}

CheckItem well(const char* name, std::string found) {
  return {name, CheckItem::Verdict::ok, std::move(found)};
}
CheckItem warn(const char* name, std::string words) {
  return {name, CheckItem::Verdict::advice, std::move(words)};
}

/// Adds the number in a file; -1 stays where no file has one.
void add_count(long& sum, const std::optional<std::string>& text, int base = 10) {
  if (text) sum = std::max(0L, sum) + std::strtol(text->c_str(), nullptr, base);
}

/// The eighth number of "cpu1 ...": hundredths of a second (proc(5), USER_HZ).
std::optional<std::string> stolen(int cpu, const SystemFiles& files) {
  std::istringstream lines(files.read("proc/stat").value_or(""));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word != "cpu" + std::to_string(cpu)) continue;
    for (int i = 0; i < 8 && words >> word;) ++i;
    return words ? std::optional(word) : std::nullopt;
  }
  return std::nullopt;
}

CheckItem heat_item(const MachineCounters& before, const MachineCounters& after) {
  constexpr int kNow = 0xf;  // under-voltage, capped, throttled, soft limit: RPI_FIRMWARE_GET_THROTTLED
  if (after.pi_firmware > 0 && (after.pi_firmware & kNow) != 0) {
    const bool volts = (after.pi_firmware & 1) != 0;
    return warn("heat", volts ? "the board's supply is too weak (under-voltage), which slows the processor: "
                                "take a stronger one"
                              : "the board is too hot and slows its processor: cool it");
  }
  if (after.throttled > before.throttled)
    return warn("heat", "the processor was too hot and slowed down " +
                            std::to_string(after.throttled - std::max(0L, before.throttled)) +
                            " times: cool it");
  return well("heat",
              after.throttled < 0 && after.pi_firmware < 0 ? "the kernel does not say" : "cool enough");
}

CheckItem frequency_item(const MachineCounters& before, const MachineCounters& after) {
  if (after.frequency < 0) return well("frequency", "the kernel does not say");
  if (after.frequency == before.frequency) return well("frequency", "constant");
  return warn("frequency",
              "changed " + std::to_string(after.frequency - before.frequency) + " times: see governor");
}

CheckItem steal_item(const MachineCounters& before, const MachineCounters& after) {
  const long lost_ms = after.steal_ms - before.steal_ms;
  if (lost_ms <= 0) return well("steal", "none");
  return warn("steal", "the hypervisor gave " + std::to_string(lost_ms) +
                           " ms of the loop's CPU to others: take a real machine");
}

constexpr const char* kQuietFirmware = "switch off power saving and USB legacy support in its setup (BIOS)";

CheckItem smi_item(long smis) {
  if (smis < 0) return well("smi", "the kernel does not say");
  if (smis == 0) return well("smi", "none");
  return warn("smi", "the board's own firmware had the loop's CPU " + std::to_string(smis) +
                         " times: " + kQuietFirmware);
}

/// "12.3 us", "45 ms".
std::string span(Duration d) {
  char text[32];
  const double us = to_microseconds(d);
  if (us < 10'000.0) {
    std::snprintf(text, sizeof text, us < 100.0 ? "%.2f us" : "%.0f us", us);
  } else {
    std::snprintf(text, sizeof text, "%.0f ms", us * 1e-3);
  }
  return text;
}

/// Of sorted times, 0 < share <= 1.
Duration percentile(const std::vector<Duration>& sorted, double share) {
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[std::max<std::size_t>(1, rank) - 1];
}

std::size_t later_than(const std::vector<TrialFlash>& flashes, Duration limit) {
  return static_cast<std::size_t>(std::count_if(
      flashes.begin(), flashes.end(), [&](const TrialFlash& flash) { return flash.lateness() > limit; }));
}

CheckItem trial_item(const Rig& rig, const MachineTrial& trial) {
  std::vector<Duration> sorted;
  for (const TrialFlash& flash : trial.flashes) sorted.push_back(flash.lateness());
  if (sorted.empty()) return warn("trial", "the thread had no CPU at all");
  std::sort(sorted.begin(), sorted.end());
  const std::size_t late = later_than(trial.flashes, rig.tolerance.late);
  const std::string words =
      std::to_string(sorted.size()) + " flashes every " + span(rig.lamps.min_period) + ": p50 " +
      span(percentile(sorted, 0.5)) + ", p99 " + span(percentile(sorted, 0.99)) + ", at most " +
      span(sorted.back()) + " late; " + std::to_string(late) + " later than late_us, " +
      std::to_string(later_than(trial.flashes, rig.tolerance.abort_late)) + " than abort_late_us";
  return late == 0 ? well("trial", words) : warn("trial", words);
}

/// All that one of them did.
struct Sum {
  Culprit culprit;
  int times = 0;
  int aborts = 0;
  Duration longest{};
};

/// Who aborted most comes first, then who took longest.
std::vector<Sum> sums_of(const Rig& rig, const std::vector<LateFlash>& late) {
  std::map<std::pair<Culprit::Kind, std::string>, Sum> by_name;
  for (const LateFlash& each : late) {
    Sum& sum = by_name[{each.culprit.kind, each.culprit.name}];
    sum.culprit = each.culprit;
    ++sum.times;
    if (each.flash.lateness() > rig.tolerance.abort_late) ++sum.aborts;
    sum.longest = std::max(sum.longest, each.culprit.took);
  }
  std::vector<Sum> sums;
  for (const auto& [name, sum] : by_name) sums.push_back(sum);
  std::sort(sums.begin(), sums.end(), [](const Sum& a, const Sum& b) {
    return std::pair(a.aborts, a.longest) > std::pair(b.aborts, b.longest);
  });
  for (Sum& sum : sums) sum.culprit.took = sum.longest;
  return sums;
}

std::string longest(const Sum& sum) {
  return in_words(sum.culprit) +
         (sum.times == 1 ? "" : " (the longest of " + std::to_string(sum.times) + " times)");
}

std::string pid_of(const std::string& name) {
  const std::string before = "(pid ";
  const std::size_t at = name.rfind(before);
  if (at == std::string::npos) return "";
  return name.substr(at + before.size(), name.find(')', at) - at - before.size());
}

/// Its real-time priority: the 40th number of its stat (proc(5)), the name in brackets being the second.
int real_time_priority(const std::string& pid, const SystemFiles& files) {
  const std::string stat = files.read("proc/" + pid + "/stat").value_or("");
  std::istringstream words(stat.substr(std::min(stat.size(), stat.rfind(')') + 1)));
  std::string word;
  for (int i = 3; i <= 40; ++i)
    if (!(words >> word)) return 0;
  return std::atoi(word.c_str());
}

bool is_kernel_thread(const std::string& name) {
  constexpr std::array kNames{"kworker/",  "ksoftirqd/", "migration/", "rcu",      "kswapd",
                              "kcompactd", "irq/",       "cpuhp/",     "ktimers/", "khugepaged"};
  return std::any_of(kNames.begin(), kNames.end(), [&](const char* each) { return name.starts_with(each); });
}

struct Cure {
  std::string words;
  std::vector<std::string> paste = {};
};

/// Longer than the kernel keeps a real-time thread waiting for a system call: only its throttling does.
constexpr Duration kHeldBack = milliseconds(20);
constexpr const char* kHeldBackWords =
    "the kernel held real-time threads back: see throttling, and cpu.rt_runtime_us of this control group";

Cure cure_of_thread(const Rig& rig, const Culprit& culprit, const SystemFiles& files) {
  const std::string& name = culprit.name;
  if (name.starts_with("irq/")) return {"see interrupts"};
  const std::string pid = pid_of(name);
  const int priority = real_time_priority(pid, files);
  if (priority == 0 && files.is_folder("proc/" + pid) && culprit.took >= kHeldBack) return {kHeldBackWords};
  if (is_kernel_thread(name)) return {"keep the kernel's own work off the CPU: see isolation"};
  const std::string loop = "[real_time] priority (" + std::to_string(rig.real_time.priority) + ")";
  if (priority >= rig.real_time.priority)
    return {"its real-time priority, " + std::to_string(priority) + ", is not below " + loop + ": lower it",
            {"chrt -a -f -p 1 " + pid}};
  return {"end it, give it a priority below " + loop + " or keep it off the loop's CPU (taskset)"};
}

Cure cure_of(const Rig& rig, const Culprit& culprit, const SystemFiles& files) {
  switch (culprit.kind) {
    case Culprit::Kind::thread:
      return cure_of_thread(rig, culprit, files);
    case Culprit::Kind::interrupt:
      return {"see interrupts, and strobed --move-interrupts"};
    case Culprit::Kind::softirq:
      return {"see isolation and interrupts"};
    case Culprit::Kind::page_fault:
      return {"see memory"};
    case Culprit::Kind::waited:
      if (culprit.took < kHeldBack) return {"see latency and preemption"};
      return {std::string(kHeldBackWords) + "; or the machine stood still meanwhile"};
    case Culprit::Kind::core_stopped: {
      const std::string traced = "sys/kernel/tracing/events/irq/irq_handler_entry/id";
      if (!files.read(traced) && !files.read("sys/kernel/debug/" + traced.substr(11)))
        return {
            "an interrupt, or the board's firmware, and this user is not shown which: as root, with "
            "tracefs mounted, look again",
            {"mount -t tracefs none /sys/kernel/tracing"}};
      const bool virtual_machine =
          files.read("proc/cpuinfo").value_or("").find(" hypervisor") != std::string::npos;
      return {virtual_machine ? "the hypervisor gave the CPU to others: take a real machine"
                              : std::string("the board's own firmware had it (SMI): ") + kQuietFirmware};
    }
    case Culprit::Kind::unknown:
      break;
  }
  return {"see what else this list advises"};
}

CheckItem culprits_item(const Rig& rig, const MachineTrial& trial, const std::vector<Sum>& sums,
                        const SystemFiles& files) {
  const char* name = "culprits";
  if (!trial.not_named.empty()) return warn(name, "late flashes have no names: " + trial.not_named);
  if (sums.empty()) return well(name, "none");
  constexpr std::size_t kMaxNamed = 3;
  CheckItem item = warn(name, "");
  for (std::size_t i = 0; i < std::min(kMaxNamed, sums.size()); ++i) {
    const Cure cure = cure_of(rig, sums[i].culprit, files);
    item.words += (i == 0 ? "" : "; ") + longest(sums[i]) + ": " + cure.words;
    item.paste.insert(item.paste.end(), cure.paste.begin(), cure.paste.end());
  }
  return item;
}

std::string of_hundred(double share) { return std::to_string(std::max(1L, std::lround(100.0 * share))); }

CheckItem verdict_item(const Rig& rig, const MachineTrial& trial, const std::vector<Sum>& sums,
                       const SystemFiles& files) {
  const AbortRisk risk = abort_risk(rig, trial);
  const std::string rights = trial.not_granted.empty() ? "" : " (tried without all real-time rights)";
  std::string words;
  CheckItem item = well("machine", "");
  if (risk.of_shot == 0.0) {
    const bool late = later_than(trial.flashes, rig.tolerance.late) > 0;
    item.words = "this machine can fire" + rights + ": " +
                 (late ? "some flashes would be late, but no shot aborted" : "no flash would be late") +
                 " (95 %: of 100 shots fewer than " + of_hundred(risk.of_shot_max) +
                 " aborted; longer --seconds tell more)";
    return item;
  }
  const bool never = trial.starved || risk.of_shot >= 0.5;
  std::string why;
  for (std::size_t i = 0; trial.not_named.empty() && i < std::min<std::size_t>(2, sums.size()); ++i)
    if (sums[i].aborts > 0)
      why += (i == 0 ? "" : "; ") + longest(sums[i]) + ": " + cure_of(rig, sums[i].culprit, files).words;
  if (why.empty()) why = "see above";
  item.verdict = never ? CheckItem::Verdict::fault : CheckItem::Verdict::advice;
  item.words = (never ? "this machine cannot fire" : "this machine can fire") + rights + ", " +
               (never ? "" : "but ") + (trial.starved ? "all" : "some " + of_hundred(risk.of_shot)) +
               (trial.starved ? "" : " of 100") + " shots would be aborted: " + why;
  return item;
}

}  // namespace

AbortRisk abort_risk(const Rig& rig, const MachineTrial& trial) {
  const auto aborts = static_cast<double>(later_than(trial.flashes, rig.tolerance.abort_late));
  if (trial.starved) return {1.0, 1.0};
  const double played_s = std::max(1e-9, to_seconds(trial.played));
  const double shot_s = to_seconds(length_of_shot(rig));
  const double most = aborts == 0.0 ? 3.0 : aborts + 2.0 * std::sqrt(aborts) + 2.0;
  return {-std::expm1(-aborts / played_s * shot_s), -std::expm1(-most / played_s * shot_s)};
}

MachineCounters read_counters(const std::set<int>& cpus, const SystemFiles& files) {
  MachineCounters counters;
  const std::string folder = "sys/devices/system/cpu/cpu";
  for (const int cpu : cpus) {
    const std::string own = folder + std::to_string(cpu);
    for (const char* kind :
         {"/thermal_throttle/core_throttle_count", "/thermal_throttle/package_throttle_count"})
      add_count(counters.throttled, files.read(own + kind));
    add_count(counters.frequency, files.read(own + "/cpufreq/stats/total_trans"));
    add_count(counters.steal_ms, stolen(cpu, files));
  }
  if (counters.steal_ms > 0) counters.steal_ms *= 10;
  long pi = -1;
  add_count(pi, files.read("sys/devices/platform/soc/soc:firmware/get_throttled"), 16);
  counters.pi_firmware = static_cast<int>(pi);
  return counters;
}

CheckItem kernel_item(const SystemFiles& files) {
  const std::string version = kernel_version(files);
  const bool real_time =
      files.read("sys/kernel/realtime") == "1" ||
      files.read("proc/sys/kernel/version").value_or("").find("PREEMPT_RT") != std::string::npos;
  for (const BadKernel& bad : kBadKernels)
    if (is_bad(bad, version, real_time)) return warn("kernel", version + ": " + bad.reason);
  return well("kernel", version + ", nothing is known against it");
}

std::vector<CheckItem> machine_verdict(const Rig& rig, const MachineTrial& trial,
                                       const MachineCounters& before, const MachineCounters& after,
                                       const SystemFiles& files) {
  const std::vector<Sum> sums = sums_of(rig, trial.late);
  return {heat_item(before, after),
          frequency_item(before, after),
          steal_item(before, after),
          smi_item(after.smis),
          trial_item(rig, trial),
          culprits_item(rig, trial, sums, files),
          verdict_item(rig, trial, sums, files)};
}

}  // namespace strobe::firmware
