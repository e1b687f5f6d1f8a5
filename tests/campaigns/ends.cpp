#include "tests/campaigns/ends.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/syscall.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <memory>

#include "tests/campaigns/remote_call.hpp"
#include "tests/hil/line_changes.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/hil/rig_fixture.hpp"

namespace strobe::ends {
namespace {

using campaigns::Verdict;
using hil::kMs;
using hil::LineChange;
using hil::LineChanges;
using hil::LineWatcher;
using hil::RawHost;
using hil::RigFixture;
using namespace std::chrono_literals;

constexpr const char* kOverrun = "longest active beyond the plan, ms";
constexpr std::int64_t kPeriod = 5 * kMs, kExposure = 250 * kMs;
// Of the shipped rig file.
constexpr std::int64_t kLampOn = 50'000, kTriggerOn = 20 * kMs;
/// A process that ends, and an output that cannot be set.
constexpr std::int64_t kAtOnce = kMs;
/// From the death of both to `strobed --safe`, which their service manager starts.
constexpr std::int64_t kBySafe = 2000 * kMs;
/// Of the clock's reading and the file's, far above both.
constexpr std::int64_t kSlack = 100 * kMs;
/// Longest that a trial waits, in the rig's time, for a moment of a shot, for what its fault leads to (a guardian that hangs
/// is given up after 5 s), and for the rig's end.
constexpr std::chrono::milliseconds kMomentComes = 3s, kSettle = 8s, kEnds = 3s;

bool is_stop(const Trial& trial) {
  return trial.fault == FaultKind::stop || (trial.fault == FaultKind::signal && trial.argument == SIGSTOP);
}

std::int64_t stated_ns(const Trial& trial) {
  if (trial.fault == FaultKind::signal && trial.victim == Victim::both)
    return trial.argument == SIGKILL ? kBySafe : kAtOnce;
  if (trial.fault == FaultKind::signal && !is_stop(trial)) return kAtOnce;
  return trial.victim == Victim::both ? kBySafe : hil::hang_known_within();
}

std::int64_t planned_on(const std::string& output) {
  if (output == "SHUTTER") return kExposure;
  return output == "TRIGGER" ? kTriggerOn : kLampOn;
}

/// What is put under strobed, and taken away again with the object.
class Fault {
 public:
  Fault(const Trial& trial, const RigFixture& rig, LineWatcher& watch) : trial_(trial), watch_(watch) {
    if (trial.victim != Victim::guardian) victims_.push_back(rig.worker());
    if (trial.victim != Victim::worker) victims_.push_back(rig.guardian());
  }
  ~Fault() {
    if (!is_stop(trial_)) return;
    for (const pid_t pid : victims_) kill(pid, SIGCONT);
  }

  /// The instant, or 0 if it could not be done.
  std::int64_t put() {
    const std::int64_t now = watch_.now_ns();
    if (trial_.fault == FaultKind::removed_chip) {
      watch_.unplug();
      return now;
    }
    for (const pid_t pid : victims_)
      if (pid == 0 || !put_under(pid)) return 0;
    return now;
  }

 private:
  bool put_under(pid_t pid) {
    switch (trial_.fault) {
      case FaultKind::signal:
        return kill(pid, trial_.argument) == 0;
      case FaultKind::stop:
        return kill(pid, SIGSTOP) == 0;
      case FaultKind::held_thread:
        return hold(drawn_of(threads_of(pid)));
      case FaultKind::ended_thread:
        return end(drawn_of(threads_of(pid)));
      case FaultKind::closed_file:
        return close_file(pid);
      case FaultKind::failing_call:
        return fail_call(pid);
      case FaultKind::no_descriptors:
        return limit(pid, RLIMIT_NOFILE, 0);
      case FaultKind::no_file_growth:
        return limit(pid, RLIMIT_FSIZE, 0);
      case FaultKind::no_memory:
        return limit(pid, RLIMIT_AS, 0);
      case FaultKind::no_real_time:
        return limit(pid, RLIMIT_RTTIME, 1);
      case FaultKind::removed_chip:
        break;
    }
    return false;
  }

  template <typename T>
  T drawn_of(const std::vector<T>& all) const {
    return all.empty() ? T{-1} : all[static_cast<std::size_t>(trial_.argument) % all.size()];
  }
  bool hold(pid_t thread) {
    held_.push_back(std::make_unique<HeldThread>(thread));
    return held_.back()->held();
  }
  static bool end(pid_t thread) {
    HeldThread held(thread);
    held.end();
    return !held.held();
  }
  bool close_file(pid_t pid) const {
    std::vector<int> files;
    std::error_code gone;
    for (const auto& entry :
         std::filesystem::directory_iterator("/proc/" + std::to_string(pid) + "/fd", gone))
      if (const int file = std::stoi(entry.path().filename().string()); file > STDERR_FILENO)
        files.push_back(file);
    std::sort(files.begin(), files.end());
    HeldThread held(pid);
    return held.call(SYS_close, {drawn_of(files)}) == 0;
  }
  bool fail_call(pid_t pid) const {
    const FailingCall call = failing_call(trial_.argument);
    HeldThread held(pid);
    return fail_system_call(held, pid, call.number, call.error);
  }
  static bool limit(pid_t pid, __rlimit_resource resource, rlim_t value) {
    const rlimit both{value, value};
    return prlimit(pid, resource, &both, nullptr) == 0;
  }

  const Trial& trial_;
  LineWatcher& watch_;
  std::vector<pid_t> victims_;
  std::vector<std::unique_ptr<HeldThread>> held_;
};

hil::RigFixtureOptions options_of(const Trial& trial) {
  hil::RigFixtureOptions options;
  options.rig_edits = {{"lag_ms = 310", "lag_ms = 70"}};  // shots that begin soon; nobody looks at the ball
  if (!trial.keeps) options.scene_addition = "[chip]\non_release = \"input\"\n";
  // As systemd's ExecStopPost: what is left when both are broken.
  if (trial.victim == Victim::both) options.shell = "\"$@\"; \"$1\" --safe --config \"$3\"";
  return options;
}

class Attempt {
 public:
  explicit Attempt(const Trial& trial) : trial_(trial), rig_(options_of(trial)), host_(rig_) {
    if (!rig_.ready()) throw std::runtime_error("strobed did not come up:\n" + rig_.log());
    if (!host_.wait_status()) throw std::runtime_error("strobed is silent:\n" + rig_.log());
    worker_ = rig_.worker();
    guardian_ = rig_.guardian();
  }

  Verdict run() {
    LineWatcher watch(rig_.chip_dir());
    if (reach_moment(watch)) {
      const std::int64_t at = watch.now_ns() + trial_.delay_us * 1000;
      while (watch.now_ns() < at) host_.listen(0ms);
      Fault fault(trial_, rig_, watch);
      put_ = fault.put();
      if (put_ != 0) settle(watch);
      ended_ = put_ != 0 && gone();
    }
    end(watch);
    if (put_ != 0) {
      judge_lines();
      judge_journal();
    }
    report();
    return std::move(verdict_);
  }

 private:
  /// False if no shot came so far.
  bool reach_moment(LineWatcher& watch) {
    if (trial_.moment == Moment::at_rest) return true;
    token_ = host_.arm();
    if (token_ == 0) return false;
    if (trial_.moment == Moment::armed) return true;
    fire();
    return moment_comes(watch);
  }

  bool moment_comes(LineWatcher& watch) const {
    switch (trial_.moment) {
      case Moment::trigger_on:
        return watch.wait_for("TRIGGER", 1, kMomentComes) != 0;
      case Moment::shutter_on:
        return watch.wait_for("SHUTTER", 1, kMomentComes) != 0;
      case Moment::flash:
        return watch.wait_for_nth("STROBE_A", 1, trial_.nth, kMomentComes) != 0;
      case Moment::shutter_off:
        return watch.wait_for("STROBE_A", 1, kMomentComes) != 0 && watch.wait_for("SHUTTER", 0, kMomentComes) != 0;
      case Moment::at_rest:
      case Moment::armed:
        break;
    }
    return true;
  }

  void fire() {
    strobe_msgs::command_t fire = host_.fire_command(token_, false);
    fire.plan.period_ns = kPeriod;
    fire.plan.shutter_open_ns = kExposure;
    fire.plan.impact_at_ns = 50 * kMs;
    host_.send(fire);
    token_ = 0;
    ++fired_;
  }

  bool gone() const { return testing::program_of(worker_).empty() && testing::program_of(guardian_).empty(); }

  /// Until strobed has ended or the shot is over; a firmware at rest is asked for a shot first.
  void settle(LineWatcher& watch) {
    if (trial_.moment == Moment::at_rest) token_ = host_.arm(500ms);
    if (token_ != 0) fire();
    const bool fires = trial_.moment != Moment::at_rest || fired_ > 0;
    const auto inactive = [&watch] {
      return std::none_of(hil::kOutputs.begin(), hil::kOutputs.end(),
                          [&watch](const std::string& line) { return watch.state(line).level != 0; });
    };
    const std::int64_t begin = watch.now_ns();
    // No output may come again for longer than a shot has from one to the next.
    std::int64_t quiet_since = begin;
    watch.wait_until(
        [&] {
          if (!inactive()) quiet_since = watch.now_ns();
          const std::int64_t now = watch.now_ns();
          const bool over = inactive() || now - begin > kExposure + kBySafe + kSlack;
          return (gone() && over) || now - quiet_since > (fires ? 400 : 100) * kMs;
        },
        kSettle);
    settled_ = watch.now_ns();
  }

  /// Whatever the fault has left of them: neither may outlive the trial.
  void end(const LineWatcher& watch) {
    rig_.sim().signal(SIGTERM);
    watch.wait_until([this] { return !rig_.sim().running(); }, kEnds);
    for (const pid_t pid : {guardian_, worker_})
      if (!testing::program_of(pid).empty()) kill(pid, SIGKILL);
  }

  void judge_lines() {
    const LineChanges changes = rig_.changes();
    const bool at_once = trial_.fault == FaultKind::signal && ended_ && !is_stop(trial_);
    for (const std::string& output : hil::kOutputs) {
      std::int64_t since = 0;
      int level = 0;
      for (const LineChange& change : changes.all()) {
        if (change.line != output || change.level == level) continue;
        level = change.level;
        if (level != 0) since = change.time_ns;
        if (level == 0 && change.time_ns >= put_) judge_interval(output, since, change.time_ns, at_once);
      }
      if (level != 0) judge_interval(output, since, INT64_MAX, at_once);
    }
    if (changes.rises("TRIGGER") > fired_)
      verdict_.violate("{} trigger pulses for {} shots", changes.rises("TRIGGER"), fired_);
  }

  void judge_interval(const std::string& output, std::int64_t from, std::int64_t to, bool at_once) {
    const std::int64_t due = at_once ? std::max(put_, from) : std::max(put_, from + planned_on(output));
    if (to > settled_) {
      // On a machine that stood still a shot can begin so late that the end of the trial cuts it off.
      if (settled_ - due <= stated_ns(trial_)) return;
      verdict_.violate("{} active {} ms after the fault, when the trial ended", output,
                       (settled_ - put_) / kMs);
      return;
    }
    overrun_ = std::max(overrun_, to - due);
  }

  /// Whole to the last event, with no gap.
  void judge_journal() {
    std::int64_t expected = 1;
    for (const auto& event : hil::read_log(rig_.journal()).events) {
      if (event.sequence != expected)
        verdict_.violate("the journal has event {} where {} was due", event.sequence, expected);
      expected = event.sequence + 1;
    }
    if (expected == 1) verdict_.violate("the journal has no event");
  }

  void report() {
    verdict_.trial = describe(trial_);
    verdict_.words = rig_.log();
    verdict_.rows = {{"fault", family(trial_)}, {"moment", name(trial_.moment)}};
    verdict_.count("not possible", put_ == 0);
    verdict_.count("ended strobed", ended_);
    verdict_.count("late", overrun_ > stated_ns(trial_));
    verdict_.largest[kOverrun] = static_cast<double>(overrun_) / kMs;
  }

  const Trial& trial_;
  RigFixture rig_;
  RawHost host_;
  pid_t worker_ = 0, guardian_ = 0;
  std::int64_t token_ = 0, put_ = 0, settled_ = 0;
  std::int64_t overrun_ = 0;  ///< longest that an output was active after it had to be inactive
  int fired_ = 0;
  bool ended_ = false;  ///< strobed of itself, within the trial
  Verdict verdict_;
};

}  // namespace

Verdict run_trial(const Trial& trial) { return Attempt(trial).run(); }

Verdict run_trial_despite_freezes(const Trial& trial) {
  Verdict verdict = run_trial(trial);
  for (int again = 0; again < 2 && verdict.counts["late"] > 0 && verdict.violations.empty(); ++again)
    verdict = run_trial(trial);
  if (verdict.counts["late"] > 0)
    verdict.violate("active for {:.1f} ms too long, {} ms are stated", verdict.largest[kOverrun],
                    stated_ns(trial) / kMs);
  return verdict;
}

namespace {

/// In the order of FaultKind: how often of 100, and in words.
const std::vector<int> kWeights{40, 6, 8, 8, 12, 14, 2, 3, 2, 2, 3};
constexpr std::array<const char*, 11> kFaults{"a signal",
                                              "stopped",
                                              "a thread stands still",
                                              "a thread ends",
                                              "a descriptor is closed",
                                              "",
                                              "no more descriptors",
                                              "no file may grow",
                                              "no more memory",
                                              "no real-time CPU",
                                              "the chip is removed"};
constexpr std::array<const char*, 6> kMoments{"at rest",    "armed", "trigger on",
                                              "shutter on", "flash", "shutter off"};
constexpr std::array<const char*, 3> kVictims{"worker", "guardian", "both"};

struct Call {
  const char* name;
  int number;
};
#define CALL(name) \
  Call { #name, SYS_##name }
// What the firmware's threads use while they work; exit(2) and rt_sigreturn(2) cannot fail.
constexpr std::array kCalls{CALL(read),
                            CALL(write),
                            CALL(pwrite64),
                            CALL(fdatasync),
                            CALL(fallocate),
                            CALL(ftruncate),
                            CALL(openat),
                            CALL(ioctl),
                            CALL(sendto),
                            CALL(sendmsg),
                            CALL(recvmsg),
                            CALL(ppoll),
#ifdef SYS_poll  // newer architectures have ppoll(2) only
                            CALL(poll),
#endif
                            CALL(clock_nanosleep),
                            CALL(futex),
                            CALL(mmap),
                            CALL(munmap),
                            CALL(kill),
                            CALL(wait4),
                            CALL(rt_sigtimedwait)};
#undef CALL
constexpr std::array kErrors{EIO, ENOSPC, EINTR, EAGAIN, ENOMEM, EBADF, EPERM};

std::string signal_words(int number) {
  const char* const abbreviation = sigabbrev_np(number);
  return abbreviation == nullptr ? fmt::format("signal {}", number) : fmt::format("SIG{}", abbreviation);
}

const char* victim_of(const Trial& trial) {
  return trial.fault == FaultKind::removed_chip ? "chip" : kVictims[static_cast<std::size_t>(trial.victim)];
}

/// Where one process must be left to see to the outputs.
bool of_one_process(const Trial& trial) {
  return trial.fault == FaultKind::stop || trial.fault == FaultKind::held_thread ||
         (trial.fault == FaultKind::signal && trial.argument == SIGSTOP);
}

}  // namespace

FailingCall failing_call(int argument) {
  const auto k = static_cast<std::size_t>(argument);
  const Call& call = kCalls[k % kCalls.size()];
  return {call.name, call.number, kErrors[k / kCalls.size() % kErrors.size()]};
}

std::string FailingCall::words() const { return fmt::format("{} {}", name, strerrorname_np(error)); }

Trial drawn(campaigns::Draws draws) {
  Trial trial;
  trial.fault = static_cast<FaultKind>(draws.weighted(kWeights));
  trial.argument = trial.fault == FaultKind::signal ? draws.between(1, 64) : draws.between(0, 999);
  trial.victim = static_cast<Victim>(draws.between(0, 2));
  if (of_one_process(trial) && trial.victim == Victim::both) trial.victim = Victim::worker;
  // Most of a shot is its train.
  trial.moment = static_cast<Moment>(draws.weighted({1, 1, 2, 2, 6, 1}));
  trial.nth = trial.moment == Moment::flash ? draws.between(1, 40) : 1;
  trial.delay_us = draws.between(0, 6000);
  // A chip that is removed and keeps its lines is beyond every program's reach.
  trial.keeps = draws.between(0, 3) != 0 && trial.fault != FaultKind::removed_chip;
  return trial;
}

const char* name(Moment moment) { return kMoments[static_cast<std::size_t>(moment)]; }

std::string family(const Trial& trial) {
  std::string fault = kFaults[static_cast<std::size_t>(trial.fault)];
  if (trial.fault == FaultKind::failing_call)
    fault = fmt::format("{} fails", failing_call(trial.argument).name);
  return fmt::format("{}, {}", victim_of(trial), fault);
}

std::string describe_fault(const Trial& trial) {
  if (trial.fault == FaultKind::signal)
    return fmt::format("{}, {}", victim_of(trial), signal_words(trial.argument));
  if (trial.fault == FaultKind::failing_call)
    return fmt::format("{}, {} fails", victim_of(trial), failing_call(trial.argument).words());
  return family(trial);
}

std::string describe(const Trial& trial) {
  std::string moment = name(trial.moment);
  if (trial.moment == Moment::flash) moment += fmt::format(" {}", trial.nth);
  return fmt::format("{}, {} + {} us, chip {}", describe_fault(trial), moment, trial.delay_us,
                     trial.keeps ? "keeps" : "lets go");
}

}  // namespace strobe::ends
