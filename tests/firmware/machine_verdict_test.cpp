#include "firmware/linux/machine_verdict.hpp"
#include "firmware/linux/smi_counter.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/firmware/system_tree.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;
using Verdict = CheckItem::Verdict;

namespace {

constexpr MonoTime kStart = from_ns(5'000'000'000);

/// A machine that stands still at instants known beforehand: a stop of `length` begins at `at`.
struct Stop {
  MonoTime at;
  Duration length{};
};

class StoppingClock final : public Clock {
 public:
  explicit StoppingClock(std::vector<Stop> stops) : stops_(std::move(stops)) {}
  MonoTime now() noexcept override { return go_to(now_ + nanoseconds(100)); }
  MonoTime spin_until(MonoTime instant) noexcept override { return go_to(std::max(now_, instant)); }
  void sleep_until(MonoTime instant) { go_to(std::max(now_ + microseconds(50), instant)); }

 private:
  MonoTime go_to(MonoTime instant) {
    now_ = instant;
    while (next_ < stops_.size() && stops_[next_].at <= now_) {
      now_ = std::max(now_, stops_[next_].at + stops_[next_].length);
      ++next_;
    }
    return now_;
  }
  std::vector<Stop> stops_;
  std::size_t next_ = 0;
  MonoTime now_ = kStart;
};

Rig rig_of_half_a_second() {
  Rig rig;
  rig.plan.train = Train::free;
  rig.plan.exposure = milliseconds(500);
  rig.real_time.cpu = 1;
  return rig;
}

MachineTrial played(const Rig& rig, const std::vector<Stop>& stops, Duration length) {
  StoppingClock clock(stops);
  TrialTrace trace(static_cast<std::size_t>(length / rig.lamps.min_period) + 1);
  play_trains(rig, clock, [&](MonoTime until) { clock.sleep_until(until); }, kStart + length, trace);
  MachineTrial trial;
  trace.flashes.resize(trace.count);
  trial.flashes = trace.flashes;
  trial.played = trace.played;
  return trial;
}

/// Stops of a Poisson process.
std::vector<Stop> drawn_stops(std::mt19937& random, double per_second, Duration stop, Duration length) {
  std::exponential_distribution<double> gap_s(per_second);
  std::vector<Stop> stops;
  for (MonoTime at = kStart; at < kStart + length; at += from_seconds(gap_s(random)))
    if (at != kStart) stops.push_back({at, stop});
  return stops;
}

std::size_t later(const MachineTrial& trial, Duration limit) {
  return static_cast<std::size_t>(std::count_if(trial.flashes.begin(), trial.flashes.end(),
                                                [&](const TrialFlash& f) { return f.lateness() > limit; }));
}

}  // namespace

TEST_GROUP(SmiCounter) {
  strobe::testing::SystemTree tree;
};

TEST_GROUP(MachineVerdict) {
  strobe::testing::SystemTree tree;
  Rig rig = rig_of_half_a_second();
  MachineCounters counters;

  CheckItem item(const MachineTrial& trial, const std::string& name, const MachineCounters& after) const {
    const auto items = machine_verdict(rig, trial, counters, after, tree.files());
    const auto at =
        std::find_if(items.begin(), items.end(), [&](const CheckItem& i) { return i.name == name; });
    CHECK_TEXT(at != items.end(), name.c_str());
    CHECK_TEXT(at->words.find('\n') == std::string::npos, "one line");
    return *at;
  }
  CheckItem item(const MachineTrial& trial, const std::string& name) const {
    return item(trial, name, counters);
  }
  void says(const CheckItem& found, Verdict verdict, const std::string& part) const {
    CHECK_TEXT(found.verdict == verdict, (found.name + ": " + found.words).c_str());
    STRCMP_CONTAINS(part.c_str(), found.words.c_str());
  }
  MachineTrial accused_of(const Culprit& culprit) const {
    MachineTrial trial = played(rig, {{kStart + milliseconds(900), milliseconds(20)}}, milliseconds(5000));
    for (const TrialFlash& flash : trial.flashes)
      if (flash.lateness() > rig.tolerance.late) trial.late.push_back({flash, culprit});
    CHECK_EQUAL(1U, trial.late.size());
    return trial;
  }
};

TEST(MachineVerdict, OfAMachineThatNeverStopsIsThatItCanFire) {
  const MachineTrial trial = played(rig, {}, milliseconds(10'000));
  // Trains of 500 ms with rests of 125 ms: 8 s of 10, at 1.5 ms.
  CHECK_TRUE(std::abs(to_seconds(trial.played) - 8.0) < 0.5);
  CHECK_EQUAL(0U, later(trial, Duration{}));
  says(item(trial, "trial"), Verdict::ok, "at most 0.00 us late; 0 later than late_us, 0 than abort_late_us");
  says(item(trial, "culprits"), Verdict::ok, "none");
  // Rule of three: 3 / 8 s x 0.5 s.
  CHECK_TRUE(std::abs(abort_risk(rig, trial).of_shot_max - (1.0 - std::exp(-0.1875))) < 0.01);
  says(item(trial, "machine"), Verdict::ok, "this machine can fire: no flash would be late (95 %: of 100 shots fewer than 17");
}

TEST(MachineVerdict, CountsEachStopOnceHoweverManyFlashesItCovers) {
  std::vector<Stop> stops;
  for (int i = 1; i <= 8; ++i) stops.push_back({kStart + milliseconds(1000 * i + 300), milliseconds(40)});
  const MachineTrial trial = played(rig, stops, milliseconds(10'000));
  std::size_t hit = 0;
  for (const Stop& stop : stops)
    hit += std::any_of(trial.flashes.begin(), trial.flashes.end(), [&](const TrialFlash& flash) {
      return flash.issued >= stop.at + stop.length && flash.due <= stop.at + stop.length && flash.lateness() > Duration{};
    });
  CHECK_EQUAL(hit, later(trial, rig.tolerance.abort_late));
  CHECK_TRUE(hit >= 4);  // those that did not fall into rests, a fifth of the time
}

TEST(MachineVerdict, ExpectsAsManyLostShotsAsTheDrawnStopsCost) {
  constexpr unsigned kSeed = 20261128;
  std::printf("seed %u ", kSeed);
  std::mt19937 random(kSeed);
  for (const double per_second : {0.5, 2.0}) {
    constexpr Duration kLength = milliseconds(100'000);
    const MachineTrial trial = played(rig, drawn_stops(random, per_second, milliseconds(20), kLength), kLength);
    // A shot of 0.5 s meets no stop with exp(-rate x 0.5 s); the 20 ms are hit from before, too.
    const double truth = -std::expm1(-per_second * 0.5);
    const auto aborts = static_cast<double>(later(trial, rig.tolerance.abort_late));
    // Four standard deviations of a Poisson count, and 2 x 20 ms of 500 ms at the ends of trains.
    const double tolerance = truth * (4.0 / std::sqrt(aborts) + 0.08);
    DOUBLES_EQUAL(truth, abort_risk(rig, trial).of_shot, tolerance);
    CHECK_TRUE(abort_risk(rig, trial).of_shot < abort_risk(rig, trial).of_shot_max);
  }
}

TEST(MachineVerdict, StopsShorterThanTheAbortAreLateOnly) {
  MachineTrial trial = played(rig, {{kStart + milliseconds(900), milliseconds(3)}}, milliseconds(5000));
  rig.tolerance.abort_late = milliseconds(4);
  CHECK_TRUE(later(trial, rig.tolerance.late) >= 1);
  says(item(trial, "machine"), Verdict::ok, "this machine can fire: some flashes would be late, but no shot aborted");
}

TEST(MachineVerdict, NamesAThreadThatIsNotBelowTheLoopAndLowersIt) {
  // A name with blanks and brackets, as threads may have; the 40th number of its stat is the priority.
  std::string stat = "71 (a) b) S";
  for (int i = 4; i <= 39; ++i) stat += " 0";
  tree.put("proc/71/stat", stat + " 90 1 0");
  const auto found = item(accused_of({Culprit::Kind::thread, "a) b (pid 71)", milliseconds(20)}), "machine");
  says(found, Verdict::advice, "but some ");
  says(found, Verdict::advice, "a) b (pid 71) ran for ");
  says(found, Verdict::advice, "its real-time priority, 90, is not below [real_time] priority (80)");
  const auto culprits = item(accused_of({Culprit::Kind::thread, "a) b (pid 71)", milliseconds(20)}), "culprits");
  CHECK_EQUAL(1U, culprits.paste.size());
  STRCMP_EQUAL("chrt -a -f -p 1 71", culprits.paste[0].c_str());
}

TEST(MachineVerdict, SaysOfEachKindWhatToChange) {
  const auto cure = [&](Culprit::Kind kind, const std::string& name, const std::string& part) {
    says(item(accused_of({kind, name, milliseconds(20)}), "machine"), Verdict::advice, part);
  };
  cure(Culprit::Kind::thread, "kworker/1:2 (pid 33)", "see isolation");
  cure(Culprit::Kind::thread, "ended (pid 34)", "a priority below [real_time] priority (80)");
  cure(Culprit::Kind::interrupt, "interrupt 24 (eth0)", "--move-interrupts");
  cure(Culprit::Kind::softirq, "NET_RX", "see isolation and interrupts");
  cure(Culprit::Kind::page_fault, "", "see memory");
  cure(Culprit::Kind::waited, "", "see throttling, and cpu.rt_runtime_us of this control group; or the machine stood");
  tree.put("proc/35/stat", "35 (make) R 1");  // an ordinary one
  cure(Culprit::Kind::thread, "make (pid 35)", "the kernel held real-time threads back");
  says(item(accused_of({Culprit::Kind::waited, "", milliseconds(2)}), "machine"), Verdict::advice,
       "see latency and preemption");
  cure(Culprit::Kind::core_stopped, "", "an interrupt, or the board's firmware, and this user is not shown which");
  tree.put("sys/kernel/tracing/events/irq/irq_handler_entry/id", "71");
  cure(Culprit::Kind::core_stopped, "", "(SMI)");
  tree.put("proc/cpuinfo", "flags : fpu sse2 hypervisor lahf_lm");
  cure(Culprit::Kind::core_stopped, "", "take a real machine");
}

TEST(MachineVerdict, OfMoreThanHalfOfTheShotsLostIsThatItCannotFire) {
  std::vector<Stop> stops;
  for (int i = 1; i <= 40; ++i) stops.push_back({kStart + milliseconds(250 * i), milliseconds(20)});
  says(item(played(rig, stops, milliseconds(10'000)), "machine"), Verdict::fault, "this machine cannot fire, ");
  MachineTrial starved;
  starved.starved = true;
  says(item(starved, "machine"), Verdict::fault, "this machine cannot fire, all shots would be aborted");
  says(item(starved, "trial"), Verdict::advice, "no CPU at all");
}

TEST(MachineVerdict, SaysWhyThereAreNoNames) {
  MachineTrial trial = accused_of({});
  trial.not_named = "perf_event_open: Permission denied";
  says(item(trial, "culprits"), Verdict::advice, "no names: perf_event_open: Permission denied");
  says(item(trial, "machine"), Verdict::advice, "shots would be aborted: see above");
}

TEST(MachineVerdict, TellsOfHeatFrequencyAndSteal) {
  const MachineTrial trial = played(rig, {}, milliseconds(1000));
  says(item(trial, "heat"), Verdict::ok, "the kernel does not say");
  const auto stat = [](int stolen) {
    return "cpu  1 2 3 4 5 6 7 99 9 10\ncpu0 1 2 3 4 5 6 7 98 9 10\ncpu1 1 2 3 4 5 6 7 " + std::to_string(stolen) +
           " 9 10";
  };
  const std::string cpu = "sys/devices/system/cpu/cpu1/";
  tree.put(cpu + "thermal_throttle/core_throttle_count", "5");
  tree.put(cpu + "cpufreq/stats/total_trans", "100");
  tree.put("proc/stat", stat(20));
  counters = read_counters({1}, tree.files());
  for (const char* name : {"heat", "frequency", "steal"}) says(item(trial, name), Verdict::ok, "");
  tree.put(cpu + "thermal_throttle/core_throttle_count", "7");
  tree.put(cpu + "cpufreq/stats/total_trans", "103");
  tree.put("proc/stat", stat(32));
  const MachineCounters after = read_counters({1}, tree.files());
  says(item(trial, "heat", after), Verdict::advice, "slowed down 2 times");
  says(item(trial, "frequency", after), Verdict::advice, "changed 3 times");
  says(item(trial, "steal", after), Verdict::advice, "120 ms of the loop's CPU");
}

TEST(MachineVerdict, TellsHowOftenTheBoardsFirmwareHadTheCpu) {
  const MachineTrial trial = played(rig, {}, milliseconds(1000));
  says(item(trial, "smi"), Verdict::ok, "the kernel does not say");
  MachineCounters after;
  after.smis = 0;
  says(item(trial, "smi", after), Verdict::ok, "none");
  after.smis = 3;
  says(item(trial, "smi", after), Verdict::advice, "had the loop's CPU 3 times: switch off power saving");
}

TEST(SmiCounter, CountsTheEventThatTheKernelNamesAndNothingWhereItNamesNone) {
  CHECK_EQUAL(-1, SmiCounter({0}, tree.files()).count());
  tree.put("sys/bus/event_source/devices/msr/type", std::to_string(PERF_TYPE_SOFTWARE));
  tree.put("sys/bus/event_source/devices/msr/events/smi", "event=0x00");  // PERF_COUNT_SW_CPU_CLOCK [ns]
  const SmiCounter counter({0}, tree.files());
  const long before = counter.count();
  if (before < 0) return;  // this user may not count
  while (counter.count() == before) continue;
  CHECK_EQUAL(-1, SmiCounter({1 << 20}, tree.files()).count());  // there is no such CPU
}

TEST(MachineVerdict, ReadsWhatARaspberryPisFirmwareSays) {
  const MachineTrial trial = played(rig, {}, milliseconds(1000));
  const std::string file = "sys/devices/platform/soc/soc:firmware/get_throttled";
  tree.put(file, "50000");  // was so since the start, is no longer
  says(item(trial, "heat", read_counters({1}, tree.files())), Verdict::ok, "cool enough");
  tree.put(file, "50005");
  says(item(trial, "heat", read_counters({1}, tree.files())), Verdict::advice, "under-voltage");
  tree.put(file, "e0008");
  says(item(trial, "heat", read_counters({1}, tree.files())), Verdict::advice, "too hot");
}

TEST(MachineVerdict, KnowsKernelsThatAreBad) {
  const auto kernel = [&](const std::string& release, const std::string& flags) {
    tree.put("proc/sys/kernel/osrelease", release);
    tree.put("proc/sys/kernel/version", flags);
    return kernel_item(tree.files());
  };
  const std::string rt = "#1 SMP PREEMPT_RT ";
  says(kernel("6.12.84+deb13-rt-amd64", rt), Verdict::ok, "6.12.84, nothing is known against it");
  says(kernel("6.12.87+deb13-rt-amd64", rt), Verdict::advice, "6.12.87: PREEMPT_RT is delayed");
  says(kernel("6.12.87+deb13-amd64", "#1 SMP PREEMPT_DYNAMIC"), Verdict::ok, "6.12.87");
  says(kernel("6.1.0-50-rt-amd64", rt + "Debian 6.1.176-1 (2026-11-02)"), Verdict::ok, "6.1.176");
}
