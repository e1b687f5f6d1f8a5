#include "firmware/linux/real_time_report.hpp"

#include <algorithm>

#include "firmware/flash_sequencer/inspect.hpp"
#include "tests/firmware/system_tree.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::firmware;
using Verdict = CheckItem::Verdict;

TEST_GROUP(RealTimeReport) {
  strobe::testing::SystemTree tree;
  Rig rig;
  RealTimeRights trial;
  Tick tick;

  void setup() override {
    rig.real_time.cpu = 1;
    rig.file_name = "bench.toml";
  }

  CheckItem item(const std::string& name) const {
    const auto items = real_time_report(rig, trial, tick, tree.files());
    const auto at =
        std::find_if(items.begin(), items.end(), [&](const CheckItem& i) { return i.name == name; });
    CHECK_TEXT(at != items.end(), name.c_str());
    return *at;
  }
  void pastes(const std::string& name, const std::string& line) const {
    const CheckItem found = item(name);
    CHECK_EQUAL(1U, found.paste.size());
    CHECK_EQUAL(line, found.paste[0]);
  }
  void says(const std::string& name, Verdict verdict, const std::string& part) const {
    const CheckItem found = item(name);
    CHECK_TEXT(found.verdict == verdict, (name + ": " + found.words).c_str());
    CHECK_TEXT(found.words.find(part) != std::string::npos, found.words.c_str());
    CHECK_TEXT(found.words.find('\n') == std::string::npos, "one line");
  }
};

TEST(RealTimeReport, FindsNothingToDoOnAMachineThatIsWellSetUp) {
  const auto items = real_time_report(rig, trial, tick, tree.files());
  CHECK_EQUAL(13U, items.size());
  for (const CheckItem& each : items)
    CHECK_TEXT(each.verdict == Verdict::ok, (each.name + ": " + each.words).c_str());
}

TEST(RealTimeReport, PassesOnWhatTheTrialOfEachRightFound) {
  trial = {"no FIFO", "no 80", "no lock", "no CPU", "no latency"};
  says("policy", Verdict::fault, "no FIFO");
  says("priority", Verdict::fault, "no 80");
  says("memory", Verdict::fault, "no lock");
  says("pinning", Verdict::fault, "no CPU");
  says("latency", Verdict::advice, "no latency");
}

TEST(RealTimeReport, AdvisesACpuForALoopThatMayRunAnywhere) {
  rig.real_time.cpu = -1;
  says("pinning", Verdict::advice, "set [real_time] cpu, e.g. to 1");
  says("isolation", Verdict::advice, "set [real_time] cpu");
  says("interrupts", Verdict::advice, "set [real_time] cpu");
  tree.put("sys/devices/system/cpu/online", "0");
  says("pinning", Verdict::advice, "journal and network wait");
  rig.tolerance.wake_ahead = {};
  says("pinning", Verdict::ok, "one CPU");
}

TEST(RealTimeReport, TellsOfTheTickIfThereIsOne) {
  says("tick", Verdict::ok, "none");
  tick = {strobe::milliseconds(4), {}, strobe::microseconds(20)};
  says("tick", Verdict::ok, "every 4000 us for 20 us");
}

TEST(RealTimeReport, WantsTheGovernorOfTheLoopsCpuToBePerformance) {
  tree.put("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "ondemand");
  tree.put("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "performance");
  says("governor", Verdict::ok, "performance");
  tree.put("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave");
  says("governor", Verdict::advice, "cpupower -c 1 frequency-set -g performance");
}

TEST(RealTimeReport, ThrottlingMustLeaveTheTimeThatTheLoopIsAwake) {
  says("throttling", Verdict::ok, "950000 of 1000000 us");
  tree.put("proc/sys/kernel/sched_rt_runtime_us", "-1");
  says("throttling", Verdict::ok, "off");
  tree.put("proc/sys/kernel/sched_rt_runtime_us",
           "100000");  // awake for at most 93 % of a second, and others
  says("throttling", Verdict::fault, "95 % are needed");
  tree.put("proc/sys/kernel/sched_rt_runtime_us", "0");
  says("throttling", Verdict::fault, "sched_rt_runtime_us");
}

TEST(RealTimeReport, NamesWhatTheKernelsCommandLineLacks) {
  tree.put("sys/devices/system/cpu/nohz_full", "(null)");
  says("isolation", Verdict::advice, "nohz_full=1");
  CHECK_EQUAL(std::string::npos, item("isolation").words.find("isolcpus=1"));
  tree.put("sys/devices/system/cpu/isolated", "");
  says("isolation", Verdict::advice, "isolcpus=1 nohz_full=1");
}

TEST(RealTimeReport, GivesTheCommandLineToPasteAsThisMachineBoots) {
  tree.put("sys/devices/system/cpu/isolated", "");
  tree.put("sys/devices/system/cpu/nohz_full", "");
  const std::string options = "isolcpus=1 nohz_full=1 rcu_nocbs=1";
  says("isolation", Verdict::advice, options);
  pastes("isolation", "mkdir -p /etc/default/grub.d && echo 'GRUB_CMDLINE_LINUX=\"$GRUB_CMDLINE_LINUX " +
                          options + "\"' > /etc/default/grub.d/strobe.cfg && update-grub");
  tree.put("boot/firmware/cmdline.txt", "console=tty1 rootwait");
  pastes("isolation", "sed -i '1s/$/ " + options + "/' /boot/firmware/cmdline.txt");
  tree.put("proc/cmdline", "quiet rcu_nocbs=0-1");
  pastes("isolation", "sed -i '1s/$/ isolcpus=1 nohz_full=1/' /boot/firmware/cmdline.txt");
}

TEST(RealTimeReport, GivesWhatElseCanBePasted) {
  trial = {"no FIFO", "no 80", "no lock", "", ""};
  pastes("policy", "echo '@gpio - rtprio 99' >> /etc/security/limits.d/strobe.conf");
  pastes("memory", "echo '@gpio - memlock unlimited' >> /etc/security/limits.d/strobe.conf");
  tree.put("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "ondemand");
  pastes("governor", "echo performance > /sys/devices/system/cpu/cpu1/cpufreq/scaling_governor");
  tree.put("proc/sys/kernel/sched_rt_runtime_us", "100000");
  pastes("throttling",
         "echo kernel.sched_rt_runtime_us=950000 > /etc/sysctl.d/60-strobe.conf && sysctl --system");
  tree.put("proc/sys/kernel/version", "#1 SMP Debian 6.12.57-1 (2026-11-02)");
  CHECK_TRUE(item("preemption").paste.empty());  // of a machine without such a kernel
  tree.put("proc/sys/kernel/arch", "aarch64");
  pastes("preemption", "apt install linux-image-rt-arm64");
  tree.put("proc/sys/kernel/arch", "x86_64");
  pastes("preemption", "apt install linux-image-rt-amd64");
}

TEST(RealTimeReport, NamesTheCpuWithTheFewestInterruptsThatNobodyCanMove) {
  tree.put("sys/devices/system/cpu/online", "0-3");
  rig.real_time.cpu = -1;
  says("pinning", Verdict::advice, "e.g. to 3");
  tree.fixed_interrupt(36, "queue.3", "3");
  says("pinning", Verdict::advice, "e.g. to 2");
  rig.real_time.cpu = 3;
  says("fixed_interrupts", Verdict::advice, "take CPU 2, which has fewer, or leave");
}

TEST(RealTimeReport, TellsThatInterruptsToComeMayRunOnTheLoopsCpu) {
  tree.put("proc/irq/default_smp_affinity", "3");
  says("interrupts", Verdict::advice, "requested later may run on CPU 1");
  pastes("interrupts", "strobed --config bench.toml --move-interrupts");
  tree.put("proc/irq/default_smp_affinity", "1");
  says("interrupts", Verdict::ok, "");
}

TEST(RealTimeReport, NamesInterruptsThatMayRunOnTheLoopsCpu) {
  tree.interrupt(25, "net", "0-1");
  says("interrupts", Verdict::advice, "1 may run on CPU 1: 25 (net)");
  says("fixed_interrupts", Verdict::ok, "");
}

TEST(RealTimeReport, TellsThoseThatNobodyCanMoveApart) {
  tree.fixed_interrupt(36, "virtio1-req.0", "0-1");
  says("interrupts", Verdict::ok, "CPU 1");
  says("fixed_interrupts", Verdict::advice, "36 (virtio1-req.0)");
}

TEST(RealTimeReport, NamesAFewOfManyInterrupts) {
  for (int number = 30; number < 50; ++number) tree.interrupt(number, "net", "1");
  says("interrupts", Verdict::advice, "20 may run on CPU 1");
  says("interrupts", Verdict::advice, "and 14 more");
}

TEST(RealTimeReport, WarnsOfADaemonThatBringsInterruptsBack) {
  tree.interrupt(25, "net", "0-1");
  tree.put("proc/77/comm", "irqbalance");
  says("interrupts", Verdict::advice, "IRQBALANCE_BANNED_CPULIST=1");
}

TEST(RealTimeReport, TellsHowFarTheKernelGivesWayToTheLoop) {
  says("preemption", Verdict::ok, "PREEMPT_RT");
  tree.put("proc/sys/kernel/version", "#1 SMP PREEMPT Debian 6.1.176-1 (2026-11-02)");
  says("preemption", Verdict::ok, "full");
  tree.put("proc/sys/kernel/version", "#1 SMP Debian 6.1.176-1 (2026-11-02)");
  says("preemption", Verdict::advice, "none or voluntary");
  says("preemption", Verdict::advice, "until then the loop is awake");
  says("preemption", Verdict::advice, "a kernel with PREEMPT");
  tree.put("boot/config-6.1.0-50-amd64", "CONFIG_PREEMPT_VOLUNTARY=y\n# CONFIG_PREEMPT is not set");
  says("preemption", Verdict::advice, "voluntary: ");
  rig.tolerance.wake_ahead = {};
  says("preemption", Verdict::advice, "set [tolerance] wake_ahead_us");
}

TEST(RealTimeReport, TellsTheModelThatADynamicKernelRunsWith) {
  tree.put("proc/sys/kernel/version", "#1 SMP PREEMPT_DYNAMIC Debian 6.1.176-1 (2026-11-02)");
  says("preemption", Verdict::advice, "this user may not read");
  says("preemption", Verdict::advice, "preempt=full");
  tree.put("boot/config-6.1.0-50-amd64", "CONFIG_PREEMPT_NONE=y\nCONFIG_PREEMPT_DYNAMIC=y");
  says("preemption", Verdict::advice, "none: ");
  tree.put("proc/cmdline", "root=/dev/vda preempt=full quiet");
  says("preemption", Verdict::ok, "full");
  tree.put("proc/cmdline", "root=/dev/vda preempt=full preempt=voluntary preempt=nonsense");
  says("preemption", Verdict::advice, "voluntary: ");
  tree.put("sys/kernel/debug/sched/preempt", "none voluntary full (lazy)");
  says("preemption", Verdict::ok, "full");
  tree.put("sys/kernel/debug/sched/preempt", "(none) voluntary full");
  says("preemption", Verdict::advice, "echo full > /sys/kernel/debug/sched/preempt");
}

TEST(RealTimeReport, RefusesAClockThatTakesMicrosecondsToRead) {
  tree.put("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet");
  tree.put("sys/devices/system/clocksource/clocksource0/available_clocksource", "tsc hpet acpi_pm");
  says("clock_source", Verdict::fault, "tsc hpet acpi_pm");
}

TEST(RealTimeReport, KnowsNoFaultWhereTheKernelTellsNothing) {
  const auto items = real_time_report(rig, trial, tick, SystemFiles("/nonexistent"));
  for (const CheckItem& each : items)
    CHECK_TEXT(each.verdict != Verdict::fault, (each.name + ": " + each.words).c_str());
}

TEST(RealTimeReport, WantsWhatHandsASequencersRepliesOverOffTheLoopsCpu) {
  CHECK(replies_item(rig, tree.files()).verdict == Verdict::ok);  // the kernel does not say
  tree.put("sys/devices/virtual/workqueue/cpumask", "3");
  const CheckItem found = replies_item(rig, tree.files());
  CHECK(found.verdict == Verdict::advice);
  STRCMP_CONTAINS("may run on CPU 1", found.words.c_str());
  CHECK_EQUAL("echo 1 > /sys/devices/virtual/workqueue/cpumask", found.paste.at(0));
  tree.put("sys/devices/virtual/workqueue/cpumask", "1");
  CHECK(replies_item(rig, tree.files()).verdict == Verdict::ok);
  rig.real_time.cpu = -1;
  CHECK(replies_item(rig, tree.files()).verdict == Verdict::ok);
}
