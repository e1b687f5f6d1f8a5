#include <csignal>
#include <functional>
#include <new>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "firmware/linux/shared_status.hpp"
#include "tests/support/string_from.hpp"

using strobe::firmware::Lifeline;

TEST_GROUP(Lifeline) {
  void* const memory =
      mmap(nullptr, sizeof(Lifeline), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  Lifeline& line = *new (memory) Lifeline;
  pid_t holder = 0;

  void teardown() override {
    kill(holder, SIGKILL);
    waitpid(holder, nullptr, 0);
    munmap(memory, sizeof(Lifeline));
  }

  /// A process that holds the line, does this and then waits.
  void fork_holder(const std::function<void()>& then) {
    int held[2];
    CHECK(pipe(held) == 0);
    holder = fork();
    if (holder == 0) {
      line.hold();
      then();
      if (write(held[1], "h", 1) != 1) _exit(1);
      for (;;) pause();
    }
    char byte = 0;
    CHECK(read(held[0], &byte, 1) == 1);
    close(held[0]);
    close(held[1]);
  }
};

TEST(Lifeline, TellsOfADeathThatNothingCanCatch) {
  fork_holder([] {});
  kill(holder, SIGKILL);
  CHECK(line.wait_for_death());
}

TEST(Lifeline, TellsOfADeathThatCameBeforeAnybodyWaited) {
  fork_holder([] {});
  kill(holder, SIGKILL);
  CHECK(waitpid(holder, nullptr, 0) == holder);
  CHECK(line.wait_for_death());
}

TEST(Lifeline, TellsOfADeathWithoutWaiting) {
  fork_holder([] {});
  CHECK_FALSE(line.holder_died());
  kill(holder, SIGKILL);
  CHECK(waitpid(holder, nullptr, 0) == holder);
  CHECK(line.holder_died());
  CHECK(line.holder_died());
  CHECK(line.wait_for_death());
}

TEST(Lifeline, TellsAnEndInGoodOrderFromADeath) {
  fork_holder([this] { line.let_go(); });
  CHECK_FALSE(line.wait_for_death());
  CHECK_FALSE(line.holder_died());
}
