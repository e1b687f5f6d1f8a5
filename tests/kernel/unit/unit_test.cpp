// The shipped unit under Debian's systemd as the first process of Debian's kernel, with the shipped user,
// device rules and key as credential; rig and host are outside. One machine for all tests: a boot takes half
// a minute.
#include <algorithm>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include "tests/kernel/service.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::kernel;

namespace {

constexpr int kFifo = 1;  // SCHED_FIFO as /proc tells it

Service& service() {
  static Service machine(STROBE_BUILD_DIR "/kernel/unit");
  return machine;
}
KernelFixture& bench() { return service().bench(); }

std::string shell(const std::string& line) { return service().shell(line); }
std::string word(const std::string& line) { return service().word(line); }
std::string property(const std::string& name) { return service().property(name); }
bool becomes(const std::string& state) { return service().becomes(state); }
std::string journal() { return service().journal(); }

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> all;
  for (std::string each; in >> each;) all.push_back(each);
  return all;
}

/// Guardian and worker.
std::vector<std::string> processes() {
  return words_of(shell("cat /sys/fs/cgroup/system.slice/strobed.service/cgroup.procs 2>/dev/null"));
}

std::vector<std::string> status_field(const std::string& process, const std::string& name) {
  auto words = words_of(shell("grep ^" + name + ": /proc/" + process + "/status"));
  if (!words.empty()) words.erase(words.begin());
  return words;
}

struct Scheduling {
  int policy = 0, priority = 0;
};

/// The highest of a process's threads. Fields 40 and 41 of proc(5)'s stat; no name here has a space.
Scheduling highest_of(const std::string& process) {
  Scheduling highest;
  std::istringstream lines(shell("awk '{print $40, $41}' /proc/" + process + "/task/*/stat"));
  for (Scheduling each; lines >> each.priority >> each.policy;)
    if (each.priority > highest.priority) highest = each;
  return highest;
}

/// As root, but in the service's control group: its devices and addresses, none of its other bounds.
std::string in_its_group(const std::string& command) {
  return shell("sh -c 'echo $$ >/sys/fs/cgroup/system.slice/strobed.service/cgroup.procs; " + command +
               "' 2>&1");
}

std::string refused(const std::string& said) {
  const bool is = said.find("Operation not permitted") != std::string::npos;
  return is ? "refused" : said;
}

}  // namespace

TEST_GROUP(Unit) {
  int restarts = 0;

  void setup() override {
    shell("systemctl reset-failed strobed; systemctl restart strobed");
    STRCMP_EQUAL_TEXT("active", property("ActiveState").c_str(), journal().c_str());
    service().count_from_now();
    restarts = std::stoi(property("NRestarts"));
  }

  static std::unique_ptr<testing::Process> fire_and_wait_for_the_train() {
    auto firing = service().fire_and_wait_for_the_train();
    CHECK_TRUE_TEXT(firing != nullptr, journal().c_str());
    return firing;
  }

  void outputs_become_inactive() const {
    const std::int64_t from_ns = testing::monotonic_now_ns();
    CHECK_TRUE_TEXT(testing::wait_until([] { return outputs_inactive(bench().events()); }, kTimeout),
                    journal().c_str());
    std::printf("outputs inactive after %.1f s ",
                1e-9 * static_cast<double>(testing::monotonic_now_ns() - from_ns));
    CHECK_TRUE(service().flashes_of_each_shot().back() < kLongTrain);
  }

  void is_started_again() const {
    CHECK_TRUE_TEXT(
        testing::wait_until([this] { return std::stoi(property("NRestarts")) > restarts; }, kTimeout),
        journal().c_str());
    CHECK_TRUE_TEXT(becomes("active"), journal().c_str());
    LONGS_EQUAL(2, processes().size());
  }
};

TEST(Unit, RunsAsItsOwnUserWithNoCapabilityButToWatchItsCpus) {
  const std::string user = word("id -u strobe");
  const std::string group = word("sed -n 's/^gpio:[^:]*:\\([0-9]*\\):.*/\\1/p' /etc/group");
  const auto both = processes();
  LONGS_EQUAL(2, both.size());
  for (const std::string& process : both) {
    for (const std::string& each : status_field(process, "Uid")) CHECK_EQUAL(user, each);
    const auto groups = status_field(process, "Groups");
    CHECK_TRUE(std::find(groups.begin(), groups.end(), group) != groups.end());
    for (const char* set : {"CapInh", "CapPrm", "CapEff", "CapBnd", "CapAmb"})
      CHECK_EQUAL("0000004000000000", status_field(process, set).at(0));  // CAP_PERFMON, 38
    CHECK_EQUAL("1", status_field(process, "NoNewPrivs").at(0));
    CHECK_EQUAL("2", status_field(process, "Seccomp").at(0));  // a filter
  }
}

TEST(Unit, IsActiveOnceTheGuardianSaysSoAndKeepsItsRealTimeRights) {
  CHECK_EQUAL("notify", property("Type"));
  CHECK_EQUAL("ready", property("StatusText"));
  const std::string guardian = property("MainPID");
  for (const std::string& process : processes()) {
    const Scheduling highest = highest_of(process);
    LONGS_EQUAL(kFifo, highest.policy);
    LONGS_EQUAL(process == guardian ? 81 : 80, highest.priority);  // of rig.toml, and one above
    CHECK_TRUE(std::stol(status_field(process, "VmLck").at(0)) > 0);
  }
  STRCMP_CONTAINS("key /run/credentials/strobed.service/lab.key", journal().c_str());
  CHECK_EQUAL(std::string::npos, journal().find("warning"));
}

TEST(Unit, FiresAWholeShotForTheHostOutside) {
  const testing::CompletedProcess fired = service().fire_a_shot();
  const auto counts = service().flashes_of_each_shot();
  for (const int count : counts) std::printf("%d flashes ", count);
  CHECK_TRUE_TEXT(std::find(counts.begin(), counts.end(), kFlashes) != counts.end(),
                  (fired.out + fired.err + journal()).c_str());
  STRCMP_CONTAINS("vx_td_mps", fired.out.c_str());
  CHECK_TRUE_TEXT(testing::wait_until([] { return outputs_inactive(bench().events()); }, kTimeout), "active");
}

TEST(Unit, LeavesTheOutputsInactiveWhenItIsStoppedInTheMiddleOfATrain) {
  const auto firing = fire_and_wait_for_the_train();
  shell("systemctl stop strobed");
  outputs_become_inactive();
  STRCMP_EQUAL_TEXT("inactive", property("ActiveState").c_str(), journal().c_str());
  CHECK_EQUAL("success", property("Result"));
  LONGS_EQUAL(0, processes().size());
  firing->signal(15);
}

TEST(Unit, IsStartedAgainAfterItsWorkerWasKilledInTheMiddleOfATrain) {
  const auto firing = fire_and_wait_for_the_train();
  shell(
      "for p in $(cat /sys/fs/cgroup/system.slice/strobed.service/cgroup.procs); do [ $p = $(systemctl show "
      "-P "
      "MainPID strobed) ] || kill -9 $p; done");
  outputs_become_inactive();
  is_started_again();
  STRCMP_CONTAINS("the guardian made the outputs inactive", journal().c_str());
  firing->signal(15);
}

TEST(Unit, MakesTheOutputsInactiveOnceMoreAfterWorkerAndGuardianWereKilled) {
  const auto firing = fire_and_wait_for_the_train();
  shell("systemctl kill -s KILL strobed");
  outputs_become_inactive();
  is_started_again();
  STRCMP_CONTAINS("status=0", word("systemctl show -p ExecStopPost strobed").c_str());
  firing->signal(15);
}

TEST(Unit, IsEndedByTheWatchdogWhenNothingOfItMovesInTheMiddleOfATrain) {
  const auto firing = fire_and_wait_for_the_train();
  shell("systemctl kill -s STOP strobed");
  outputs_become_inactive();
  is_started_again();
  STRCMP_CONTAINS("Failed with result 'watchdog'", journal().c_str());
  firing->signal(15);
}

TEST(Unit, LeavesNoHungWorkerWithTheLinesAfterItsGuardianWasKilled) {
  const auto firing = fire_and_wait_for_the_train();
  shell(
      "g=$(systemctl show -P MainPID strobed); for p in $(cat "
      "/sys/fs/cgroup/system.slice/strobed.service/cgroup.procs); do [ $p = $g ] || kill -STOP $p; done; "
      "kill -KILL $g");
  outputs_become_inactive();
  is_started_again();
  firing->signal(15);
}

TEST(Unit, WaitsForAChipAndANetworkThatComeLate) {
  shell(
      "chmod 600 /dev/gpiochip0; ip route del 224.0.0.0/4; systemctl stop strobed; systemctl start "
      "--no-block strobed");
  CHECK_TRUE(testing::wait_until([] { return std::stoi(property("NRestarts")) >= 2; }, kTimeout));
  shell("chmod 660 /dev/gpiochip0");
  const int tried = std::stoi(property("NRestarts"));
  CHECK_TRUE(testing::wait_until([&] { return std::stoi(property("NRestarts")) > tried; }, kTimeout));
  shell("ip route add 224.0.0.0/4 dev eth0");
  CHECK_TRUE_TEXT(becomes("active"), journal().c_str());
}

TEST(Unit, OpensNoDeviceBesideThoseItNeeds) {
  for (const char* device : {"/dev/mem", "/dev/vda", "/dev/ttyAMA0"}) {
    const std::string open = std::string(": <") + device;
    STRCMP_EQUAL_TEXT("", shell("sh -c '" + open + "' 2>&1").c_str(), device);
    STRCMP_EQUAL_TEXT("refused", refused(in_its_group(open)).c_str(), device);
  }
  for (const char* device : {"/dev/gpiochip0", "/dev/cpu_dma_latency", "/dev/null"})
    STRCMP_EQUAL_TEXT("", in_its_group(std::string(": <>") + device).c_str(), device);
}

TEST(Unit, SendsToPrivateNetworksOnly) {
  shell("ip route add default dev eth0");
  const std::string ping = "ping -c 1 -W 1 ";
  CHECK_EQUAL("refused", refused(in_its_group(ping + "192.0.2.1")));
  STRCMP_CONTAINS("100% packet loss", shell(ping + "192.0.2.1 2>&1").c_str());
  STRCMP_CONTAINS("0% packet loss", in_its_group(ping + "10.76.0.2").c_str());
  shell("ip route del default dev eth0");
}

TEST(Unit, BoundsWhatRunsInItsPlace) {
  struct Probe {
    const char* command;
    const char* answer;
  };
  const std::vector<Probe> probes{
      {"touch /var/lib/strobe/probed && echo done", "done"},
      {"taskset 1 true && echo done", "done"},
      {"ulimit -l", "unlimited"},
      {"touch /etc/probed", "Read-only file system"},
      {"touch /usr/local/bin/probed", "Read-only file system"},
      {"cat /etc/strobe/lab.key", "Permission denied"},
      {"ls /root", "Permission denied"},
      {"ls /proc/1", "No such file"},
      {"ionice -c 2 -n 7 true", "not permitted"},  // any user may, but for the list of system calls
      {"unshare -U true", "not permitted"},
      {"dmesg", "not permitted"},
      {"mount -t tmpfs none /tmp", "denied"},
      {"ping6 -c 1 ::1", "not supported"}};
  // The shipped unit with these for the firmware (probe.conf), all in one go: a start takes long.
  std::string script;
  for (const Probe& probe : probes) script += std::string(probe.command) + " 2>&1; echo ===; ";
  shell("echo '" + script + "' >/run/probe; systemctl start probe");
  std::istringstream answers(shell("cat /run/probed"));
  for (const Probe& probe : probes) {
    std::string answer;
    for (std::string line; std::getline(answers, line) && line.rfind("===", 0) != 0;) answer += line + "\n";
    STRCMP_CONTAINS_TEXT(probe.answer, answer.c_str(), probe.command);
  }
}
