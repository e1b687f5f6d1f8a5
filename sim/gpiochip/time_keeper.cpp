#include "sim/gpiochip/time_keeper.hpp"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"

namespace strobe::sim::gpio {
namespace {

constexpr int kPriority = 40;  // below strobed, above everything else
constexpr std::int64_t kUs = 1'000;
constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kFirstLook = 20 * kUs;  // after a thread was woken
constexpr std::int64_t kLastLook = 2 * kMs;    // while one works for long
constexpr std::int64_t kListEvery = 20 * kMs;  // programs that have ended
constexpr std::int64_t kHangs = 100 * kMs;     // of a loop's own time, without a look at the clock
constexpr std::int64_t kLongestHandover = 1'000 * kMs;
constexpr std::int64_t kEpoch2000 = INT64_C(946'684'800'000'000'000);

class Keeping {
 public:
  explicit Keeping(State& state)
      : state_(state), time_(state.time), threads_(static_cast<pid_t>(::syscall(SYS_gettid))) {}

  void turn() {
    time_.beats.fetch_add(1);
    if (!all_asleep()) return look_again_later();
    if (time_.begun.load() == 0) return rest(kLastLook);
    pause_ns_ = kFirstLook;
    TimedWait* const next = earliest();
    if (next == nullptr) return rest(kLastLook);
    const std::int64_t until = next->until_ns.load();
    if (until == kNever) return;
    if (!terminal_is_quiet() && !rig_is_up()) return look_again_later();
    if (!has_come(until)) return;
    wake(*next, until);
  }

 private:
  void list_programs() {
    const std::int64_t wall = sys::now_ns();
    programs_.clear();
    for (std::atomic<std::int32_t>& program : time_.programs) {
      const std::int32_t pid = program.load();
      if (pid == 0) continue;
      if (wall >= list_again_ns_ && ::kill(pid, 0) != 0 && errno == ESRCH) {
        program.store(0);
        continue;
      }
      programs_.push_back(pid);
    }
    if (wall >= list_again_ns_) list_again_ns_ = wall + kListEvery;
    threads_.watch(programs_);
  }

  bool all_asleep() {
    list_programs();
    return threads_.all_asleep() ? nobody_has_joined() && no_slice_is_due() : loop_hangs();
  }

  /// A child that was made since the programs were listed runs, though its parent sleeps again.
  bool nobody_has_joined() {
    return std::all_of(std::begin(time_.programs), std::end(time_.programs), [this](const auto& program) {
      const std::int32_t pid = program.load();
      return pid == 0 || std::find(programs_.begin(), programs_.end(), pid) != programs_.end();
    });
  }

  /// One whose instant has come, but which has not looked yet.
  bool no_slice_is_due() {
    const std::int64_t now = time_.now_ns.load();
    return std::none_of(std::begin(time_.waits), std::end(time_.waits), [now](const TimedWait& wait) {
      return wait.tid.load() != 0 && wait.wake_by.load() == WakeBy::itself && wait.until_ns.load() <= now;
    });
  }

  /// The kernel hands over what was written to a terminal by a thread of its own. What never arrives (its
  /// writer was killed meanwhile, or has taken it back) is waited for once.
  bool terminal_is_quiet() {
    const std::uint64_t written = time_.terminal_written.load();
    if (written == time_.terminal_taken.load()) {
      terminal_since_ns_ = 0;
      return true;
    }
    if (terminal_since_ns_ == 0) terminal_since_ns_ = sys::now_ns();
    if (sys::now_ns() - terminal_since_ns_ < kLongestHandover) return false;
    time_.terminal_taken.store(written);
    terminal_since_ns_ = 0;
    return true;
  }

  /// A thread of the rig's program knows that something has come, and waits for its turn.
  bool rig_is_up() {
    const std::int64_t now = time_.now_ns.load();
    return std::any_of(std::begin(time_.waits), std::end(time_.waits), [now](const TimedWait& wait) {
      return wait.pid.load() == ::getpid() && wait.tid.load() != 0 && wait.until_ns.load() <= now;
    });
  }

  /// The only one that runs is a loop that no longer looks at the clock: time goes on without it.
  bool loop_hangs() {
    const pid_t tid = time_.loop_tid.load();
    if (tid == 0 || threads_.running() != tid) return false;
    const std::uint64_t looks = time_.loop_looks.load();
    const std::uint64_t ran = threads_.consumed_ns(time_.loop_pid.load(), tid);
    if (looks != looks_) {
      looks_ = looks;
      ran_ns_ = ran;
    }
    return ran - ran_ns_ > static_cast<std::uint64_t>(kHangs);
  }

  void look_again_later() {
    // While the loop runs it will say when it lies down.
    const std::uint32_t asleep = time_.asleep.load();
    const bool loop_runs = threads_.running() == time_.loop_tid.load();
    if (loop_runs) {
      sys::futex_wait(&time_.asleep, asleep, sys::now_ns() + kLastLook);
    } else {
      sys::sleep_ns(pause_ns_);
    }
    pause_ns_ = std::min(pause_ns_ + pause_ns_ / 4, kLastLook);
  }

  /// The program's thread ids count up, whichever slot one has: the same order in each run.
  TimedWait* earliest() {
    TimedWait* found = nullptr;
    for (TimedWait& wait : time_.waits) {
      const std::int64_t until = wait.until_ns.load();
      if (wait.tid.load() == 0 || until == kNever) continue;
      if (found == nullptr || until < found->until_ns.load() ||
          (until == found->until_ns.load() && wait.tid.load() < found->tid.load()))
        found = &wait;
    }
    return found;
  }

  /// Lets time go on. False: the machine's has not come so far.
  bool has_come(std::int64_t until) {
    const std::int64_t now = time_.now_ns.load();
    if (time_.pace.load() == Pace::wall) {
      const std::int64_t wall = sys::now_ns();
      if (wall < until) {
        go_on(std::max(now, wall));
        rest(std::min(until - wall, kMs / 2));
        return false;
      }
    }
    go_on(std::max(now, until));
    return true;
  }

  void go_on(std::int64_t now) { time_.now_ns.store(now); }

  void rest(std::int64_t duration) {
    const std::uint32_t asleep = time_.asleep.load();
    sys::futex_wait(&time_.asleep, asleep, sys::now_ns() + duration);
  }

  void wake(TimedWait& wait, std::int64_t until) {
    const WakeBy wake_by = wait.wake_by.load();
    if (wake_by != WakeBy::itself && !wait.until_ns.compare_exchange_strong(until, kNever)) return;
    time_.next_ns.store(next_of_others(wait));
    threads_.expect_running(wait.tid.load());
    wait.woken.fetch_add(1);
    switch (wake_by) {
      case WakeBy::signal:
        if (sys::signal_thread(wait.pid.load(), wait.tid.load(), kWaitSignal) != 0) wait.tid.store(0);
        return;
      case WakeBy::word:
        sys::futex_wake_all(&wait.woken);
        return;
      case WakeBy::ring:
        wake_waiting(state_);
        return;
      case WakeBy::itself:
        return;
    }
  }

  std::int64_t next_of_others(const TimedWait& woken) {
    std::int64_t next = kNever;
    for (TimedWait& wait : time_.waits) {
      const std::int32_t tid = wait.tid.load();
      if (tid == 0 || &wait == &woken || tid == time_.loop_tid.load() || wait.wake_by.load() == WakeBy::ring)
        continue;
      next = std::min(next, wait.until_ns.load());
    }
    return next;
  }

  State& state_;
  RigTime& time_;
  ThreadStates threads_;
  std::vector<pid_t> programs_;
  std::int64_t list_again_ns_ = 0;
  std::int64_t pause_ns_ = kFirstLook;
  std::int64_t terminal_since_ns_ = 0;  ///< not quiet
  std::uint64_t looks_ = 0;             ///< of the loop
  std::uint64_t ran_ns_ = 0;
};

void set_clocks(State& state, const std::optional<TimeKeeper::Repeatable>& repeatable) {
  RigTime& time = state.time;
  time.next_ns.store(kNever);
  time.rig_ns.store(kNever);
  const std::int64_t wall = sys::now_ns();
  time.now_ns.store(wall);
  time.realtime_less_ns.store(sys::clock_ns(CLOCK_REALTIME) - wall);
  time.boottime_less_ns.store(sys::clock_ns(CLOCK_BOOTTIME) - wall);
  if (!repeatable) return;
  state.epoch_ns = 0;
  time.now_ns.store(repeatable->start_s * 1'000'000'000);
  time.realtime_less_ns.store(kEpoch2000);
  time.boottime_less_ns.store(0);
  time.seed = repeatable->seed;
}

constexpr std::size_t kRoom = 16384;
constexpr std::int64_t kLongestPreemption = 1'000'000'000;  // then the kernel tells less than is thought
thread_local std::array<char, kRoom> stat_text;

/// As in proc(5).
char state_of(const char* stat) {
  const char* const end_of_name = strrchr(stat, ')');
  return end_of_name != nullptr && end_of_name[1] == ' ' ? end_of_name[2] : '?';
}

bool is_asleep(char state) { return strchr("STtZX", state) != nullptr; }

struct Schedule {
  std::uint64_t ran_ns = 0;
  std::uint64_t runs = 0;
};

/// Time on a processor, time of waiting for one, and how often it got one.
Schedule schedule_of(const char* schedstat) {
  Schedule schedule;
  if (schedstat == nullptr) return schedule;
  char* at = nullptr;
  schedule.ran_ns = strtoull(schedstat, &at, 10);
  strtoull(at, &at, 10);
  schedule.runs = strtoull(at, &at, 10);
  return schedule;
}

}  // namespace

TimeKeeper::TimeKeeper(State& state, Pace pace, const std::optional<Repeatable>& repeatable) : state_(state) {
  set_clocks(state, repeatable);
  prepare_waits();
  join_time(state, ::getpid());
  state.time.begun.store(0);
  state.time.pace.store(pace);
  thread_ = std::thread([this] { run(); });
}

TimeKeeper::~TimeKeeper() {
  stopping_ = true;
  thread_.join();
  RigTime& time = state_.time;
  time.ahead_ns.store(time.now_ns.load() - sys::now_ns());
  time.pace.store(Pace::machine);
  for (TimedWait& wait : time.waits) {
    if (wait.tid.load() == 0 || wait.until_ns.load() == kNever) continue;
    wait.woken.fetch_add(1);
    sys::futex_wake_all(&wait.woken);
    sys::signal_thread(wait.pid.load(), wait.tid.load(), kWaitSignal);
  }
  time.turns.fetch_add(1);
  sys::futex_wake_all(&time.turns);
  wake_waiting(state_);
}

void TimeKeeper::run() {
  // Everybody waits for it. Without the permission they wait longer where the machine is busy.
  sched_param parameters{};
  parameters.sched_priority = kPriority;
  static_cast<void>(pthread_setschedparam(pthread_self(), SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters));
  Keeping keeping(state_);
  while (!stopping_) keeping.turn();
}

ThreadStates::File::File(const char* path) : fd_(::open(path, O_RDONLY | O_CLOEXEC)) {}
ThreadStates::File::File(File&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
ThreadStates::File::~File() {
  if (fd_ >= 0) ::close(fd_);
}

const char* ThreadStates::File::read() {
  const ssize_t size = fd_ < 0 ? -1 : ::pread(fd_, stat_text.data(), stat_text.size() - 1, 0);
  if (size <= 0) return nullptr;
  stat_text[static_cast<std::size_t>(size)] = '\0';
  return stat_text.data();
}

ThreadStates::ThreadStates(pid_t excepted) : excepted_(excepted), softnet_("/proc/net/softnet_stat") {}

void ThreadStates::watch(const std::vector<pid_t>& programs) {
  std::erase_if(programs_, [&](const auto& known) {
    return std::find(programs.begin(), programs.end(), known.first) == programs.end();
  });
  for (const pid_t pid : programs) programs_.try_emplace(pid);
}

void ThreadStates::list_new_threads(pid_t pid, Program& program) const {
  char path[64];
  snprintf(path, sizeof path, "/proc/%d/task", pid);
  struct stat status {};
  const std::uint64_t links = ::stat(path, &status) == 0 ? status.st_nlink : 0;
  if (links == program.links && links != 0) return;
  program.links = links;
  program.threads.clear();
  DIR* const folder = ::opendir(path);
  if (folder == nullptr) return;
  while (const dirent* entry = ::readdir(folder)) {
    const pid_t tid = atoi(entry->d_name);
    if (tid == 0 || tid == excepted_) continue;
    const auto open = [&path, tid](const char* name) {
      char file[96];
      snprintf(file, sizeof file, "%s/%d/%s", path, tid, name);
      return File(file);
    };
    program.threads.push_back({tid, open("stat"), open("schedstat"), open("wchan")});
  }
  ::closedir(folder);
}

std::uint64_t ThreadStates::activity() {
  std::uint64_t sum = 0;
  for (auto& [pid, program] : programs_)
    for (Thread& thread : program.threads) {
      const Schedule schedule = schedule_of(thread.schedstat.read());
      thread.activity = schedule.ran_ns + schedule.runs;
      sum += thread.activity;
    }
  return sum;
}

bool ThreadStates::sleeps(Program& program, Thread& thread) {
  const char* const stat = thread.stat.read();
  if (stat == nullptr) {
    program.links = 0;  // that one has ended, another may have begun
    return true;
  }
  if (is_asleep(state_of(stat))) return true;
  running_ = thread.tid;
  return false;
}

bool ThreadStates::all_sleep() {
  for (auto& [pid, program] : programs_)
    for (Thread& thread : program.threads)
      if (!sleeps(program, thread)) return false;
  return true;
}

/// A line a core; the 12th number, where there is one, is how many packets wait in it.
bool ThreadStates::network_is_quiet() {
  const char* at = softnet_.read();
  for (int column = 1; at != nullptr && *at != '\0'; ++column) {
    char* end = nullptr;
    const unsigned long value = strtoul(at, &end, 16);
    if (column == 12 && value != 0) return false;
    if (*end == '\n') column = 0;
    at = end == at ? nullptr : end + 1;
  }
  return true;
}

/// The kernel says where a thread sleeps only if it waits for no core. One that is preempted as it lies
/// down, or while wait(2) clears up after a child, is in the state of a sleeper, too, and goes on by
/// itself.
bool ThreadStates::has_settled(Program& program, Thread& thread) const {
  if (thread.activity == thread.settled) return true;
  const char* const stat = thread.stat.read();
  if (stat == nullptr || state_of(stat) != 'S') return true;
  const char* const wchan = thread.wchan.read();
  const bool told = wchan != nullptr && strcmp(wchan, "0") != 0;
  program.tells_wchan = program.tells_wchan || told;
  return told || !program.tells_wchan;
}

bool ThreadStates::all_have_settled() {
  std::uint64_t activity = 0;
  bool settled = true;
  for (auto& [pid, program] : programs_)
    for (Thread& thread : program.threads) {
      settled = settled && has_settled(program, thread);
      activity += thread.activity;
    }
  if (settled || activity != unsettled_) unsettled_since_ns_ = sys::now_ns();
  unsettled_ = activity;
  return settled || sys::now_ns() - unsettled_since_ns_ > kLongestPreemption;
}

bool ThreadStates::all_asleep() {
  for (auto& [pid, program] : programs_)
    for (Thread& thread : program.threads)
      if (thread.tid == running_ && !sleeps(program, thread)) return false;
  running_ = 0;
  // If nobody has run between the two sums, nobody was woken but by a datagram: who slept within, slept
  // throughout. New threads make the second one larger.
  const std::uint64_t before = activity();
  for (auto& [pid, program] : programs_) list_new_threads(pid, program);
  if (!network_is_quiet() || !all_sleep() || !all_have_settled() || activity() != before) return false;
  for (auto& [pid, program] : programs_)
    for (Thread& thread : program.threads) thread.settled = thread.activity;
  return true;
}

std::uint64_t ThreadStates::consumed_ns(pid_t pid, pid_t tid) {
  const auto program = programs_.find(pid);
  if (program == programs_.end()) return 0;
  for (Thread& thread : program->second.threads)
    if (thread.tid == tid) return schedule_of(thread.schedstat.read()).ran_ns;
  return 0;
}

}  // namespace strobe::sim::gpio
