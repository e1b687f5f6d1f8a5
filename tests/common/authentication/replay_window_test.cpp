#include "common/authentication/replay_window.hpp"

#include <rapidcheck.h>

#include <set>

#include "tests/support/string_from.hpp"

using namespace strobe::authentication;

namespace {

constexpr std::int64_t kSize = ReplayWindow::kSize;

/// Numbers as a network brings them: near each other, with repetitions, strides and leaps.
std::vector<std::int64_t> drawn_numbers() {
  std::vector<std::int64_t> numbers;
  std::int64_t newest = *rc::gen::inRange<std::int64_t>(-3, 3 * kSize);
  const int count = *rc::gen::inRange(1, 200);
  for (int i = 0; i < count; ++i) {
    switch (*rc::gen::inRange(0, 4)) {
      case 0:
        newest += *rc::gen::inRange<std::int64_t>(1, 5);
        numbers.push_back(newest);
        break;
      case 1:
        newest += *rc::gen::inRange<std::int64_t>(1, 2 * kSize);
        numbers.push_back(newest);
        break;
      case 2:
        numbers.push_back(newest - *rc::gen::inRange<std::int64_t>(0, 20));
        break;
      default:
        numbers.push_back(newest - *rc::gen::inRange<std::int64_t>(kSize - 3, kSize + 3));
        break;
    }
  }
  return numbers;
}

}  // namespace

TEST_GROUP(ReplayWindow){};

TEST(ReplayWindow, AcceptsANumberIfItIsNewAndNotTooFarBelowTheLargest) {
  const bool holds = rc::check([] {
    ReplayWindow window;
    std::set<std::int64_t> accepted;
    for (const std::int64_t number : drawn_numbers()) {
      const std::int64_t largest = accepted.empty() ? 0 : *accepted.rbegin();
      const bool expected = number >= 1 && number > largest - kSize && !accepted.contains(number);
      RC_ASSERT(window.accept(number) == expected);
      if (expected) accepted.insert(number);
    }
  });
  CHECK_TRUE(holds);
}

TEST(ReplayWindow, TakesAnyOrderWithinItsSize) {
  ReplayWindow window;
  for (std::int64_t number = kSize; number >= 1; --number) CHECK_TRUE(window.accept(number));
  for (std::int64_t number = 1; number <= kSize; ++number) CHECK_FALSE(window.accept(number));
  CHECK_TRUE(window.accept(kSize + 1));
  CHECK_FALSE(window.accept(1));
}

TEST(ReplayWindow, TakesTheLargestNumbers) {
  ReplayWindow window;
  constexpr std::int64_t kLargest = std::numeric_limits<std::int64_t>::max();
  CHECK_TRUE(window.accept(kLargest));
  CHECK_FALSE(window.accept(kLargest));
  CHECK_TRUE(window.accept(kLargest - 1));
  CHECK_FALSE(window.accept(1));
}

TEST(ReplayWindow, IsOfOneSenderAndTheOneIdleForLongestIsForgotten) {
  ReplayWindows windows;
  CHECK_TRUE(windows.accept({7, 1}));
  CHECK_TRUE(windows.accept({8, 1}));
  CHECK_FALSE(windows.accept({7, 1}));
  CHECK_TRUE(windows.accept({7, 2}));
  for (std::int64_t sender = 100; windows.senders() < ReplayWindows::kMaxSenders; ++sender)
    CHECK_TRUE(windows.accept({sender, 1}));
  CHECK_TRUE(windows.accept({99, 1}));
  LONGS_EQUAL(ReplayWindows::kMaxSenders, windows.senders());
  CHECK_FALSE(windows.accept({7, 2}));
  CHECK_TRUE(windows.accept({8, 1}));  // forgotten
  for (std::int64_t sender = 1'000; sender < 101'000; ++sender) windows.accept({sender, 1});
  LONGS_EQUAL(ReplayWindows::kMaxSenders, windows.senders());
}
