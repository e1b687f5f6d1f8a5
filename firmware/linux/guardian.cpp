#include "firmware/linux/guardian.hpp"

#include <poll.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <system_error>
#include <thread>

#include "common/messages/danger.hpp"
#include "firmware/linux/console.hpp"
#include "firmware/linux/real_time.hpp"
#include "firmware/linux/service_notify.hpp"
#include "firmware/linux/signals.hpp"
#include "firmware/linux/system_clock.hpp"
#include "firmware/linux/watchdog.hpp"

namespace strobe::firmware {

namespace {

constexpr int kAnywhere = -1;  // for a CPU
constexpr Duration kPatience = milliseconds(1000);
/// Outputs are set within a millisecond: whoever takes longer died there, or hangs in the kernel.
constexpr Duration kSettingPatience = milliseconds(100);
constexpr int kAlarms = 6;
constexpr int kAlarmEvery_ms = 400;
constexpr Duration kTimeToStop = milliseconds(15'000);  // a slow disk may keep the journal's last lines
// for a worker that was asked to stop since its publisher hangs
constexpr Duration kGrace = milliseconds(1000);
constexpr Duration kWordsEvery =
    milliseconds(10'000);  // the service manager hears when a host was last heard

HeldOutputs* outputs_at_fault = nullptr;

[[noreturn]] void become_worker(const Work& work, SharedStatus& page, HeldOutputs& outputs) {
  outputs_at_fault = &outputs;
  set_worker_signal_policy([] { outputs_at_fault->make_inactive(); });
  setsid();  // no signal to a terminal's or a shell's group reaches both
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != page.guardian_pid) _exit(kExitFailed);
  // A core dump of locked memory would take seconds, with the outputs as they are.
  prctl(PR_SET_DUMPABLE, 0);
  const int status = work(page);
  std::fflush(nullptr);
  _exit(status);
}

class Guardian {
 public:
  Guardian(const Rig& rig, pid_t worker, SharedStatus& page, HeldOutputs& outputs, const OutputAccess& access,
           const TellDanger& tell)
      : rig_(rig),
        worker_(worker),
        page_(page),
        outputs_(outputs),
        access_(access),
        tell_(tell),
        service_(ServiceNotify::from_environment()),
        watchdog_(Watchdog::publisher_timeout_for(service_.watchdog())) {}

  int run() {
    lock_memory();  // what is wrong with the rights is the worker's to tell
    real_time_ = become_real_time(rig_.real_time.priority + 1).empty();
    sched_getaffinity(0, sizeof anywhere_, &anywhere_);
    prefault_stack();
    watch();
    if (!page_.outputs_safe) make_safe();
    int status = 0;
    while (waitpid(worker_, &status, 0) < 0 && errno == EINTR) continue;
    if (loop_watch_.joinable()) loop_watch_.join();
    const int ended = report(status);
    if (safe_ && !*safe_) sound_alarm(cause(status));
    return ended;
  }

 private:
  /// Returns when the worker is dead.
  void watch() {
    const sigset_t stops = guardian_stop_signals();
    const int signals = signalfd(-1, &stops, SFD_CLOEXEC | SFD_NONBLOCK);
    const int worker = static_cast<int>(syscall(SYS_pidfd_open, worker_, 0));
    pollfd polled[] = {{worker, POLLIN, 0}, {signals, POLLIN, 0}, {page_.event_fd, POLLIN, 0}};
    for (;;) {
      const int timeout_ms =
          worker >= 0 ? static_cast<int>(watchdog_.until_next_check() / milliseconds(1)) : 1;
      // Without the right to descriptors poll(2) tells nothing of those that are open.
      const bool blind = poll(polled, 3, timeout_ms) < 0 && errno != EINTR;
      if (blind) poll(nullptr, 0, 1);
      if (worker >= 0 && !blind ? polled[0].revents != 0 : dead_without_pidfd()) return;
      page_.guardian_heartbeat_ns = to_ns(clock_.now());
      pass_stops_on(signals);
      if (blind || polled[2].revents != 0) handle_notification();
      watch_for_hangs();
    }
  }

  void pass_stops_on(int signals) {
    signalfd_siginfo info{};
    while (read(signals, &info, sizeof info) == sizeof info) {
      service_.say(stopping_words());
      kill(worker_, SIGTERM);
      if (!known(kill_at_)) kill_at_ = clock_.now() + kTimeToStop;
    }
  }

  /// The outputs are safe at once, but the journal may need all of that time: more than a service manager
  /// grants to one whose guardian is gone.
  static std::string stopping_words() {
    const Duration needed = kTimeToStop + kPatience;
    return "STOPPING=1\nEXTEND_TIMEOUT_USEC=" + std::to_string(needed / microseconds(1));
  }

  void handle_notification() {
    std::uint64_t rings = 0;
    if (read(page_.event_fd, &rings, sizeof rings) < 0) return;
    if (loop_died_) kill(worker_, SIGKILL);  // should it have been that thread alone
    if (page_.lines_released && !safe_) {
      make_safe();
      if (!known(kill_at_)) kill_at_ = clock_.now() + kTimeToStop;
    }
    if (page_.ready && !said_ready_) {
      said_ready_ = true;
      start_loop_watch();
      service_.say("READY=1\nSTATUS=" + ready_words());
    }
  }

  /// At the guardian's priority. Without such a thread the loop's death shows when its process is gone.
  void start_loop_watch() {
    try {
      loop_watch_ = std::thread([this] { watch_loop(); });
    } catch (const std::system_error&) {
    }
  }

  void watch_loop() {
    sched_setaffinity(0, sizeof anywhere_, &anywhere_);
    if (!page_.loop.wait_for_death()) return;
    set_inactive();
    loop_died_ = true;
    page_.notify();
  }

  void watch_for_hangs() {
    const MonoTime now = clock_.now();
    if (known(kill_at_) && now > kill_at_) kill(worker_, SIGKILL);
    const Heartbeats marks{from_ns(page_.loop_heartbeat_ns), from_ns(page_.publisher_heartbeat_ns),
                           page_.shot_under_way};
    // A worker that stops, or whose loop had to end, turns no more.
    const bool watched = !page_.outputs_safe && !page_.lines_released;
    const Watchdog::Verdict verdict =
        watched ? watchdog_.check(marks, now, current_core_ >= 0) : Watchdog::Verdict::healthy;
    move_to_loop_core(watched && real_time_ && watchdog_.suspect() ? page_.loop_cpu.load() : kAnywhere);
    tell_of_standstill(verdict == Watchdog::Verdict::loop_stands_still, marks.loop, now);
    if (verdict == Watchdog::Verdict::healthy) {
      tell_of_hosts(now);
      return beat(now);
    }
    if (verdict != Watchdog::Verdict::loop_stands_still) end_hung_worker(verdict, now);
  }

  void end_hung_worker(Watchdog::Verdict verdict, MonoTime now) {
    if (hung_ != Watchdog::Verdict::healthy) return;
    hung_ = verdict;
    const bool loop = verdict == Watchdog::Verdict::loop_hung;
    kill_at_ = now + kGrace;
    kill(worker_, loop ? SIGKILL : SIGTERM);
    if (loop) make_safe();  // word of its death may not come: a debugger that stands still keeps it
  }

  /// A loop without a shot is waited for: a hung one is the service manager's to end.
  void tell_of_standstill(bool stands_still, MonoTime last_turn, MonoTime now) {
    if (stands_still == known(still_since_)) return;
    std::string words = "the loop stands still, no shot is under way: waiting for it";
    if (!stands_still)
      words = "the loop turns again after " + std::to_string((now - still_since_) / milliseconds(1)) + " ms";
    still_since_ = stands_still ? last_turn : kNoTime;
    console_.say(words);
    service_.say("STATUS=" + (stands_still ? words : ready_words()));
  }

  /// A network that lets status out but no command in shows here.
  std::string ready_words() {
    const std::int64_t heard_ns = page_.host_heard_ns;
    if (heard_ns == 0) return "ready, no host heard yet";
    const Duration since = clock_.now().time_since_epoch() + clock_.suspended() - Duration{heard_ns};
    return "ready, a host heard " + std::to_string(since / milliseconds(1000)) + " s ago";
  }

  void tell_of_hosts(MonoTime now) {
    if (!said_ready_ || now < next_words_) return;
    service_.say("STATUS=" + ready_words());
    next_words_ = now + kWordsEvery;
  }

  /// On the core that the loop ran on last: what keeps the loop from turning there keeps the guardian, too,
  /// unless it is the loop itself. A core that cannot be had is not looked at.
  void move_to_loop_core(int cpu) {
    if (cpu == current_core_) return;
    current_core_ = cpu != kAnywhere && pin_to_cpu(cpu).empty() ? cpu : kAnywhere;
    if (current_core_ == kAnywhere) sched_setaffinity(0, sizeof anywhere_, &anywhere_);
  }

  /// The service manager's watchdog: only a guardian that comes round and finds all well feeds it.
  void beat(MonoTime now) {
    const Duration watchdog = service_.watchdog();
    if (watchdog == Duration{} || now < next_beat_) return;
    service_.say("WATCHDOG=1");
    next_beat_ = now + watchdog / 4;
  }

  bool dead_without_pidfd() const {
    siginfo_t info{};
    return waitid(P_PID, static_cast<id_t>(worker_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           info.si_pid != 0;
  }

  bool set_inactive() {
    const std::unique_lock lock(setting_, kSettingPatience);  // without it, if need be
    return outputs_.make_inactive();
  }

  /// By the lines that the guardian holds; where they are dead, as of a chip that was plugged in again, by
  /// new ones.
  void make_safe() {
    if (set_inactive() && outputs_.confirms()) {
      safe_.emplace();
      return;
    }
    const std::unique_lock lock(setting_, kSettingPatience);
    outputs_.release();
    safe_.emplace(access_.make_inactive(kPatience));
  }

  /// The workstations hear it, several times as some may get lost. By a process of its own, without the
  /// lines: whoever started strobed waits for its end to try the outputs once more (--safe).
  void sound_alarm(const std::string& cause) {
    if (fork() != 0) return;
    outputs_.release();
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);  // systemd may end it at once
    become_ordinary();
    const std::string words = std::string(messages::kDangerWords) +
                              ": press the e-stop, and cut the power of lamps and machine: " + cause + "; " +
                              safe_->error().message;
    for (int i = 0; i < kAlarms; ++i) {
      tell_(page_.boot_id, words);
      poll(nullptr, 0, kAlarmEvery_ms);
    }
    _exit(0);
  }

  std::string cause(int status) const {
    if (page_.lines_released) return "an output could not be switched off";
    if (hung_ == Watchdog::Verdict::loop_hung) return "the loop hung and the worker was killed";
    if (hung_ == Watchdog::Verdict::publisher_hung) return "the publisher hung and the worker was stopped";
    if (WIFEXITED(status)) return "the worker ended with status " + std::to_string(WEXITSTATUS(status));
    return "the worker died of signal " + std::to_string(WTERMSIG(status)) + " (" +
           strsignal(WTERMSIG(status)) + ")";
  }

  int report(int status) {
    if (WIFEXITED(status) && !safe_ && hung_ == Watchdog::Verdict::healthy) return WEXITSTATUS(status);
    std::string words = cause(status) + "; ";
    if (!safe_) {
      words += "it had made the outputs inactive";
    } else if (*safe_) {
      words += "the guardian made the outputs inactive";
    } else {
      words += std::string(messages::kDangerWords) + ": " + safe_->error().message;
    }
    console_.say(words);
    service_.say("STATUS=" + words);
    return kExitFailed;
  }

  const Rig& rig_;
  pid_t worker_;
  SharedStatus& page_;
  HeldOutputs& outputs_;
  const OutputAccess& access_;
  const TellDanger& tell_;
  Console console_;  // before real-time priority, which its thread is not to have
  SystemClock clock_;
  ServiceNotify service_;
  Watchdog watchdog_;
  std::timed_mutex setting_;          ///< of the outputs
  std::optional<Result<void>> safe_;  ///< once it was tried to make the outputs safe
  std::thread loop_watch_;
  std::atomic<bool> loop_died_{false};
  Watchdog::Verdict hung_ = Watchdog::Verdict::healthy;
  MonoTime kill_at_ = kNoTime;      ///< however well it seems
  MonoTime still_since_ = kNoTime;  ///< the loop's last turn, if it stands still
  MonoTime next_beat_{};
  MonoTime next_words_{};
  bool real_time_ = false;
  cpu_set_t anywhere_{};
  int current_core_ = kAnywhere;
  bool said_ready_ = false;
};

}  // namespace

int run_guardian(const Rig& rig, const OutputAccess& access, const Work& work, const TellDanger& tell) {
  void* memory =
      mmap(nullptr, sizeof(SharedStatus), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) {
    std::fprintf(stderr, "strobed: mmap: %s\n", std::strerror(errno));
    return kExitFailed;
  }
  auto* page = new (memory) SharedStatus;
  page->event_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  set_signal_policy();
  const auto outputs = access.hold();
  if (!outputs) {
    std::fprintf(stderr, "strobed: %s\n", outputs.error().message.c_str());
    return kExitBadInput;
  }
  use_small_stacks();
  page->guardian.hold();
  page->guardian_pid = getpid();
  const pid_t worker = fork();
  if (worker < 0) {
    std::fprintf(stderr, "strobed: fork: %s\n", std::strerror(errno));
    return kExitFailed;
  }
  if (worker == 0) become_worker(work, *page, **outputs);
  return Guardian(rig, worker, *page, **outputs, access, tell).run();
}

}  // namespace strobe::firmware
