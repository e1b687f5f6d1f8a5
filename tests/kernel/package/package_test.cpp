// The Debian package strobed in an emulated machine with apt, dpkg, systemd and udev, by a new user's hands:
// installed, rig file edited, started, fired by a host outside, upgraded in the middle of a shot, purged.
#include <algorithm>
#include <cstdio>
#include <sstream>
#include <string>

#include "tests/kernel/service.hpp"
#include "tests/support/json_lines.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::kernel;

namespace {

constexpr std::chrono::seconds kInstalling{300};  // an emulated dpkg
constexpr const char* kApt = "DEBIAN_FRONTEND=noninteractive apt-get -q -y -o Dpkg::Use-Pty=0 ";

/// Told as it happens: it takes minutes.
void say(const std::string& what) {
  std::printf("\n%s\n", what.c_str());
  std::fflush(stdout);
}

std::string lines_with(const std::string& start, const std::string& text) {
  std::istringstream in(text);
  std::string found;
  for (std::string line; std::getline(in, line);)
    if (line.rfind(start, 0) == 0) found += line + "\n";
  return found;
}

/// Runs an apt-get, which must end well; what it said for the user to read.
std::string apt(VirtualMachine& machine, const std::string& words) {
  say("apt-get " + words);
  std::string said = machine.run(kApt + words + " </dev/null 2>&1; echo status $?", kInstalling);
  CHECK_TRUE_TEXT(said.find("status 0") != said.npos, said.c_str());
  const std::string own = lines_with("strobed:", said);
  std::printf("%s", own.c_str());
  std::fflush(stdout);
  return own;
}

}  // namespace

TEST_GROUP(Package) {
  std::string said_at_install;
  std::unique_ptr<Service> service;

  std::string installed(VirtualMachine & machine) {
    said_at_install = apt(machine, "install /opt/strobed.deb");
    return machine.run("cat /etc/strobe/lab.key");
  }

  void setup() override {
    service = std::make_unique<Service>(STROBE_BUILD_DIR "/kernel/package",
                                        [this](VirtualMachine& machine) { return installed(machine); });
  }
  void teardown() override { service.reset(); }

  std::string word(const std::string& line) const { return service->word(line); }

  void is_ready_to_be_configured() const {
    STRCMP_CONTAINS("edit /etc/strobe/rig.toml", said_at_install.c_str());
    CHECK_EQUAL("enabled", word("systemctl is-enabled strobed"));
    CHECK_EQUAL("inactive", word("systemctl is-active strobed"));
    CHECK_EQUAL("root 600", word("stat -c '%U %a' /etc/strobe/lab.key"));
    // At once, not after the next boot.
    CHECK_EQUAL("gpio 660", word("stat -c '%G %a' /dev/gpiochip0"));
    CHECK_EQUAL("gpio 660", word("stat -c '%G %a' /dev/cpu_dma_latency"));
  }

  /// As the README says it, as root.
  void checks_what_the_service_will_use() const {
    service->shell("cp /opt/rig.toml /etc/strobe/rig.toml");
    say("strobed --check --config /etc/strobe/rig.toml");
    const std::string checked = service->shell("strobed --check --config /etc/strobe/rig.toml 2>&1");
    std::printf("%s", checked.c_str());
    STRCMP_CONTAINS("/etc/strobe/lab.key, fingerprint", checked.c_str());
    STRCMP_CONTAINS("ok: /var/lib/strobe", lines_with("session ", checked).c_str());
    CHECK_EQUAL("", word("ls -d ~/.config/strobe 2>/dev/null"));
  }

  void fires_a_shot() const {
    service->count_from_now();
    const testing::CompletedProcess fired = service->fire_a_shot();
    const auto counts = service->flashes_of_each_shot();
    for (const int count : counts) std::printf("%d flashes\n", count);
    CHECK_TRUE_TEXT(std::find(counts.begin(), counts.end(), kFlashes) != counts.end(),
                    (fired.out + fired.err + service->journal()).c_str());
    for (const nlohmann::json& readout : testing::parse_json_lines(fired.out))
      std::printf("shot %s: vx %s m/s, flags %s\n", readout.at("shot_id").dump().c_str(),
                  readout.at("vx_td_mps").dump().c_str(), readout.at("flags").dump().c_str());
    STRCMP_CONTAINS("vx_td_mps", fired.out.c_str());
  }

  std::string journals() const {
    return service->shell("cd /var/lib/strobe && for f in *.lcmlog; do head -c 4000 $f | sha256sum; done");
  }

  void is_upgraded_while_a_shot_is_under_way() const {
    const std::string running = service->property("MainPID"), kept = journals();
    const std::string files = word("cat /etc/strobe/rig.toml /etc/strobe/lab.key | sha256sum");
    service->count_from_now();
    const auto firing = service->fire_and_wait_for_the_train();
    CHECK_TRUE_TEXT(firing != nullptr, service->journal().c_str());
    const int before = service->flashes_of_each_shot().back();
    const std::string said = apt(service->bench().machine(), "install /opt/later.deb");
    std::printf("from flash %d to %d\n", before, service->flashes_of_each_shot().back());
    STRCMP_CONTAINS("systemctl restart strobed", said.c_str());
    CHECK_TRUE_TEXT(testing::wait_until([&] { return !firing->running(); }, kTimeout), "the shot has no end");
    const auto counts = service->flashes_of_each_shot();
    CHECK_TRUE_TEXT(counts.back() == kLongTrain, (firing->err() + service->journal()).c_str());
    std::printf("%d flashes\n", counts.back());
    CHECK_EQUAL("active", service->property("ActiveState"));
    CHECK_EQUAL(running, service->property("MainPID"));
    CHECK_EQUAL(files, word("cat /etc/strobe/rig.toml /etc/strobe/lab.key | sha256sum"));
    CHECK_EQUAL(kept, journals());
  }

  void leaves_nothing_but_its_user() const {
    CHECK_TRUE(outputs_inactive(service->bench().events()));
    CHECK_EQUAL("not-found inactive",
                service->property("LoadState") + " " + service->property("ActiveState"));
    CHECK_EQUAL("", word("systemctl list-units --all --plain --no-legend 'strobe*'"));
    const std::string left = service->shell(
        "find /etc /usr /var /run ~ /tmp -name '*strobe*' ! -path '/var/log/*' ! -path '/run/udev/*'");
    CHECK_EQUAL("", left);
    CHECK_EQUAL("", word("dpkg-query -W -f '${Package} ${Status}' strobed 2>/dev/null"));
    say("left: " + service->shell("grep -E '^(strobe|gpio):' /etc/passwd /etc/group"));
  }
};

TEST(Package, IsInstalledFiredUpgradedInTheMiddleOfAShotAndPurged) {
  is_ready_to_be_configured();
  checks_what_the_service_will_use();

  say("systemctl start strobed");
  service->shell("systemctl start strobed");
  STRCMP_EQUAL_TEXT("active", service->property("ActiveState").c_str(), service->journal().c_str());
  fires_a_shot();

  is_upgraded_while_a_shot_is_under_way();
  const std::string kept = journals();
  say("systemctl restart strobed");
  service->shell("systemctl restart strobed");
  STRCMP_EQUAL_TEXT("active", service->property("ActiveState").c_str(), service->journal().c_str());
  STRCMP_CONTAINS(kept.c_str(), journals().c_str());
  fires_a_shot();

  apt(service->bench().machine(), "purge strobed");
  leaves_nothing_but_its_user();
}
