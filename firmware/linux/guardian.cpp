#include "firmware/linux/guardian.hpp"

#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <new>
#include <optional>

#include "firmware/linux/gpio_lines.hpp"
#include "firmware/linux/monotonic_clock.hpp"
#include "firmware/linux/real_time.hpp"

namespace strobe::firmware {

namespace {

constexpr int kWatchPeriodMs = 100;
constexpr Duration kHangs =
    milliseconds(500);  // the loop turns every 50 ms; a virtual machine may pause for 200 ms
constexpr Duration kPatience = milliseconds(1000);

sigset_t stop_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&set, signal);
  return set;
}

[[noreturn]] void become_worker(pid_t guardian, const std::function<int(WorkerPage&)>& work,
                                WorkerPage& page) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != guardian) _exit(kExitFailed);
  // A core dump of locked memory would take seconds, with the outputs as they are.
  prctl(PR_SET_DUMPABLE, 0);
  const int status = work(page);
  std::fflush(nullptr);
  _exit(status);
}

class Guardian {
 public:
  Guardian(const Rig& rig, pid_t worker, WorkerPage& page) : rig_(rig), worker_(worker), page_(page) {}

  int run() {
    // What is wrong with the chip or the rights is the worker's to tell.
    if (auto prepared = OutputTakeover::prepare(rig_)) takeover_.emplace(std::move(*prepared));
    lock_memory();
    become_real_time(rig_.real_time.priority + 1);
    prefault_stack();
    watch();
    const MonoTime noticed = clock_.now();
    const bool needed = page_.lines_taken && !page_.outputs_safe;
    const Result<void> safe = needed ? make_safe() : Result<void>{};
    const Duration took = clock_.now() - noticed;
    int status = 0;
    while (waitpid(worker_, &status, 0) < 0 && errno == EINTR) continue;
    return report(status, needed, safe, took);
  }

 private:
  /// Returns when the worker is dead.
  void watch() {
    const sigset_t stops = stop_signals();
    const int signals = signalfd(-1, &stops, SFD_CLOEXEC | SFD_NONBLOCK);
    const int worker = static_cast<int>(syscall(SYS_pidfd_open, worker_, 0));
    pollfd polled[] = {{worker, POLLIN, 0}, {signals, POLLIN, 0}};
    int stale_looks = 0;
    for (;;) {
      poll(polled, 2, worker >= 0 ? kWatchPeriodMs : 1);
      if (worker >= 0 ? polled[0].revents != 0 : dead_without_pidfd()) return;
      signalfd_siginfo info{};
      while (read(signals, &info, sizeof info) == sizeof info) kill(worker_, SIGTERM);
      const MonoTime turned{page_.turned_ns};
      const bool stale = turned.ns != 0 && !page_.outputs_safe && clock_.now() - turned > kHangs;
      // Twice in a row: if the whole machine stood still, the worker is given its turn first.
      stale_looks = stale ? stale_looks + 1 : 0;
      if (stale_looks == 2) {
        hung_ = true;
        kill(worker_, SIGKILL);
      }
    }
  }

  bool dead_without_pidfd() const {
    siginfo_t info{};
    return waitid(P_PID, static_cast<id_t>(worker_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           info.si_pid != 0;
  }

  Result<void> make_safe() {
    if (!takeover_) {
      auto prepared = OutputTakeover::prepare(rig_);
      if (!prepared) return tl::unexpected(prepared.error());
      takeover_.emplace(std::move(*prepared));
    }
    return takeover_->drive_inactive(kPatience);
  }

  int report(int status, bool needed, const Result<void>& safe, Duration took) const {
    const bool exited = WIFEXITED(status);
    if (exited && !needed) return WEXITSTATUS(status);
    char cause[96];
    if (hung_) {
      std::snprintf(cause, sizeof cause, "the worker hung and was killed");
    } else if (exited) {
      std::snprintf(cause, sizeof cause, "the worker ended with status %d", WEXITSTATUS(status));
    } else {
      std::snprintf(cause, sizeof cause, "the worker died of signal %d (%s)", WTERMSIG(status),
                    strsignal(WTERMSIG(status)));
    }
    if (!safe) {
      std::fprintf(stderr, "strobed: %s; THE OUTPUTS MAY BE ACTIVE: %s\n", cause,
                   safe.error().message.c_str());
    } else if (needed) {
      std::fprintf(stderr, "strobed: %s; the guardian made the outputs inactive in %lld us\n", cause,
                   static_cast<long long>(took.ns / 1000));
    } else {
      std::fprintf(stderr, "strobed: %s; it had no outputs\n", cause);
    }
    return kExitFailed;
  }

  const Rig& rig_;
  pid_t worker_;
  WorkerPage& page_;
  MonotonicClock clock_;
  std::optional<OutputTakeover> takeover_;
  bool hung_ = false;
};

}  // namespace

int guard(const Rig& rig, const std::function<int(WorkerPage&)>& work) {
  void* memory = mmap(nullptr, sizeof(WorkerPage), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) {
    std::fprintf(stderr, "strobed: mmap: %s\n", std::strerror(errno));
    return kExitFailed;
  }
  auto* page = new (memory) WorkerPage;
  const sigset_t stops = stop_signals();
  sigprocmask(SIG_BLOCK, &stops, nullptr);
  const pid_t guardian = getpid();
  const pid_t worker = fork();
  if (worker < 0) {
    std::fprintf(stderr, "strobed: fork: %s\n", std::strerror(errno));
    return kExitFailed;
  }
  if (worker == 0) become_worker(guardian, work, *page);
  return Guardian(rig, worker, *page).run();
}

}  // namespace strobe::firmware
