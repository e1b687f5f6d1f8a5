#include "firmware/linux/service_notify.hpp"

#include <unistd.h>

#include <cstdlib>
#include <string>

#include "tests/support/fake_service_manager.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using strobe::firmware::ServiceNotify;
using strobe::testing::FakeServiceManager;

TEST_GROUP(ServiceNotify) {
  strobe::testing::TemporaryFolder folder;
  void teardown() override {
    for (const char* variable : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) unsetenv(variable);
  }
};

TEST(ServiceNotify, SpeaksToTheManagerThatTheEnvironmentNames) {
  FakeServiceManager manager((folder / "notify").string());
  setenv("NOTIFY_SOCKET", manager.path().c_str(), 1);
  setenv("WATCHDOG_USEC", "4000000", 1);
  setenv("WATCHDOG_PID", std::to_string(getpid()).c_str(), 1);
  const ServiceNotify service = ServiceNotify::from_environment();
  CHECK(service.managed());
  CHECK_EQUAL(milliseconds(4'000), service.watchdog());
  service.say("READY=1\nSTATUS=ready");
  service.say("WATCHDOG=1");
  CHECK_EQUAL(2u, manager.heard().size());
  CHECK_EQUAL("READY=1\nSTATUS=ready", manager.heard()[0]);
  CHECK_EQUAL(1, manager.count("WATCHDOG"));
}

TEST(ServiceNotify, IsSilentWithoutAManager) {
  const ServiceNotify service = ServiceNotify::from_environment();
  CHECK_FALSE(service.managed());
  CHECK_EQUAL(milliseconds(0), service.watchdog());
  service.say("READY=1");
}

TEST(ServiceNotify, LeavesAWatchdogOfAnotherProcessAlone) {
  setenv("WATCHDOG_USEC", "4000000", 1);
  setenv("WATCHDOG_PID", "1", 1);
  CHECK_EQUAL(ServiceNotify::from_environment().watchdog(), milliseconds(0));
}

TEST(ServiceNotify, DoesNotWaitForAManagerThatDoesNotRead) {
  FakeServiceManager manager((folder / "notify").string());
  const ServiceNotify service(manager.path(), milliseconds(0));
  for (int i = 0; i < 10'000; ++i) service.say("WATCHDOG=1");  // would block for good once the socket is full
  CHECK(manager.count("WATCHDOG") > 0);
}

TEST(ServiceNotify, TakesNoHarmFromAnAddressThatIsNone) {
  CHECK_FALSE(ServiceNotify((folder / "nobody").string(), milliseconds(0)).managed());
  CHECK_FALSE(ServiceNotify(std::string(500, 'x'), milliseconds(0)).managed());
}
