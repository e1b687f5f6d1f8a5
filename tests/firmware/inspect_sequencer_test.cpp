#include "firmware/flash_sequencer/inspect.hpp"

#include "tests/firmware/flash_sequencer_bench.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::testing;

TEST_GROUP(AnswerTimes) {
  FlashSequencerBench bench;

  CheckItem found(CheckItem::Verdict expected) {
    const CheckItem item = answer_times(bench.link, bench.line);
    CHECK_TEXT(item.verdict == expected, item.words.c_str());
    return item;
  }
};

TEST(AnswerTimes, AreThoseOfTheLine) {
  const CheckItem item = found(CheckItem::Verdict::ok);
  // HELLO's 10 bytes and the identity's 20 take .3 ms, and .1 ms lies between; a thread is woken .03 ms late in the mean.
  STRCMP_CONTAINS("answers within 0.5 ms (half of 100 requests)", item.words.c_str());
}

TEST(AnswerTimes, OfAnAdapterThatHoldsBytesBackAreAdvisedAgainst) {
  bench.line.reader_delay = milliseconds(8);
  STRCMP_CONTAINS("latency_timer", found(CheckItem::Verdict::advice).words.c_str());
}

TEST(AnswerTimes, AreAFaultWhereNothingAnswers) {
  bench.line.answers = false;
  STRCMP_CONTAINS("request 0 of 100 was not answered in 100 ms", found(CheckItem::Verdict::fault).words.c_str());
  bench.line.here = false;
  STRCMP_CONTAINS("the line is gone", found(CheckItem::Verdict::fault).words.c_str());
}
