// The network under the shipped programs: an interface that is made anew, a rig that does not hear, two rigs of one name.
#include <unistd.h>

#include <algorithm>
#include <string>

#include "tests/hil/raw_host.hpp"
#include "tests/support/fake_service_manager.hpp"
#include "tests/support/private_network.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/hil/expectations.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::hil;
using namespace strobe::testing;
using namespace std::chrono_literals;
using strobe_msgs::command_t;
using strobe_msgs::event_t;

namespace {

void ip(const std::string& words) {
  const auto done = run_process({{"sh", "-c", "ip " + words}, {}, {}, {}}, 60s);
  CHECK_TEXT(done.status == ExitStatus({0, 0}), (words + ": " + done.err).c_str());
}

bool journalled(const RigFixture& bench, std::int8_t kind) {
  const auto events = read_log(bench.journal()).events;
  return std::ranges::any_of(events, [kind](const event_t& event) { return event.kind == kind; });
}

}  // namespace

/// Multicast goes through a virtual Ethernet.
TEST_GROUP(Network){void setup() override{make();
}
void teardown() override {
  ip("link del strobe0 2>/dev/null || true");
  ip("route replace 224.0.0.0/4 dev lo");
}
static void make() {
  ip("link add strobe0 type veth peer name strobe1");
  ip("link set strobe0 up");
  ip("link set strobe1 up");
  ip("address add 10.9.8.7/24 dev strobe0");
  ip("route replace 224.0.0.0/4 dev strobe0");
}
static void make_anew() {
  ip("link del strobe0");
  make();
}
/// Sends it until the journal tells of it: a packet may come before the group is joined again.
static bool obeyed(const RigFixture& bench, RawHost& host, std::int8_t command, std::int8_t event) {
  for (int i = 0; i < 100 && !journalled(bench, event); ++i) {
    host.send(host.command(command));
    usleep(100'000);
  }
  return journalled(bench, event);
}
}
;

TEST(Network, CommandsAreHeardAfterTheInterfaceWasMadeAnew) {
  RigFixtureOptions options;
  options.sim_options = {"--no-digitizer"};  // nobody else in this machine joins the group again
  ReadyRig bench(options);
  RawHost host(bench);
  CHECK(host.wait_status());
  make_anew();
  CHECK_TEXT(obeyed(bench, host, command_t::ARM, event_t::ARMED), bench.log().c_str());
  make_anew();
  CHECK_TEXT(obeyed(bench, host, command_t::DISARM, event_t::DISARMED), bench.log().c_str());
}

TEST(Network, ASeriesGoesOnAfterTheInterfaceWasMadeAnew) {
  RigFixtureOptions options;
  options.rig_edits = kShortExposure;
  ReadyRig bench(options);
  auto fire = bench.start(bench.fire(2, 0));
  CHECK_TEXT(fire.wait_for_out("vx_td_mps", kLongestWait), fire.err().c_str());
  make_anew();
  CHECK_TEXT(fire.wait(kLongestWait) == ExitStatus({0, 0}), fire.err().c_str());
}

TEST_GROUP(TwoRigs){};

TEST(TwoRigs, OfOneNameAreToldByBootAndAddressAndNoneIsArmed) {
  ReadyRig bench;
  RigFixtureOptions options;
  options.lcm_url = bench.lcm_url();
  ReadyRig other(options);
  auto command = bench.fire(1, 0, {"--wait", "12"});
  const auto fired = ran(command, 1);
  STRCMP_CONTAINS("2 rigs have the name bench: boot ", fired.err.c_str());
  for (RigFixture* rig : {&bench, &other}) {
    const std::string journal = rig->journal().stem().string();
    const std::string boot = journal.substr(journal.find_first_not_of('0', journal.find('-') + 1));
    STRCMP_CONTAINS(("boot " + boot + " at ").c_str(), fired.err.c_str());
    CHECK_FALSE(journalled(*rig, event_t::ARMED));
    LONGS_EQUAL(0, rig->finish().rises("TRIGGER"));
  }
}

TEST(Network, TheServiceManagerIsToldWhenAHostWasLastHeard) {
  TemporaryFolder folder;
  FakeServiceManager manager((folder / "notify").string());
  RigFixtureOptions options;
  options.environment = {{"NOTIFY_SOCKET", manager.path()}};
  ReadyRig bench(options);
  const auto hears = [&manager](const char* words) {
    return wait_until([&] { return manager.count(words) > 0; }, kLongestWait);
  };
  CHECK(hears("STATUS=ready, no host heard yet"));
  CHECK_EQUAL(0, manager.count("STATUS=ready, a host heard"));
  RawHost host(bench);
  CHECK(host.wait_status());
  CHECK(host.arm() != 0);
  CHECK(hears("STATUS=ready, a host heard"));
}
