#include <csignal>
#include <functional>
#include <latch>
#include <new>
#include <string>
#include <sys/mman.h>
#include <sys/wait.h>
#include <thread>
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
    if (holder > 0) {
      kill(holder, SIGKILL);
      waitpid(holder, nullptr, 0);
    }
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

/// Where both look at one mutex, the waiter's having it hides the death: about once in 4,000 rounds.
TEST(Lifeline, TellsOfADeathWithoutWaitingWhileAnotherThreadTakesItIn) {
  constexpr int kRounds = 2'000;
  for (int round = 0; round < kRounds; ++round) {
    Lifeline of_thread;
    std::latch held(2), waits(2);
    std::thread dying([&] {
      of_thread.hold();
      held.arrive_and_wait();
      waits.wait();
    });
    held.arrive_and_wait();
    std::thread waiter([&] {
      waits.count_down();
      of_thread.wait_for_death();
    });
    waits.count_down();
    dying.join();
    const bool told = of_thread.holder_died();
    waiter.join();
    CHECK_TEXT(told, std::to_string(round).c_str());
  }
}

TEST(Lifeline, TellsAnEndInGoodOrderFromADeath) {
  fork_holder([this] { line.let_go(); });
  CHECK_FALSE(line.wait_for_death());
  CHECK_FALSE(line.holder_died());
}
