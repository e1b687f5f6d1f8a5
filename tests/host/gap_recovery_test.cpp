#include "host/session/gap_recovery.hpp"

#include "tests/host/synthetic_shot.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using strobe::host::GapRecovery;
using strobe::host::Session;

constexpr Duration kSecond = std::chrono::seconds{1};

}  // namespace

TEST_GROUP(GapRecoveryOfAHost) {
  Session session{{}, 5};
  HostTime start{100 * kSecond};
  GapRecovery recovery{start};

  void status(std::int64_t last_sequence, HostTime now) {
    strobe_msgs::status_t message{};
    message.boot_id = 7;
    message.last_sequence = last_sequence;
    session.on_status(message, now);
  }
  void event(std::int64_t sequence, HostTime now) {
    strobe_msgs::event_t message{};
    message.boot_id = 7;
    message.sequence = sequence;
    session.on_event(message, now);
  }
  bool finished(double after_s) { return recovery.finished(session, start + from_seconds(after_s)); }
};

TEST(GapRecoveryOfAHost, WaitsForAStatusThatWasSentAfterItsStart) {
  event(1, start - kSecond);
  status(1, start - kSecond);
  CHECK_FALSE(finished(0.3));
  status(1, start + kSecond / 2);
  CHECK_TRUE(finished(0.6));
}

TEST(GapRecoveryOfAHost, EndsAtOnceWhenTheFirmwareIsSilentAndNothingIsMissing) {
  event(1, start - kSecond);
  CHECK_TRUE(finished(0.0));  // and never was heard: nobody can be asked
  status(1, start - 3 * kSecond);
  CHECK_TRUE(finished(0.0));
}

TEST(GapRecoveryOfAHost, OutlastsANetworkThatIsCutForTenSeconds) {
  status(2, start - kSecond);
  event(1, start - kSecond);
  CHECK_FALSE(finished(0.0));
  CHECK_FALSE(finished(11.0));
  event(2, start + 12 * kSecond);
  status(2, start + 12 * kSecond);
  CHECK_TRUE(finished(12.1));
}

TEST(GapRecoveryOfAHost, GivesUpWhenNothingNewComesAndAfterAMinuteWhateverComes) {
  status(1000, start);
  CHECK_FALSE(finished(0.0));
  CHECK_TRUE(finished(15.1));
  GapRecovery slow(start);
  bool ended = false;
  for (int second = 0; second < 60; ++second) {
    event(second + 1, start + second * kSecond);
    ended = ended || slow.finished(session, start + second * kSecond);
  }
  CHECK_FALSE(ended);
  CHECK_TRUE(slow.finished(session, start + 61 * kSecond));
}
