// Lines to a pipe that nobody empties. A console that waits for its reader never comes back from say().
#include "firmware/linux/console.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <optional>
#include <string>

#include "tests/support/string_from.hpp"

using strobe::firmware::Console;

TEST_GROUP(Console) {
  int ends[2] = {-1, -1};
  std::string seen;

  void setup() override { CHECK_EQUAL(0, pipe2(ends, O_CLOEXEC)); }
  void teardown() override {
    for (const int end : ends) close(end);
  }
  /// Until a write would block.
  void fill() const {
    fcntl(ends[1], F_SETFL, O_NONBLOCK);
    const std::string zeros(4096, '.');
    while (write(ends[1], zeros.data(), zeros.size()) > 0) continue;
    CHECK_EQUAL(EAGAIN, errno);
    fcntl(ends[1], F_SETFL, 0);
  }
  /// Reads until the text has come; a text that never comes is the test's timeout's to judge.
  void read_until(const std::string& text) {
    char part[4096];
    while (seen.find(text) == std::string::npos) {
      const ssize_t n = read(ends[0], part, sizeof part);
      CHECK(n > 0);
      seen.append(part, static_cast<std::size_t>(n));
    }
  }
  long count(const std::string& text) const {
    long found = 0;
    for (std::size_t at = seen.find(text); at != std::string::npos; at = seen.find(text, at + 1)) ++found;
    return found;
  }
};

TEST(Console, WritesLinesInOrderAfterTheProgramsName) {
  Console console(ends[1]);
  console.say("one");
  console.say(std::string(2 * Console::kLongestLine, 'x'));
  console.say("three");
  read_until("three\n");
  CHECK_EQUAL("strobed: one\nstrobed: " + std::string(Console::kLongestLine, 'x') + "\nstrobed: three\n",
              seen);
}

TEST(Console, NeverWaitsForItsReaderAndTellsWhatIsMissingAfterwards) {
  constexpr long kSaid = 10'000;
  fill();
  Console console(ends[1]);
  for (long k = 0; k < kSaid; ++k) console.say("line");
  read_until("lines are missing here");
  read_until("standard error was blocked\n");
  console.say("goes on");
  read_until("goes on\n");
  const std::size_t told = seen.find(" lines are missing");
  const std::size_t begin = seen.rfind(' ', told - 1) + 1;
  CHECK_EQUAL(kSaid, count("strobed: line\n") + std::stol(seen.substr(begin, told - begin)));
  const auto kept = static_cast<long>(Console::kMaxLines);
  CHECK(count("strobed: line\n") >= kept && count("strobed: line\n") <= kept + 1);  // one is being written
  CHECK_EQUAL(1, count("are missing"));
}

TEST(Console, EndsWithAReaderThatIsBlockedForGood) {
  fill();
  std::optional<Console> console(std::in_place, ends[1]);
  console->say("read too late");
  console.reset();
  read_until("read too late\n");
}

TEST(Console, WritesWhatIsLeftBeforeItEnds) {
  {
    Console console(ends[1]);
    for (int k = 0; k < 100; ++k) console.say("line");
  }
  read_until("line\n");
  CHECK_EQUAL(100, count("line\n"));
}
