// What ran instead of a thread: drawn timelines of switches and interrupts, whose occupants the draw knows.
#include "firmware/linux/core_timeline.hpp"

#include <cstdio>
#include <map>
#include <random>
#include <string>

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::firmware;

namespace {

using Kind = Culprit::Kind;
using Record = CoreRecord::Kind;

constexpr pid_t kLoop = 100;
constexpr unsigned kSeed = 20260;
constexpr int kDraws = 500;

MonoTime at_us(std::int64_t us) { return from_ns(us * 1000); }

/// The life of a thread on CPU 1, another CPU beside it, and who had the CPU when.
class DrawnTimeline {
 public:
  explicit DrawnTimeline(std::mt19937& random) : random_(random) {
    timeline.cpus = {0, 1};
    timeline.since = now_;
    timeline.tells_wakings = true;
    while (now_ < at_us(100'000)) {
      stay(Kind::core_stopped, 0, 2'000);
      one_in(2) ? be_preempted() : sleep();
    }
    make_noise();
  }

  CoreTimeline timeline;

  /// By the longest sum within the span.
  NumberedCulprit truth(MonoTime from, MonoTime to) const {
    std::map<std::pair<Kind, int>, Duration> sums;
    NumberedCulprit longest;
    for (const Stay& each : stays_) {
      const Duration within = std::min(each.to, to) - std::max(each.from, from);
      if (within <= Duration{}) continue;
      Duration& sum = sums[{each.kind, each.number}];
      sum += within;
      if (sum > longest.took) longest = {each.kind, each.number, sum};
    }
    return longest;
  }

 private:
  struct Stay {
    MonoTime from, to;
    Kind kind;
    int number;
  };

  int draw(int limit) { return static_cast<int>(random_() % static_cast<unsigned>(limit)); }
  bool one_in(int n) { return draw(n) == 0; }
  Duration drawn_span(int longest_us) { return Duration{1'000 + draw(longest_us * 1'000)}; }

  void record(Record kind, int number = 0) {
    CoreRecord made;
    made.at = now_;
    made.cpu = 1;
    made.kind = kind;
    made.number = number;
    timeline.records.push_back(made);
  }
  void switch_to(pid_t next, bool preempted) {
    record(Record::switched);
    timeline.records.back().from = running_;
    timeline.records.back().to = next;
    timeline.records.back().preempted = preempted;
    running_ = next;
  }
  void pass(Kind kind, int number, Duration span) {
    stays_.push_back({now_, now_ + span, kind, number});
    now_ += span;
  }
  /// With interrupts, and softirqs that are themselves interrupted, unless the thread sleeps: then it is
  /// sleep that keeps it, whatever its CPU does.
  void stay(Kind kind, int number, int longest_us) {
    const bool asleep = kind == Kind::page_fault || (kind == Kind::waited && number == 1);
    const auto as = [&](Kind other, int n) { return asleep ? std::pair{kind, 0} : std::pair{other, n}; };
    const auto spend = [&](std::pair<Kind, int> who, Duration span) { pass(who.first, who.second, span); };
    const int longest = one_in(5) ? 10 * longest_us : longest_us;
    spend(as(kind, asleep ? 0 : number), drawn_span(longest));
    if (!one_in(2)) return;
    const int irq = 20 + draw(4), vector = draw(10);
    record(Record::interrupt_begin, irq);
    spend(as(Kind::interrupt, irq), drawn_span(longest));
    record(Record::interrupt_end, irq);
    record(Record::softirq_begin, vector);
    spend(as(Kind::softirq, vector), drawn_span(longest));
    record(Record::interrupt_begin, irq);
    spend(as(Kind::interrupt, irq), drawn_span(10));
    record(Record::interrupt_end, irq);
    spend(as(Kind::softirq, vector), drawn_span(10));
    record(Record::softirq_end, vector);
    spend(as(kind, asleep ? 0 : number), drawn_span(longest));
  }
  void be_preempted() {
    const int others = 1 + draw(3);
    for (int i = 0; i < others; ++i) {
      switch_to(200 + draw(5) + 10 * i, true);
      stay(Kind::thread, running_, 1'500);
    }
    switch_to(kLoop, false);
  }
  void sleep() {
    const bool faults = one_in(3);
    switch_to(one_in(2) ? 0 : 300, false);
    // The number 1 says to stay() that the thread sleeps.
    stay(faults ? Kind::page_fault : Kind::waited, 1, 1'500);
    if (one_in(2)) {
      switch_to(running_ == 0 ? 301 : 0, false);
      stay(faults ? Kind::page_fault : Kind::waited, 1, 1'500);
    }
    record(Record::woken);
    if (running_ == 0) {
      stay(Kind::waited, 0, 500);
    } else {
      stay(Kind::thread, running_, 1'500);
    }
    switch_to(kLoop, false);
    if (!faults) return;
    pass(Kind::core_stopped, 0, microseconds(3));
    record(Record::page_fault);
  }
  /// Of the other CPU; its records are not in order with the first's.
  void make_noise() {
    pid_t running = 0;
    for (MonoTime t = at_us(10); t < now_; t += drawn_span(800)) {
      CoreRecord made;
      made.at = t;
      made.from = running;
      made.to = running = running == 0 ? 400 + draw(9) : 0;
      timeline.records.push_back(made);
    }
  }

  std::mt19937& random_;
  std::vector<Stay> stays_;
  pid_t running_ = kLoop;
  MonoTime now_ = at_us(0);
};

CoreRecord switched(std::int64_t us, pid_t from, pid_t to, bool preempted, int cpu = 0) {
  CoreRecord made;
  made.at = at_us(us);
  made.cpu = cpu;
  made.from = from;
  made.to = to;
  made.preempted = preempted;
  return made;
}

CoreRecord woken(std::int64_t us) {
  CoreRecord made;
  made.at = at_us(us);
  made.kind = Record::woken;
  return made;
}

CoreTimeline of(std::vector<CoreRecord> records, bool tells_wakings = true) {
  return {{0, 1}, at_us(0), tells_wakings, std::move(records)};
}

void expect(Kind kind, int number, std::int64_t took_us, const NumberedCulprit& found) {
  CHECK_EQUAL(static_cast<int>(kind), static_cast<int>(found.kind));
  CHECK_EQUAL(number, found.number);
  CHECK_EQUAL(took_us, found.took / microseconds(1));
}

}  // namespace

TEST_GROUP(CoreTimeline){};

TEST(CoreTimeline, TheLongestOccupantOfADrawnTimelineIsFound) {
  std::printf(" seed %u", kSeed);
  std::mt19937 random(kSeed);
  std::map<Kind, int> found_of;
  for (int i = 0; i < kDraws; ++i) {
    const DrawnTimeline drawn(random);
    const MonoTime from = at_us(static_cast<std::int64_t>(random() % 70'000));
    const MonoTime to = from + microseconds(100 + static_cast<std::int64_t>(random() % 30'000));
    const NumberedCulprit truth = drawn.truth(from, to);
    const NumberedCulprit found = find_culprit(drawn.timeline, kLoop, from, to);
    CHECK_EQUAL(static_cast<int>(truth.kind), static_cast<int>(found.kind));
    CHECK_EQUAL(truth.number, found.number);
    CHECK_EQUAL(truth.took.count(), found.took.count());
    ++found_of[found.kind];
  }
  for (const Kind kind : {Kind::thread, Kind::interrupt, Kind::softirq, Kind::page_fault, Kind::waited,
                          Kind::core_stopped})
    CHECK_TRUE(found_of[kind] > 0);
}

TEST(CoreTimeline, AThreadThatWasWokenWaitsForTheCpuWhereItRunsNext) {
  // It slept on CPU 0, was to go on on CPU 1, and there 7 went on for 900 us.
  const auto timeline = of({switched(100, 1, kLoop, false), switched(200, kLoop, 5, false), woken(1'000),
                            switched(300, 0, 7, false, 1), switched(1'900, 7, kLoop, true, 1)});
  expect(Kind::thread, 7, 900, find_culprit(timeline, kLoop, at_us(950), at_us(1'950)));
}

TEST(CoreTimeline, WhereWakingsAreNotToldWhatRanMeanwhileIsNamed) {
  const auto behind = [](pid_t other) {
    return of({switched(100, kLoop, other, false), switched(900, other, kLoop, false)}, false);
  };
  expect(Kind::thread, 7, 800, find_culprit(behind(7), kLoop, at_us(50), at_us(950)));
  expect(Kind::waited, 0, 800, find_culprit(behind(0), kLoop, at_us(50), at_us(950)));
}

TEST(CoreTimeline, ACoreThatKeptTheThreadAndStoodStillIsNamedThoughNothingWasRecordedOfIt) {
  expect(Kind::core_stopped, 0, 500, find_culprit(of({}), kLoop, at_us(100), at_us(600)));
  // What ran on the other core is nobody's fault.
  expect(Kind::core_stopped, 0, 500,
         find_culprit(of({switched(150, 0, 7, false)}), kLoop, at_us(100), at_us(600)));
}

TEST(CoreTimeline, NothingIsNamedForASpanBeforeTheOldestRecord) {
  CoreTimeline timeline = of({switched(300, kLoop, 7, true), switched(500, 7, kLoop, false)});
  timeline.since = at_us(300);
  expect(Kind::unknown, 0, 0, find_culprit(timeline, kLoop, at_us(299), at_us(600)));
  expect(Kind::thread, 7, 200, find_culprit(timeline, kLoop, at_us(300), at_us(600)));
}

TEST(CoreTimeline, ACulpritIsToldInWords) {
  const auto words = [](Kind kind, const char* name) { return in_words({kind, name, microseconds(912)}); };
  STRCMP_EQUAL("kworker/1:2 (pid 71) ran for 912 us", words(Kind::thread, "kworker/1:2 (pid 71)").c_str());
  STRCMP_EQUAL("interrupt 24 (eth0) ran for 912 us", words(Kind::interrupt, "interrupt 24 (eth0)").c_str());
  STRCMP_EQUAL("softirq NET_RX ran for 912 us", words(Kind::softirq, "NET_RX").c_str());
  STRCMP_EQUAL("the core stood still for 912 us", words(Kind::core_stopped, "").c_str());
  STRCMP_EQUAL("it slept for 912 us, and nothing else kept it", words(Kind::waited, "").c_str());
  STRCMP_EQUAL("a page fault held it for 912 us", words(Kind::page_fault, "").c_str());
}
