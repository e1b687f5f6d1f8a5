// Watched lines: who watches is told what others do with a line.
#include <signal.h>

#include "tests/sim/gpiochip/fixture.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::sim;

TEST_GROUP(LineWatches) {
  ChipFixture fixture;

  testing::Process actor(std::vector<std::string> role, const std::string& until = "ready") {
    return fixture.actor(std::move(role), until, "gpio_actor_v2");
  }

  /// As a rig does all the time.
  bool said_while_the_rig_looks(testing::Process & watcher, const std::string& text) {
    return testing::wait_until(
        [&] {
          ChangeCursor cursor = fixture.chip().cursor_now();
          std::vector<Change> changes;
          fixture.chip().wait_changes(cursor, now() + milliseconds(2), changes);
          return watcher.out().find(text) != std::string::npos;
        },
        kLimit);
  }
};

TEST(LineWatches, TellOfRequestsConfigurationsAndReleasesOfOthers) {
  auto watcher = actor({"watch", "4,5"});
  {
    auto holder = actor({"turn", "4"});
    holder.signal(SIGUSR1);
    CHECK_TRUE(holder.wait_for_out("input", kLimit));
    auto unseen = actor({"hold", "6", "0"});
    holder.signal(SIGKILL);
    holder.wait(kLimit);
  }
  CHECK_TRUE(said_while_the_rig_looks(watcher, "2 4"));
  auto first_version = fixture.actor({"hold", "5", "1"});
  CHECK_TRUE(said_while_the_rig_looks(watcher, "1 5"));
  CHECK_EQUAL("ready\n1 4 actor\n3 4 actor\n2 4 \n1 5 actor\n", watcher.out());
}

TEST(LineWatches, OfManyProgramsAreAllServed) {
  auto first = actor({"watch", "4"}), second = actor({"watch", "3,4"});
  auto holder = actor({"hold", "4", "0"});
  CHECK_TRUE(first.wait_for_out("1 4 actor\n", kLimit));
  CHECK_TRUE(second.wait_for_out("1 4 actor\n", kLimit));
}

TEST(LineWatches, CanBeMadeByAsManyOpensOfTheChipAsItHas) {
  {
    auto greedy = actor({"opens", "40"});
    STRCMP_CONTAINS("watching 32\n", greedy.out().c_str());
  }
  auto next = actor({"opens", "32"});  // those of a dead process are free again
  STRCMP_CONTAINS("watching 32\n", next.out().c_str());
}
