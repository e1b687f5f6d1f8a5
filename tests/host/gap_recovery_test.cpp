// When the end of a series has been fetched, or is given up.
#include "host/session/gap_recovery.hpp"

#include "tests/host/synthetic_shot.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using strobe::host::GapRecovery;
using strobe::host::Session;

constexpr std::int64_t kSecond = 1'000'000'000;

}  // namespace

TEST_GROUP(GapRecoveryOfAHost) {
  Session session{{}, 5};
  std::int64_t start_ns = 100 * kSecond;
  GapRecovery recovery{start_ns};

  void status(std::int64_t last_sequence, std::int64_t now_ns) {
    strobe_msgs::status_t message{};
    message.boot_id = 7;
    message.last_sequence = last_sequence;
    session.on_status(message, now_ns);
  }
  void event(std::int64_t sequence, std::int64_t now_ns) {
    strobe_msgs::event_t message{};
    message.boot_id = 7;
    message.sequence = sequence;
    session.on_event(message, now_ns);
  }
  bool finished(double after_s) {
    return recovery.finished(session, start_ns + static_cast<std::int64_t>(after_s * 1e9));
  }
};

TEST(GapRecoveryOfAHost, WaitsForAStatusThatWasSentAfterItsStart) {
  event(1, start_ns - kSecond);
  status(1, start_ns - kSecond);
  CHECK_FALSE(finished(0.3));
  status(1, start_ns + kSecond / 2);
  CHECK_TRUE(finished(0.6));
}

TEST(GapRecoveryOfAHost, EndsAtOnceWhenTheFirmwareIsSilentAndNothingIsMissing) {
  event(1, start_ns - kSecond);
  CHECK_TRUE(finished(0.0));  // and never was heard: nobody can be asked
  status(1, start_ns - 3 * kSecond);
  CHECK_TRUE(finished(0.0));
}

TEST(GapRecoveryOfAHost, OutlastsANetworkThatIsCutForTenSeconds) {
  status(2, start_ns - kSecond);
  event(1, start_ns - kSecond);
  CHECK_FALSE(finished(0.0));
  CHECK_FALSE(finished(11.0));
  event(2, start_ns + 12 * kSecond);
  status(2, start_ns + 12 * kSecond);
  CHECK_TRUE(finished(12.1));
}

TEST(GapRecoveryOfAHost, GivesUpWhenNothingNewComesAndAfterAMinuteWhateverComes) {
  status(1000, start_ns);
  CHECK_FALSE(finished(0.0));
  CHECK_TRUE(finished(15.1));
  GapRecovery slow(start_ns);
  bool ended = false;
  for (int second = 0; second < 60; ++second) {
    event(second + 1, start_ns + second * kSecond);
    ended = ended || slow.finished(session, start_ns + second * kSecond);
  }
  CHECK_FALSE(ended);
  CHECK_TRUE(slow.finished(session, start_ns + 61 * kSecond));
}
